// The entry of kernels that do one pixel an invocation, `at_pixel`: at column and row `id`, number `i`.

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < width() && id.y < height() {
        at_pixel(id.xy, index_of(id.x, id.y));
    }
}
