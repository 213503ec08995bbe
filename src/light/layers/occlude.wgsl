// Radiance scaling by ambient occlusion: the intensity of ambient light is the share that arrives.

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    let kappa = mapped_curvature(trace[i], params.gain);
    if is_covered(id.x, id.y) && kappa != 0.0 {
        let sigma = term_scaling_sigma(occlusion[i], 1.0, kappa);
        red[i] = scaled(red[i], sigma);
        green[i] = scaled(green[i], sigma);
        blue[i] = scaled(blue[i], sigma);
    }
}
