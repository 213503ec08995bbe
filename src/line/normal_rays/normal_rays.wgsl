// Directions of the surface's own curvature larger in size, from the normal rays beside each pixel.

override HAS_DEPTH: bool;
override IS_PARALLEL: bool;
override DEPTH_ALONG_RAY: bool;

// The point looked at.
struct Point {
    i: u32,
    place: vec2<f32>,
    line: vec3<f32>,
    stored: vec3<f32>,
    normal: vec3<f32>,
    tangents: array<vec3<f32>, 2>,
    // The unit of lengths: its depth in perspective, else 1.
    unit: f32,
}

// The direction found at a pixel; 0 without one.
struct Found {
    direction: vec2<f32>,
    is_flat: bool,
}

fn normal_at(i: u32) -> vec3<f32> {
    return vec3<f32>(normal_x[i], normal_y[i], normal_z[i]);
}

// Two tangents at right angles: which is nothing that directions depend on.
fn any_orthonormal_pair(normal: vec3<f32>) -> array<vec3<f32>, 2> {
    let side = copysign(1.0, normal.z);
    let a = -1.0 / (side + normal.z);
    let b = normal.x * normal.y * a;
    return array(
        vec3<f32>(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x),
        vec3<f32>(b, side + normal.y * normal.y * a, -normal.y),
    );
}

fn point_at(x: u32, y: u32) -> Point {
    let i = index_of(x, y);
    let stored = normal_at(i);
    let normal = stored / sqrt(dot(stored, stored));
    let place = vec2<f32>(f32(x), f32(y)) + 0.5;
    var unit = 1.0;
    if HAS_DEPTH && !IS_PARALLEL {
        unit = depth[i];
    }
    return Point(i, place, line(place), stored, normal, any_orthonormal_pair(normal), unit);
}

// The step to the point given by depth, `away` in pixels.
fn step_by_depth(here: Point, i: u32, away: vec2<f32>, line_there: vec3<f32>) -> Step {
    let line_apart = vec3<f32>(away * params.line.zw, 0.0);
    let start_apart = vec3<f32>(away * params.start_step, 0.0);
    var own = depth[here.i] / here.unit;
    var deeper = (depth[i] - depth[here.i]) / here.unit;
    if DEPTH_ALONG_RAY {
        let lengths = vec2<f32>(sqrt(dot(here.line, here.line)), sqrt(dot(line_there, line_there)));
        // The difference of their inverses.
        let product = lengths.x * lengths.y * (lengths.x + lengths.y);
        let shorter = dot(line_apart, here.line + line_there) / product;
        deeper = deeper / lengths.y - own * shorter;
        own /= lengths.x;
    }
    let offset = start_apart + deeper * line_there + own * line_apart;
    return Step(true, offset);
}

// The ray of a pixel `away` columns and rows.
fn ray_at(here: Point, away: vec2<i32>) -> Ray {
    let i = u32(i32(here.i) + away.y * i32(width()) + away.x);
    let there = normal_at(i);
    let pixels = vec2<f32>(away);
    let line_there = line(here.place + pixels);
    var step = Step(false, vec3<f32>(0.0));
    if HAS_DEPTH {
        step = step_by_depth(here, i, pixels, line_there);
    } else {
        let apart = vec3<f32>(pixels * params.apart_step, 0.0);
        step = sight_lines_step(here.stored + there, here.line, line_there, apart);
    }
    return local_ray(step, there, there - here.stored, here.normal, here.tangents);
}

// Number of consecutive open pixels ahead, up to `most`.
fn open_ahead(here: Point, ahead: vec2<i32>, most: i32) -> i32 {
    let size = vec2<i32>(i32(width()), i32(height()));
    var at = vec2<i32>(here.place);
    for (var count = 0; count < most; count++) {
        at += ahead;
        if any(at < vec2<i32>(0)) || any(at >= size) || !(conductance[index_of(u32(at.x), u32(at.y))] > 0.0) {
            return count;
        }
    }
    return most;
}

