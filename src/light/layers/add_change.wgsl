// Adds the change of the radiance (direct + indirect) * color by a term, and that radiance, to two sums.

override HAS_DIRECT: bool;
override HAS_INDIRECT: bool;
override HAS_COLOR: bool;
override IS_FIRST: bool;

fn radiance(at: u32) -> f32 {
    var from_lights = 0.0;
    var from_surfaces = 0.0;
    var own = 1.0;
    if HAS_DIRECT {
        from_lights = direct[at];
    }
    if HAS_INDIRECT {
        from_surfaces = indirect[at];
    }
    if HAS_COLOR {
        own = color[at];
    }
    return limited((from_lights + from_surfaces) * own, MAX_RADIANCE);
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let plane = width() * height();
    let i = index_of(id.x, id.y);
    let rgb = vec3<f32>(radiance(i), radiance(plane + i), radiance(2u * plane + i));
    var changed_so_far = vec3<f32>(0.0);
    var light_so_far = vec3<f32>(0.0);
    if !IS_FIRST {
        changed_so_far = change[i].xyz;
        light_so_far = layered[i].xyz;
    }
    change[i] = vec4<f32>(changed_so_far + (sigma[i] - 1.0) * rgb, 0.0);
    layered[i] = vec4<f32>(light_so_far + rgb, 0.0);
}
