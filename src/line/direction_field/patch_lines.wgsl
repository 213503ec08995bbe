// Position of a patch: columns and rows from the corner of the picture.
fn middle_of(i: u32) -> vec2<f32> {
    return vec2<f32>(corner_of(patches[i].cell)) + 0.5 * f32(params.cell_px) + patches[i].offset;
}

// The tangents that become the picture's x and y when the unit normal is rotated to the viewer by the shortest way,
// unless it points straight away.
struct Tangents {
    are_there: bool,
    x: vec3<f32>,
    y: vec3<f32>,
}

fn upright_tangents(normal: vec3<f32>) -> Tangents {
    let both = normal + vec3<f32>(0.0, 0.0, 1.0);
    return Tangents(
        both.z > MIN_UPRIGHT,
        vec3<f32>(1.0, 0.0, 0.0) - normal.x / both.z * both,
        vec3<f32>(0.0, 1.0, 0.0) - normal.y / both.z * both,
    );
}
