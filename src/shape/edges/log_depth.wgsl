// The logarithm of depth where covered, 0 elsewhere: the map for silhouettes.

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    var log = 0.0;
    if is_covered(id.x, id.y) {
        log = ln(depth[i]);
    }
    log_depth[i] = log;
}
