// Radiance scaling of a finished picture: intensity is its luminance over the white level.

fn at_pixel(id: vec2<u32>, i: u32) {
    if !is_covered(id.x, id.y) || trace[i] == 0.0 {
        return;
    }
    let rgb = vec3<f32>(red[i], green[i], blue[i]);
    let weighted = rgb.x * params.weights.x + rgb.y * params.weights.y + rgb.z * params.weights.z;
    let kappa = mapped_curvature(trace[i], params.gain);
    let exponent = select(params.magnitude.y, params.magnitude.x, kappa >= 0.0) * kappa;
    let sigma = scaling(weighted / params.white, exponent, params.invariant_point);
    // A NaN makes all three channels NaN; so do infinities of both signs.
    let has_nan = is_nan(rgb.x) || is_nan(rgb.y) || is_nan(rgb.z) || is_nan(weighted);
    let nan = bitcast<f32>(params.nan_bits);
    red[i] = select(scaled(rgb.x, sigma), nan, has_nan);
    green[i] = select(scaled(rgb.y, sigma), nan, has_nan);
    blue[i] = select(scaled(rgb.z, sigma), nan, has_nan);
}
