// The direction where curvature leads nowhere, of the first field made or the second.
fn fallback(line: vec3<f32>, normal: vec3<f32>) -> vec2<f32> {
    if params.is_fixed == 1u {
        return vec2<f32>(params.fixed_x, params.fixed_y);
    }
    return fixed_direction(line, normal, params.order);
}
