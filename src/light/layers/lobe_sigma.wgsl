// The scaling of a lobe: its intensity is its own light over the white level.

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    let kappa = mapped_curvature(trace[i], params.gain);
    let scaled = term_scaling_sigma(lobe_luminance(i), params.white, kappa);
    sigma[i] = select(1.0, scaled, is_covered(id.x, id.y));
}
