// From the luminance of a picture to the optical density of the drawing.

@group(0) @binding(0) var<uniform> params: DensityParams;
@group(0) @binding(1) var<storage, read> covered: array<u32>;
@group(0) @binding(2) var<storage, read> red: array<f32>;
@group(0) @binding(3) var<storage, read> green: array<f32>;
@group(0) @binding(4) var<storage, read> blue: array<f32>;
// Any buffer if there is no alpha.
@group(0) @binding(5) var<storage, read> alpha: array<f32>;
// Densities at even steps of the square root of luminance, from 0 to white.
@group(0) @binding(6) var<storage, read> density_table: array<f32>;
@group(0) @binding(7) var<storage, read_write> densities: array<f32>;

override HAS_ALPHA: bool;

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    if !is_covered(id.x, id.y) {
        densities[i] = 0.0;
        return;
    }
    let weighted = red[i] * params.weight_r + green[i] * params.weight_g + blue[i] * params.weight_b;
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
