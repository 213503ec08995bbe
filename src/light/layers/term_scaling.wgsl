// The scaling of a term of the light by its own luminance.

// `value` between 0 and `most`; 0 for NaN.
fn limited(value: f32, most: f32) -> f32 {
    return select(0.0, min(value, most), value > 0.0 && !is_nan(value));
}

fn term_scaling_sigma(luminance: f32, white: f32, kappa: f32) -> f32 {
    let intensity = limited(luminance / white, 1.0);
    return scaling(intensity, params.magnitude * kappa, params.invariant_point);
}
