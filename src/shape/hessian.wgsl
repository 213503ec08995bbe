// The Hessian of the height field.

@group(0) @binding(0) var<uniform> params: HessianParams;
@group(0) @binding(1) var<storage, read> covered: array<u32>;
@group(0) @binding(2) var<storage, read> conductance: array<f32>;
@group(0) @binding(3) var<storage, read> gradient: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read_write> trace: array<f32>;
@group(0) @binding(5) var<storage, read_write> hessian_xx: array<f32>;
@group(0) @binding(6) var<storage, read_write> hessian_xy: array<f32>;
@group(0) @binding(7) var<storage, read_write> hessian_yy: array<f32>;

// Whether to output the entries, or only their trace.
override ENTRIES_WANTED: bool;

fn write(i: u32, entries: vec3<f32>) {
    if ENTRIES_WANTED {
        let scaled = params.resolution_factor * entries;
        hessian_xx[i] = scaled.x;
        hessian_xy[i] = scaled.y;
        hessian_yy[i] = scaled.z;
        trace[i] = scaled.x + scaled.z;
    } else {
        trace[i] = params.resolution_factor * (entries.x + entries.z);
    }
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() {
        return;
    }
    let columns = columns_around(id.x);
    let first = id.y * STRIP_ROWS;
    let end = min(first + STRIP_ROWS, height());
    if !is_any_covered(id.x, first, end) {
        for (var y = first; y < end; y++) {
            write(index_of(id.x, y), vec3<f32>(0.0));
        }
        return;
    }
    // Values reused by the next row stay in registers.
    var above = row_around(columns, row_above(first));
    var here = row_around(columns, first);
    for (var y = first; y < end; y++) {
        let below = row_around(columns, row_below(y));
        let entries = select(vec3<f32>(0.0), fitted(above, here, below), is_covered(id.x, y));
        write(index_of(id.x, y), entries);
        above = here;
        here = below;
    }
}
