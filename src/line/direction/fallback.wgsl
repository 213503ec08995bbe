// The direction of a surface that has none of its own, or, of the second field made, the one at right angles to it.
fn fixed_direction(line: vec3<f32>, normal: vec3<f32>, order: u32) -> vec2<f32> {
    for (var axis = 0u; axis < 3u; axis++) {
        var unit = vec3<f32>(0.0);
        unit[axis] = 1.0;
        var tangent = cross(unit, normal);
        let length = sqrt(dot(tangent, tangent));
        if !(length > ALONG) {
            continue;
        }
        tangent /= length;
        let seen = picture_direction(line, tangent);
        if all(seen == vec2<f32>(0.0)) {
            continue;
        }
        if order == 0u {
            return seen;
        }
        let second = picture_direction(line, cross(normal, tangent));
        return select(second, vec2<f32>(1.0, 0.0), all(second == vec2<f32>(0.0)));
    }
    return vec2<f32>(1.0, 0.0);
}

// The direction where curvature leads nowhere, of the first field made or the second.
fn fallback(line: vec3<f32>, normal: vec3<f32>) -> vec2<f32> {
    if params.is_fixed == 1u {
        return vec2<f32>(params.fixed_x, params.fixed_y);
    }
    return fixed_direction(line, normal, params.order);
}
