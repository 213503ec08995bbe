// Silhouettes, creases, conductance and the depth gradient.

@group(0) @binding(0) var<uniform> params: EdgeParams;
@group(0) @binding(1) var<storage, read> covered: array<u32>;
@group(0) @binding(2) var<storage, read> normal_x: array<f32>;
@group(0) @binding(3) var<storage, read> normal_y: array<f32>;
@group(0) @binding(4) var<storage, read> normal_z: array<f32>;
// The logarithm of depth, or an occlusion map.
@group(0) @binding(5) var<storage, read> silhouette_map: array<f32>;
@group(0) @binding(6) var<storage, read> normal_length: array<f32>;
@group(0) @binding(7) var<storage, read_write> conductance: array<f32>;
@group(0) @binding(8) var<storage, read_write> gradient: array<vec2<f32>>;
// Silhouette and crease weight, where they are wanted.
@group(0) @binding(9) var<storage, read_write> weights: array<vec2<f32>>;

override HAS_MAP: bool;
override HAS_LENGTHS: bool;
override WEIGHTS_WANTED: bool;

// Beyond the border of the picture its border goes on.
fn at_border(x: i32, y: i32) -> u32 {
    let column = clamp(x, 0, i32(width()) - 1);
    let row = clamp(y, 0, i32(height()) - 1);
    return index_of(u32(column), u32(row));
}

fn normal_at(x: i32, y: i32) -> vec3<f32> {
    let i = at_border(x, y);
    return vec3<f32>(normal_x[i], normal_y[i], normal_z[i]);
}

fn map_at(x: i32, y: i32) -> f32 {
    return silhouette_map[at_border(x, y)];
}

// Whether the pixel has an uncovered pixel among its eight neighbours.
fn on_border(x: i32, y: i32) -> bool {
    for (var i = -1; i <= 1; i++) {
        for (var j = -1; j <= 1; j++) {
            if !is_covered(x + j, y + i) {
                return true;
            }
        }
    }
    return false;
}

// The jump of the map across the pixel is twice the Sobel slope: the difference between the two sides.
fn silhouette_weight(x: i32, y: i32) -> f32 {
    if on_border(x, y) {
        return 1.0;
    }
    if !HAS_MAP {
        return 0.0;
    }
    let northwest = map_at(x - 1, y - 1);
    let northeast = map_at(x + 1, y - 1);
    let southwest = map_at(x - 1, y + 1);
    let southeast = map_at(x + 1, y + 1);
    let west = (northwest + southwest) + 2.0 * map_at(x - 1, y);
    let east = (northeast + southeast) + 2.0 * map_at(x + 1, y);
    let north = (northwest + northeast) + 2.0 * map_at(x, y - 1);
    let south = (southwest + southeast) + 2.0 * map_at(x, y + 1);
    let dx = (east - west) / 8.0;
    let dy = (north - south) / 8.0;
    return soft_weight(2.0 * sqrt(dx * dx + dy * dy), params.silhouette_lo, params.silhouette_hi);
}

fn angle_between(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return atan2_of(length(cross(a, b)), dot(a, b));
}

// The angle so far, or that between two normals where it is larger and both are there.
fn larger_angle(angle: f32, are_there: bool, a: vec3<f32>, b: vec3<f32>) -> f32 {
    if are_there && dot(a, b) < params.flat_cosine {
        return max(angle, angle_between(a, b));
    }
    return angle;
}

// The largest angle counts: to a neighbour, and across the pixel from one side to the other.
fn crease_weight(x: i32, y: i32, n: vec3<f32>) -> f32 {
    let has_left = is_covered(x - 1, y);
    let has_right = is_covered(x + 1, y);
    let has_above = is_covered(x, y - 1);
    let has_below = is_covered(x, y + 1);
    let left = normal_at(x - 1, y);
    let right = normal_at(x + 1, y);
    let above = normal_at(x, y - 1);
    let below = normal_at(x, y + 1);
    var angle = 0.0;
    angle = larger_angle(angle, has_left, n, left);
    angle = larger_angle(angle, has_right, n, right);
    angle = larger_angle(angle, has_above, n, above);
    angle = larger_angle(angle, has_below, n, below);
    angle = larger_angle(angle, has_left && has_right, left, right);
    angle = larger_angle(angle, has_above && has_below, above, below);
    if HAS_LENGTHS {
        let mean_length = normal_length[at_border(x, y)];
        if mean_length < params.flat_length {
            let cosine = clamp(mean_length, 0.0, 1.0);
            angle = max(angle, 2.0 * atan2_of(sqrt(1.0 - cosine * cosine), cosine));
        }
    }
    return soft_weight(angle, params.crease_lo, params.crease_hi);
}

// g = -n_xy / (n . v)^f, the direction v to the eye scaled to z = 1.
fn depth_gradient(n: vec3<f32>, to_eye: vec2<f32>) -> vec2<f32> {
    let facing = max(n.z + dot(n.xy, to_eye), params.min_nz);
    let f = params.foreshortening;
    var steepness = 1.0;
    if f == 1.0 {
        steepness = 1.0 / facing;
    } else if f != 0.0 {
        steepness = exp_of(-f * ln_of(facing));
    }
    return -n.xy * steepness;
}

@compute @workgroup_size(GROUP_COLUMNS, GROUP_ROWS)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= width() || id.y >= height() {
        return;
    }
    let x = i32(id.x);
    let y = i32(id.y);
    let i = index_of(id.x, id.y);
    var silhouette = 0.0;
    var crease = 0.0;
    var open = 0.0;
    var g = vec2<f32>(0.0);
    if is_covered(x, y) {
        let n = normal_at(x, y);
        silhouette = silhouette_weight(x, y);
        crease = crease_weight(x, y, n);
        open = 1.0 - max(silhouette, crease);
        let to_eye = vec2<f32>(
            params.to_eye_x + params.to_eye_x_step * f32(id.x),
            params.to_eye_y + params.to_eye_y_step * f32(id.y),
        );
        g = depth_gradient(n, to_eye);
    }
    conductance[i] = open;
    gradient[i] = g;
    if WEIGHTS_WANTED {
        weights[i] = vec2<f32>(silhouette, crease);
    }
}
