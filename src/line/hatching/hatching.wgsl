// Strokes of one family: a texture cut and pasted along a field of directions, over the paper left white so far.

// Whether the texture moves with places of its own, or is fixed in the picture.
override MOVES: bool;
override HAS_SHARE: bool;
// Whether this pass is the first to draw, and whether it is the last.
override IS_FIRST: bool;
override IS_LAST: bool;

// Share of this family in the optical density wanted.
fn share(wanted: f32) -> f32 {
    let crossed = max(0.5 * (wanted - CROSSED_FROM), 0.0);
    if params.families == 1u {
        return wanted;
    }
    return select(crossed, wanted - crossed, params.family == 0u);
}

// The threshold that gives a density.
fn threshold_of(density: f32) -> f32 {
    let entry = min(max(density * ENTRIES_PER_DENSITY, 0.0), RESPONSE_ENTRIES);
    return thresholds[u32(entry)];
}

// Ink of a level of weight `weight`.
fn ink_of(level: u32, weight: f32, density: f32, place: vec2<f32>) -> f32 {
    let threshold = threshold_of(weight * params.share_of_set * density);
    if threshold <= 0.0 {
        return 0.0;
    }
    let turn = turned[level];
    // For angles counterclockwise: along the angle only the first coordinate grows.
    let at = vec2<f32>(
        turn.x * place.x - turn.y * place.y + turn.z,
        turn.y * place.x + turn.x * place.y + turn.w,
    );
    return ink(at, threshold);
}

fn at_pixel(id: vec2<u32>, i: u32) {
    if !is_covered(id.x, id.y) {
        paper[i] = 0.0;
        return;
    }
    var white = 1.0;
    if !IS_FIRST {
        white = paper[i];
    }
    let wanted = densities[i];
    var density = share(wanted);
    if HAS_SHARE {
        density *= shares[i];
    }
    var place = vec2<f32>(params.first.x + f32(id.x), params.first.y + f32(id.y));
    var direction = vec2<f32>(direction_x[i], direction_y[i]);
    if MOVES {
        place = place_at(i);
        direction = in_texture(jacobian_at(id.x, id.y), direction);
    }
    var angle = atan2_of(direction.y, direction.x);
    if angle < 0.0 {
        angle += PI;
    }
    let count = f32(params.levels);
    let last = count - 1.0;
    for (var layer = 0u; layer < params.sets; layer++) {
        // The two levels next to the angle and their tent weights. Past the last comes the first again.
        var at = angle * params.levels_per_radian - f32(layer) * params.share_of_set;
        if at < 0.0 {
            at += count;
        }
        let level = min(floor(at), last);
        let next = select(level + 1.0, 0.0, level == last);
        // A level that is alone has no other to share with.
        let away = select(min(at - level, 1.0), 0.0, last == 0.0);
        let first = layer * params.levels;
        white *= 1.0 - ink_of(first + u32(level), 1.0 - away, density, place);
        white *= 1.0 - ink_of(first + u32(next), away, density, place);
    }
    if wanted >= MAX_DENSITY {
        white = 0.0;
    }
    paper[i] = select(white, 1.0 - white, IS_LAST);
}
