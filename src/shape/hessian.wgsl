// The Hessian of the height field.

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

// A row of three pixels: to the left, at and to the right of the centre.
struct Row {
    left: vec2<f32>,
    here: vec2<f32>,
    right: vec2<f32>,
    open: vec3<f32>,
}

fn row_around(columns: vec3<u32>, y: u32) -> Row {
    let at = index_of(0u, y) + columns;
    return Row(
        gradient[at.x],
        gradient[at.y],
        gradient[at.z],
        vec3<f32>(conductance[at.x], conductance[at.y], conductance[at.z]),
    );
}

// [xx, xy, yy] away from edges: Sobel's derivative.
fn in_the_open(above: Row, here: Row, below: Row) -> vec3<f32> {
    let west = (above.left + below.left) + 2.0 * here.left;
    let east = (above.right + below.right) + 2.0 * here.right;
    let north = (above.left + above.right) + 2.0 * above.here;
    let south = (below.left + below.right) + 2.0 * below.here;
    let along_x = (east - west) / 8.0;
    let along_y = (north - south) / 8.0;
    return vec3<f32>(along_x.x, 0.5 * (along_y.x + along_x.y), along_y.y);
}

// [xx, xy, yy] of the fit.
fn plane_fit(above: Row, here: Row, below: Row) -> vec3<f32> {
    let w_above = vec3<f32>(above.open.x, 2.0 * above.open.y, above.open.z);
    let w_left = 2.0 * here.open.x;
    let w_right = 2.0 * here.open.z;
    let w_below = vec3<f32>(below.open.x, 2.0 * below.open.y, below.open.z);
    let g = here.here;
    let northwest = w_above.x * (above.left - g);
    let north = w_above.y * (above.here - g);
    let northeast = w_above.z * (above.right - g);
    let west = w_left * (here.left - g);
    let east = w_right * (here.right - g);
    let southwest = w_below.x * (below.left - g);
    let south = w_below.y * (below.here - g);
    let southeast = w_below.z * (below.right - g);
    let xx = (((w_above.x + w_below.x) + w_left) + ((w_above.z + w_below.z) + w_right)) + RIDGE;
    let xy = (w_above.z + w_below.x) - (w_above.x + w_below.z);
    let yy = (((w_above.x + w_above.z) + w_above.y) + ((w_below.x + w_below.z) + w_below.y)) + RIDGE;
    let along_x = ((northeast + southeast) + east) - ((northwest + southwest) + west);
    let along_y = ((northwest + northeast) + north) - ((southwest + southeast) + south);
    let determinant = xx * yy - xy * xy;
    let slope_x = (yy * along_x - xy * along_y) / determinant;
    let slope_y = (xx * along_y - xy * along_x) / determinant;
    let c = here.open.y;
    return vec3<f32>(c * slope_x.x, c * 0.5 * (slope_y.x + slope_x.y), c * slope_y.y);
}

// [xx, xy, yy]: the fit, or the equal Sobel derivative away from edges; 0 on edges.
fn fitted(above: Row, here: Row, below: Row) -> vec3<f32> {
    let least = min(min(above.open, here.open), below.open);
    let of_edges = select(vec3<f32>(0.0), plane_fit(above, here, below), here.open.y != 0.0);
    return select(of_edges, in_the_open(above, here, below), all(least == vec3<f32>(1.0)));
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
