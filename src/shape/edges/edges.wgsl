// Silhouettes, creases, conductance and the depth gradient.

override HAS_MAP: bool;
override HAS_GAPS: bool;
override HAS_LENGTHS: bool;
override WEIGHTS_WANTED: bool;

fn normal_at(x: u32, row: u32) -> vec3<f32> {
    let i = row + x;
    return vec3<f32>(normal_x[i], normal_y[i], normal_z[i]);
}

// The map to the left of a pixel, at it and to its right.
fn map_around(columns: vec3<u32>, row: u32) -> vec3<f32> {
    if !HAS_MAP {
        return vec3<f32>(0.0);
    }
    return vec3<f32>(
        silhouette_map[row + columns.x],
        silhouette_map[row + columns.y],
        silhouette_map[row + columns.z],
    );
}

// Derivatives of a 3x3 neighbourhood, y up.
fn sobel(above: vec3<f32>, here: vec3<f32>, below: vec3<f32>) -> vec2<f32> {
    let west = (above.x + below.x) + 2.0 * here.x;
    let east = (above.z + below.z) + 2.0 * here.z;
    let north = (above.x + above.z) + 2.0 * above.y;
    let south = (below.x + below.z) + 2.0 * below.y;
    return vec2<f32>((east - west) / 8.0, (north - south) / 8.0);
}

// The weight of the jump across the centre: twice the Sobel slope, the difference between the two sides.
fn jump_weight(above: vec3<f32>, here: vec3<f32>, below: vec3<f32>) -> f32 {
    let slope = sobel(above, here, below);
    let jump = 2.0 * sqrt(slope.x * slope.x + slope.y * slope.y);
    return soft_threshold_weight(jump, params.silhouette_lo, params.silhouette_hi);
}

// Angle in radians between two unit normals whose mean has the given length.
fn angle_within(length: f32) -> f32 {
    let cosine = clamp(length, 0.0, 1.0);
    return 2.0 * atan2_of(sqrt(1.0 - cosine * cosine), cosine);
}

// A normal and its four neighbours.
struct NeighbourNormals {
    own: vec3<f32>,
    left: vec3<f32>,
    right: vec3<f32>,
    above: vec3<f32>,
    below: vec3<f32>,
}

// Crease weight of a pixel with the normals `n`, of length `length` after filtering, where `there` marks the existing
// neighbours left, right, above and below. The largest angle counts: to a neighbour, and across the pixel from one side
// to the other.
fn crease_detector_weight(n: NeighbourNormals, length: f32, there: vec4<bool>) -> f32 {
    // The squared distance between unit vectors increases with their angle, and keeps its precision for small angles.
    let left = n.own - n.left;
    let right = n.own - n.right;
    let above = n.own - n.above;
    let below = n.own - n.below;
    let along_x = n.left - n.right;
    let along_y = n.above - n.below;
    let to_sides = max(select(0.0, dot(left, left), there.x), select(0.0, dot(right, right), there.y));
    let to_rows = max(select(0.0, dot(above, above), there.z), select(0.0, dot(below, below), there.w));
    let across = max(
        select(0.0, dot(along_x, along_x), there.x && there.y),
        select(0.0, dot(along_y, along_y), there.z && there.w),
    );
    let squared = max(max(to_sides, to_rows), across);
    let sine = sqrt(squared * max(1.0 - 0.25 * squared, 0.0));
    var angle = atan2_of(sine, 1.0 - 0.5 * squared);
    if length < params.flat_length {
        angle = max(angle, angle_within(length));
    }
    return soft_threshold_weight(angle, params.crease_lo, params.crease_hi);
}

// g = -n_xy / (n . v)^f, the direction v to the eye scaled to z = 1.
fn depth_gradient(n: vec3<f32>, to_eye: vec2<f32>) -> vec2<f32> {
    let facing = max(facing(n, to_eye), params.min_nz);
    let f = params.foreshortening;
    var steepness = 1.0;
    if f == 1.0 {
        steepness = 1.0 / facing;
    } else if f != 0.0 {
        steepness = exp_of(-f * ln(facing));
    }
    return -n.xy * steepness;
}

// The strength of a gap where it is the largest of a row: no smaller than the one past it, and larger than the nearer one.
fn drawn(own: f32, past: f32, nearer: f32) -> f32 {
    return select(0.0, max(own, 0.0), own >= past && own > nearer);
}

