// Runs: what of a chain lies in so many cells one after the other along an axis. Sums over a chain are made run by run,
// so that they stay small.

// The cell at a place along the axis, and at one across it.
fn cell_at(along: u32, across: u32) -> u32 {
    if params.axis == 0u {
        return across * params.columns + along;
    }
    return along * params.columns + across;
}

// How many cells there are along the axis, and across it.
fn cells_along() -> u32 {
    return select(params.rows, params.columns, params.axis == 0u);
}

fn cells_across() -> u32 {
    return select(params.columns, params.rows, params.axis == 0u);
}
