// The curvature display: edges black, concave warm, convex cold, flat neutral, background white.

fn at_pixel(id: vec2<u32>, i: u32) {
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
