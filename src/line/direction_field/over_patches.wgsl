// Visits all patches: each invocation takes the first one of its cell, and some of the further ones.
@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.columns || id.y >= params.rows {
        return;
    }
    let end = patches_end(further[0]);
    for (var i = id.y * params.columns + id.x; i < end; i += cell_count()) {
        if i >= cell_count() || held[i].x > 0u {
            visit(i);
        }
    }
}
