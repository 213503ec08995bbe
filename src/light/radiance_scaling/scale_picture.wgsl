// Radiance scaling of a picture by curvature computed earlier.

@group(0) @binding(0) var<uniform> params: ScaleParams;
@group(0) @binding(1) var<storage, read> covered: array<u32>;
@group(0) @binding(2) var<storage, read> trace: array<f32>;
@group(0) @binding(3) var<storage, read_write> red: array<f32>;
@group(0) @binding(4) var<storage, read_write> green: array<f32>;
@group(0) @binding(5) var<storage, read_write> blue: array<f32>;

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let i = index_of(id.x, id.y);
    if is_covered(id.x, id.y) && trace[i] != 0.0 {
        scale_pixel(i, trace[i]);
    }
}
