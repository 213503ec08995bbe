// Radiance scaling of a picture by curvature that is used only here: it never goes through memory.

@group(0) @binding(0) var<uniform> params: ScaleParams;
@group(0) @binding(1) var<storage, read> covered: array<u32>;
@group(0) @binding(2) var<storage, read> conductance: array<f32>;
@group(0) @binding(3) var<storage, read> gradient: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read_write> red: array<f32>;
@group(0) @binding(5) var<storage, read_write> green: array<f32>;
@group(0) @binding(6) var<storage, read_write> blue: array<f32>;

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() {
        return;
    }
    let columns = columns_around(id.x);
    let first = id.y * STRIP_ROWS;
    let end = min(first + STRIP_ROWS, height());
    if !is_any_covered(id.x, first, end) {
        return;
    }
    // Values reused by the next row stay in registers.
    var above = row_around(columns, row_above(first));
    var here = row_around(columns, first);
    for (var y = first; y < end; y++) {
        let below = row_around(columns, row_below(y));
        let entries = fitted(above, here, below);
        let trace = params.resolution_factor * (entries.x + entries.z);
        if is_covered(id.x, y) && trace != 0.0 {
            scale_pixel(index_of(id.x, y), trace);
        }
        above = here;
        here = below;
    }
}
