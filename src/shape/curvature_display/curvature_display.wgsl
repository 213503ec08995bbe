// The curvature display: edges black, concave warm, convex cold, flat neutral, background white.

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    var shown = BACKGROUND;
    if is_covered(id.x, id.y) {
        let kappa = mapped_curvature(trace[i], params.gain);
        let toward = select(CONCAVE, CONVEX, kappa >= 0.0);
        shown = conductance[i] * (NEUTRAL + abs(kappa) * (toward - NEUTRAL));
    }
    red[i] = shown.x;
    green[i] = shown.y;
    blue[i] = shown.z;
}
