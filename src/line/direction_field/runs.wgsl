// Runs: the part of a chain in a fixed number of consecutive cells along an axis. Sums over a chain are computed run by
// run, so that they stay small.

// The cell at a place along the axis, and at one across it.
fn cell_at(along: u32, across: u32) -> u32 {
    if params.axis == 0u {
        return across * params.columns + along;
    }
    return along * params.columns + across;
}

// Number of cells along the axis, and across it.
fn cells_along() -> u32 {
    return select(params.rows, params.columns, params.axis == 0u);
}

fn cells_across() -> u32 {
    return select(params.columns, params.rows, params.axis == 0u);
}

// Iterates over the patches of each run, from the first to the last and back.
@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x * RUN_CELLS >= cells_along() || id.y >= cells_across() {
        return;
    }
    let begin = id.x * RUN_CELLS;
    let end = min(begin + RUN_CELLS, cells_along());
    for (var along = begin; along < end; along++) {
        let cell = cell_at(along, id.y);
        let own = held[cell];
        for (var k = 0u; k < own.x; k++) {
            let i = patch_of(cell, own, k);
            go_on(i, select(links[i][2u * params.axis], NO_PATCH, along == begin), along - begin);
        }
    }
    for (var along = end; along > begin; along--) {
        let cell = cell_at(along - 1u, id.y);
        let own = held[cell];
        for (var k = 0u; k < own.x; k++) {
            let i = patch_of(cell, own, k);
            go_back(i, select(links[i][2u * params.axis + 1u], NO_PATCH, along == end), along - 1u - begin);
        }
    }
}