// The weights of the silhouettes that a pixel is in front of, and that it is beside, from the gaps along an axis.
fn along_gaps(gaps: vec4<f32>) -> vec2<f32> {
    let front = max(drawn(gaps.z, gaps.w, gaps.y), drawn(-gaps.y, -gaps.x, -gaps.z));
    return vec2<f32>(front, max(abs(gaps.z), abs(gaps.y)));
}

fn silhouettes_of_gaps(across: vec4<f32>, down: vec4<f32>) -> vec2<f32> {
    return min(max(along_gaps(across), along_gaps(down)), vec2<f32>(1.0));
}

// The gap after a pixel of a row or a column, possibly one beyond the picture, where there is none.
fn gap_across(x: i32, y: u32) -> f32 {
    let is_inside = x >= 0 && x < i32(width());
    return select(0.0, gaps[index_of(u32(clamp(x, 0, i32(width()) - 1)), y)].x, is_inside);
}

fn gap_down(x: u32, y: i32) -> f32 {
    let is_inside = y >= 0 && y < i32(height());
    return select(0.0, gaps[index_of(x, u32(clamp(y, 0, i32(height()) - 1)))].y, is_inside);
}

fn write(i: u32, open: f32, g: vec2<f32>, edges: vec2<f32>) {
    conductance[i] = open;
    gradient[i] = g;
    if WEIGHTS_WANTED {
        weights[i] = edges;
    }
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() {
        return;
    }
    let columns = columns_around(id.x);
    let to_eye_x = params.to_eye.x + params.to_eye.z * f32(id.x);
    let first = id.y * STRIP_ROWS;
    let end = min(first + STRIP_ROWS, height());
    if !is_any_covered(id.x, first, end) {
        for (var y = first; y < end; y++) {
            write(index_of(id.x, y), 0.0, vec2<f32>(0.0), vec2<f32>(0.0));
        }
        return;
    }
    // Values reused by the next row stay in registers.
    var covered_above = covered_around(columns, row_above(first));
    var covered_here = covered_around(columns, first);
    var map_above = map_around(columns, index_of(0u, row_above(first)));
    var map_here = map_around(columns, index_of(0u, first));
    var normal_above = normal_at(id.x, index_of(0u, row_above(first)));
    var normal = normal_at(id.x, index_of(0u, first));
    for (var y = first; y < end; y++) {
        let row = index_of(0u, y);
        let row_under = index_of(0u, row_below(y));
        let covered_below = covered_around(columns, row_below(y));
        let map_below = map_around(columns, row_under);
        let normal_below = normal_at(id.x, row_under);
        let i = row + id.x;

        let is_inside = all(covered_above) && all(covered_here) && all(covered_below);
        var weights = vec2<f32>(0.0);
        if HAS_GAPS {
            let x = i32(id.x);
            let up = i32(y);
            weights = silhouettes_of_gaps(
                vec4<f32>(gap_across(x - 2, y), gap_across(x - 1, y), gap_across(x, y), gap_across(x + 1, y)),
                vec4<f32>(gap_down(id.x, up - 2), gap_down(id.x, up - 1), gap_down(id.x, up), gap_down(id.x, up + 1)),
            );
        } else if HAS_MAP {
            weights = vec2<f32>(jump_weight(map_above, map_here, map_below));
        }
        let silhouette = select(1.0, weights.x, is_inside);
        let barrier = select(1.0, weights.y, is_inside);
        let left = normal_at(columns.x, row);
        let right = normal_at(columns.z, row);
        let around = NeighbourNormals(normal, left, right, normal_above, normal_below);
        let there = vec4<bool>(covered_here.x, covered_here.z, covered_above.y, covered_below.y);
        var length = 1.0;
        if HAS_LENGTHS {
            length = normal_length[i];
        }
        let crease = crease_detector_weight(around, length, there);
        let to_eye = vec2<f32>(to_eye_x, params.to_eye.y + params.to_eye.w * f32(y));
        let g = depth_gradient(normal, to_eye);

        if covered_here.y {
            write(i, 1.0 - max(barrier, crease), g, vec2<f32>(silhouette, crease));
        } else {
            write(i, 0.0, vec2<f32>(0.0), vec2<f32>(0.0));
        }
        covered_above = covered_here;
        covered_here = covered_below;
        map_above = map_here;
        map_here = map_below;
        normal_above = normal;
        normal = normal_below;
    }
}
