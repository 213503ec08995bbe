// The Hessian of the height field: a plane fitted to the 3x3 gradients, each weighted by its conductance.

@group(0) @binding(0) var<uniform> params: HessianParams;
@group(0) @binding(1) var<storage, read> covered: array<u32>;
@group(0) @binding(2) var<storage, read> conductance: array<f32>;
@group(0) @binding(3) var<storage, read> gradient: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read_write> trace: array<f32>;
@group(0) @binding(5) var<storage, read_write> hessian_xx: array<f32>;
@group(0) @binding(6) var<storage, read_write> hessian_xy: array<f32>;
@group(0) @binding(7) var<storage, read_write> hessian_yy: array<f32>;

// Whether the entries are wanted, or their trace alone.
override ENTRIES_WANTED: bool;

// Samples around a pixel, rows top to bottom.
var<private> g: array<vec2<f32>, 9>;
var<private> open: array<f32, 9>;

fn load_around(x: i32, y: i32) {
    for (var i = 0; i < 3; i++) {
        for (var j = 0; j < 3; j++) {
            let column = clamp(x + j - 1, 0, i32(width()) - 1);
            let row = clamp(y + i - 1, 0, i32(height()) - 1);
            let at = index_of(u32(column), u32(row));
            g[3 * i + j] = gradient[at];
            open[3 * i + j] = conductance[at];
        }
    }
}

fn all_open() -> bool {
    var all = true;
    for (var i = 0; i < 9; i++) {
        all = all && open[i] == 1.0;
    }
    return all;
}

// [xx, xy, yy] where all is open: Sobel's derivative.
fn in_the_open() -> vec3<f32> {
    let west = (g[0] + g[6]) + 2.0 * g[3];
    let east = (g[2] + g[8]) + 2.0 * g[5];
    let north = (g[0] + g[2]) + 2.0 * g[1];
    let south = (g[6] + g[8]) + 2.0 * g[7];
    let along_x = (east - west) / 8.0;
    let along_y = (north - south) / 8.0;
    return vec3<f32>(along_x.x, 0.5 * (along_y.x + along_x.y), along_y.y);
}

// [xx, xy, yy] of the fit.
fn fitted() -> vec3<f32> {
    var w = array<f32, 9>(1.0, 2.0, 1.0, 2.0, 0.0, 2.0, 1.0, 2.0, 1.0);
    var rise: array<vec2<f32>, 9>;
    for (var i = 0; i < 9; i++) {
        w[i] = w[i] * open[i];
        rise[i] = w[i] * (g[i] - g[4]);
    }
    let xx = (((w[0] + w[6]) + w[3]) + ((w[2] + w[8]) + w[5])) + RIDGE;
    let xy = (w[2] + w[6]) - (w[0] + w[8]);
    let yy = (((w[0] + w[2]) + w[1]) + ((w[6] + w[8]) + w[7])) + RIDGE;
    let along_x = ((rise[2] + rise[8]) + rise[5]) - ((rise[0] + rise[6]) + rise[3]);
    let along_y = ((rise[0] + rise[2]) + rise[1]) - ((rise[6] + rise[8]) + rise[7]);
    let determinant = xx * yy - xy * xy;
    let slope_x = (yy * along_x - xy * along_y) / determinant;
    let slope_y = (xx * along_y - xy * along_x) / determinant;
    let c = open[4];
    return vec3<f32>(c * slope_x.x, c * 0.5 * (slope_y.x + slope_x.y), c * slope_y.y);
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let x = i32(id.x);
    let y = i32(id.y);
    var entries = vec3<f32>(0.0);
    if is_covered(x, y) {
        load_around(x, y);
        if all_open() {
            entries = in_the_open();
        } else if open[4] != 0.0 {
            entries = fitted();
        }
    }
    let i = index_of(id.x, id.y);
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
