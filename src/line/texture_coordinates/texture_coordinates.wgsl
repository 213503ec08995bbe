// Texture coordinates that move with the surface.

// Derivatives of the place by the picture, rows down in both.
struct Jacobian {
    dx: vec2<f32>,
    dy: vec2<f32>,
}

// The place of an adjacent pixel, if it has one and shows the same surface.
struct Neighbour {
    place: vec2<f32>,
    is_there: bool,
}

struct Slope {
    by: vec2<f32>,
    is_known: bool,
}

// Whether two places, of adjacent pixels, can belong to one surface.
fn is_joined(a: vec2<f32>, b: vec2<f32>) -> bool {
    let way = b - a;
    let square = way.x * way.x + way.y * way.y;
    return !is_nan(square) && square < JUMP * JUMP;
}

fn slope(here: vec2<f32>, before: Neighbour, after: Neighbour) -> Slope {
    let has_before = before.is_there && is_joined(here, before.place);
    let has_after = after.is_there && is_joined(here, after.place);
    if has_before && has_after {
        return Slope(0.5 * (after.place - before.place), true);
    }
    if has_before {
        return Slope(here - before.place, true);
    }
    if has_after {
        return Slope(after.place - here, true);
    }
    return Slope(vec2<f32>(0.0), false);
}

// The Jacobian at the place `here`, from the neighbours beside, above and below. A missing derivative is replaced by
// the other, rotated.
fn jacobian(here: vec2<f32>, left: Neighbour, right: Neighbour, above: Neighbour, below: Neighbour) -> Jacobian {
    let across = slope(here, left, right);
    let down = slope(here, above, below);
    if across.is_known && down.is_known {
        return Jacobian(across.by, down.by);
    }
    if across.is_known {
        return Jacobian(across.by, vec2<f32>(-across.by.y, across.by.x));
    }
    if down.is_known {
        return Jacobian(vec2<f32>(down.by.y, -down.by.x), down.by);
    }
    return Jacobian(vec2<f32>(1.0, 0.0), vec2<f32>(0.0, 1.0));
}

// The direction in the texture of a direction in the picture, both x right, y up.
fn in_texture(by: Jacobian, t: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(by.dx.x * t.x - by.dy.x * t.y, -(by.dx.y * t.x - by.dy.y * t.y));
}
