// sigma as a function of intensity only, for the exponent x = gamma * kappa: weights of the darkest intensity and of
// the brightest.
fn scaling_curve_of(x: f32) -> vec2<f32> {
    let e = exp_of(-min(abs(x), MAX_EXPONENT));
    let convex = x >= 0.0;
    return vec2<f32>(select(1.0, e, convex), select(e, 1.0, convex));
}

// sigma of an intensity, clamped to 0..1, for the invariant point alpha.
fn scaling_curve_at(curve: vec2<f32>, intensity: f32, alpha: f32) -> f32 {
    let d = clamp(intensity, 0.0, 1.0);
    let a = clamp(alpha, INVARIANT_MARGIN, 1.0 - INVARIANT_MARGIN);
    let low = a * (1.0 - d);
    let high = d * (1.0 - a);
    return (curve.x * low + curve.y * high) / (curve.y * low + curve.x * high);
}

fn scaling(intensity: f32, x: f32, alpha: f32) -> f32 {
    return scaling_curve_at(scaling_curve_of(x), intensity, alpha);
}

// A channel times its scaling, finite unless it is NaN.
fn scaled(c: f32, sigma: f32) -> f32 {
    return select(clamp(c * sigma, -F32_MAX, F32_MAX), c, is_nan(c));
}
