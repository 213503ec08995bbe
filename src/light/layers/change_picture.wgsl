// The picture with the changes applied; its own bits where uncovered or unchanged. If layers hold more light than the
// picture, the change is reduced to the picture's share.

fn changed(c: f32, change: f32, layered: f32) -> f32 {
    let share = min(max(c, 0.0) / max(layered, MIN_POSITIVE), 1.0);
    let result = clamp(c + share * change, -F32_MAX, F32_MAX);
    return select(result, c, change == 0.0 || is_nan(c));
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() || !is_covered(id.x, id.y) {
        return;
    }
    let i = index_of(id.x, id.y);
    let by = change[i];
    let light = layered[i];
    red[i] = changed(red[i], by.x, light.x);
    green[i] = changed(green[i], by.y, light.y);
    blue[i] = changed(blue[i], by.z, light.z);
}