// The rays on both sides along one axis.
struct Sides {
    before: Ray,
    after: Ray,
    // Number of pixels between them.
    samples: f32,
}

// Rays equally far on both sides, as far as the surface continues on each; on one side alone if it ends at once on the
// other.
fn sides(here: Point, ahead: vec2<i32>, most: i32) -> Sides {
    let before = open_ahead(here, -ahead, most);
    let after = open_ahead(here, ahead, most);
    let both = min(before, after);
    let far = select(max(before, after), both, both > 0);
    var rays = Sides(no_ray(), no_ray(), 0.0);
    if before > 0 {
        rays.before = ray_at(here, -far * ahead);
    }
    if after > 0 {
        rays.after = ray_at(here, far * ahead);
    }
    rays.samples = f32(far) * (f32(rays.before.is_there) + f32(rays.after.is_there));
    return rays;
}

// The curvature larger in magnitude, and its direction in the tangent plane: 0 for no direction.
struct Larger {
    is_there: bool,
    is_flat: bool,
    direction: vec2<f32>,
}

fn larger_curvature(here: Point, step: i32) -> Larger {
    let along_x = sides(here, vec2<i32>(1, 0), step);
    // y points up, rows run down.
    let along_y = sides(here, vec2<i32>(0, -1), step);
    let form = slopes_of(along_x.before, along_x.after, along_y.before, along_y.after);
    let slope_x = along_x.after.slope - along_x.before.slope;
    let slope_y = along_y.after.slope - along_y.before.slope;
    let turn = max(sqrt(dot(slope_x, slope_x)) / along_x.samples, sqrt(dot(slope_y, slope_y)) / along_y.samples);
    let half_spread = sqrt(dot(form.deviator, form.deviator));
    let larger = abs(form.mean) + half_spread;
    var noise = params.normal_noise;
    if HAS_DEPTH {
        noise += larger * params.offset_noise * (depth[here.i] / here.unit);
    }
    let error = CERTAINTY * noise * sqrt(0.5 * form.spread) / abs(form.area);
    let is_flat = turn < PLANAR_TURN || larger <= error;
    let is_round = half_spread <= max(ALIKE * abs(form.mean), error);
    let d = select(-form.deviator, form.deviator, form.mean >= 0.0);
    let axis = select(vec2<f32>(d.y, half_spread - d.x), vec2<f32>(d.x + half_spread, d.y), d.x >= 0.0);
    let size = sqrt(dot(axis, axis));
    var direction = vec2<f32>(0.0);
    if !is_flat && !is_round && size > 0.0 {
        direction = axis / size;
    }
    return Larger(form.is_there, is_flat, direction);
}

// The direction at the shortest step that gives one; otherwise the result of the longest.
fn found_at(x: u32, y: u32) -> Found {
    let here = point_at(x, y);
    var found = Found(vec2<f32>(0.0), false);
    if !(conductance[here.i] > 0.0) || !is_finite(here.normal.x + here.normal.y + here.normal.z) {
        return found;
    }
    var step = params.first_step;
    loop {
        let larger = larger_curvature(here, step);
        if !larger.is_there {
            return found;
        }
        if any(larger.direction != vec2<f32>(0.0)) {
            let tangent = larger.direction.x * here.tangents[0] + larger.direction.y * here.tangents[1];
            found.direction = picture_direction(here.line, tangent);
            return found;
        }
        if step >= params.most_step {
            found.is_flat = larger.is_flat;
            break;
        }
        step = min(STEP_GROWTH * step, params.most_step);
    }
    return found;
}

fn at_pixel(id: vec2<u32>, i: u32) {
    var found = Found(vec2<f32>(0.0), false);
    if is_covered(id.x, id.y) {
        found = found_at(id.x, id.y);
    }
    direction_x[i] = found.direction.x;
    direction_y[i] = found.direction.y;
    planar[i] = f32(found.is_flat);
}
