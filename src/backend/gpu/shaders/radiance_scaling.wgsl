// sigma(d) of an intensity d, clamped to 0..1, for the exponent x = gamma * kappa and the invariant point alpha.
fn scaling(intensity: f32, x: f32, alpha: f32) -> f32 {
    let e = exp_of(-min(abs(x), MAX_EXPONENT));
    let convex = x >= 0.0;
    let dark = select(1.0, e, convex);
    let bright = select(e, 1.0, convex);
    let d = clamp(intensity, 0.0, 1.0);
    let a = clamp(alpha, INVARIANT_MARGIN, 1.0 - INVARIANT_MARGIN);
    let low = a * (1.0 - d);
    let high = d * (1.0 - a);
    return (dark * low + bright * high) / (bright * low + dark * high);
}
