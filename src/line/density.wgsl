// From the luminance of a picture to the optical density of the drawing.

override HAS_ALPHA: bool;

fn at_pixel(id: vec2<u32>, i: u32) {
    if !is_covered(id.x, id.y) {
        densities[i] = 0.0;
        return;
    }
    let weighted = red[i] * params.weights.x + green[i] * params.weights.y + blue[i] * params.weights.z;
    var share = weighted / params.white;
    var is_number = !is_nan(share);
    if HAS_ALPHA {
        // A rim that covers half a pixel is as light as the rest.
        is_number = is_number && !is_nan(alpha[i]);
        share /= clamp(alpha[i], LEAST_ALPHA, 1.0);
    }
    // A NaN is black.
    var seen = 0.0;
    if is_number && share > 0.0 {
        seen = min(share, 1.0);
    }
    let at = DENSITY_STEPS * sqrt(seen);
    let step = min(floor(at), DENSITY_STEPS - 1.0);
    let a = density_table[u32(step)];
    let b = density_table[u32(step) + 1u];
    densities[i] = a + (at - step) * (b - a);
}
