// Radiance scaling of a pixel of a finished picture: intensity is its luminance over the white level.

fn scale_pixel(i: u32, trace: f32) {
    let rgb = vec3<f32>(red[i], green[i], blue[i]);
    let weighted = rgb.x * params.weight_r + rgb.y * params.weight_g + rgb.z * params.weight_b;
    let exponent = params.scaling * mapped_curvature(trace, params.gain);
    let sigma = scaling(weighted / params.white, exponent, params.invariant_point);
    // A NaN makes all three channels NaN; so do infinities of both signs.
    let has_nan = is_nan(rgb.x) || is_nan(rgb.y) || is_nan(rgb.z) || is_nan(weighted);
    let nan = bitcast<f32>(params.nan_bits);
    red[i] = select(scaled(rgb.x, sigma), nan, has_nan);
    green[i] = select(scaled(rgb.y, sigma), nan, has_nan);
    blue[i] = select(scaled(rgb.z, sigma), nan, has_nan);
}
