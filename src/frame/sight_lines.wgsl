// Sight lines, and the projection of tangents along them.

// The direction of the sight line at a position in pixels from the corner of the picture, y down, scaled to z = -1.
fn line(place: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(params.line.xy + params.line.zw * (place - 0.5), -1.0);
}

// The unit direction in the picture, y up, of a unit tangent; 0 where it points at the eye.
fn picture_direction(line: vec3<f32>, tangent: vec3<f32>) -> vec2<f32> {
    // Moving along the sight line does not change the position: cancel z.
    let across = tangent.xy + tangent.z * line.xy;
    if !(dot(across, across) > MIN_SEEN * MIN_SEEN * dot(line, line)) {
        return vec2<f32>(0.0);
    }
    let seen = across * vec2<f32>(1.0, params.pixel_shape);
    return seen / sqrt(dot(seen, seen));
}
