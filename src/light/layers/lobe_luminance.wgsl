// The luminance of a lobe's light, 0 where uncovered.

@group(0) @binding(5) var<storage, read_write> luminance: array<f32>;

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    luminance[i] = select(0.0, lobe_luminance(i), is_covered(id.x, id.y));
}
