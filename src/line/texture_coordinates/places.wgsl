// Maps of places, and adjacency in them.

override HAS_DEPTH: bool;
override HAS_MOTION: bool;

fn place_at(at: u32) -> vec2<f32> {
    return vec2<f32>(place_x[at], place_y[at]);
}

// Whether two depths, of neighbours, can belong to one surface.
fn is_one_depth(a: f32, b: f32) -> bool {
    // NaN depths separate nothing, nor do two infinite ones.
    let least = min(abs(a), abs(b));
    if is_nan(a) || is_nan(b) || least > F32_MAX {
        return true;
    }
    return abs(a - b) <= DEPTH_STEP * least;
}

// Whether two motions, of neighbours, can belong to one surface.
fn is_one_motion(a: vec2<f32>, b: vec2<f32>) -> bool {
    let apart = a - b;
    let change = sqrt(apart.x * apart.x + apart.y * apart.y);
    let least = min(sqrt(a.x * a.x + a.y * a.y), sqrt(b.x * b.x + b.y * b.y));
    return !is_nan(change) && change <= MOTION_STEP_PX + MOTION_STEP_SHARE * least;
}

// The neighbour of the pixel at `at`, if it is inside the picture.
fn neighbour(at: u32, is_inside: bool, x: u32, y: u32) -> Neighbour {
    if !is_inside || !is_covered(x, y) {
        return Neighbour(vec2<f32>(0.0), false);
    }
    let next = index_of(x, y);
    var joins = true;
    if HAS_DEPTH {
        joins = is_one_depth(depth[at], depth[next]);
    } else if HAS_MOTION {
        let here = vec2<f32>(motion_x[at], motion_y[at]);
        joins = is_one_motion(here, vec2<f32>(motion_x[next], motion_y[next]));
    }
    return Neighbour(place_at(next), joins);
}

// The Jacobian of the map at a pixel.
fn jacobian_at(x: u32, y: u32) -> Jacobian {
    let at = index_of(x, y);
    return jacobian(
        place_at(at),
        neighbour(at, x > 0u, x - 1u, y),
        neighbour(at, x + 1u < width(), x + 1u, y),
        neighbour(at, y > 0u, x, y - 1u),
        neighbour(at, y + 1u < height(), x, y + 1u),
    );
}
