// Rays along normals beside a point, and how they turn around it. Everything is computed from differences that are
// passed in: subtracting large numbers here would lose them.

// Intersection of a normal's ray with the tangent plane of another point, and its slope there.
struct Ray {
    is_there: bool,
    foot: vec2<f32>,
    slope: vec2<f32>,
}

fn no_ray() -> Ray {
    return Ray(false, vec2<f32>(0.0), vec2<f32>(0.0));
}

// From a point of the surface to an adjacent one.
struct Step {
    is_there: bool,
    offset: vec3<f32>,
}

// The step perpendicular to the sum of both normals, from one sight line to an adjacent one; `apart` is the distance
// between their points at a depth of 1.
fn sight_lines_step(normals: vec3<f32>, line: vec3<f32>, line_there: vec3<f32>, apart: vec3<f32>) -> Step {
    let facing = dot(normals, line_there);
    let offset = apart - dot(normals, apart) / facing * line_there;
    return Step(dot(normals, line) < 0.0 && facing < 0.0, offset);
}

// The ray of the normal `there`, a step from the point with the unit normal `normal`, on the plane of two tangents; `turn`
// is the one normal less the other.
fn local_ray(step: Step, there: vec3<f32>, turn: vec3<f32>, normal: vec3<f32>, tangents: array<vec3<f32>, 2>) -> Ray {
    // The common part of the normals lies along this point's own.
    let lean = vec2<f32>(dot(tangents[0], turn), dot(tangents[1], turn));
    let up = dot(normal, there);
    let slope = lean / up;
    let across = vec2<f32>(dot(tangents[0], step.offset), dot(tangents[1], step.offset));
    let foot = across - dot(normal, step.offset) * slope;
    let is_there = step.is_there
        && up > MIN_COSINE * sqrt(dot(lean, lean) + up * up)
        && is_finite(foot.x)
        && is_finite(foot.y)
        && is_finite(slope.x)
        && is_finite(slope.y);
    if is_there {
        return Ray(true, foot, slope);
    }
    return no_ray();
}

// The curvatures of a surface: their mean, and half their difference toward twice the angle of the larger one.
struct Slopes {
    is_there: bool,
    mean: f32,
    deviator: vec2<f32>,
    // The area between the feet, and the sum of their squares.
    area: f32,
    spread: f32,
}

// Differences of rays across a point; its own ray, all 0, replaces a missing one.
fn slopes_of(left: Ray, right: Ray, below: Ray, above: Ray) -> Slopes {
    let are_there = (left.is_there || right.is_there) && (above.is_there || below.is_there);
    let u = right.foot - left.foot;
    let v = above.foot - below.foot;
    let slope_x = right.slope - left.slope;
    let slope_y = above.slope - below.slope;
    let area = u.x * v.y - u.y * v.x;
    let spread = dot(u, u) + dot(v, v);
    let column_x = (slope_y * u.y - slope_x * v.y) / area;
    let column_y = (slope_x * v.x - slope_y * u.x) / area;
    return Slopes(
        are_there && abs(area) > MIN_SINE * spread,
        0.5 * (column_x.x + column_y.y),
        0.5 * vec2<f32>(column_x.x - column_y.y, column_x.y + column_y.x),
        area,
        spread,
    );
}
