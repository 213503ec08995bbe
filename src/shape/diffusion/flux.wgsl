// One application of the diffusion operator.

// The flux into a sample from its neighbours through faces with the given conductances, in the order west, east, north,
// south. Opposite neighbours are summed first, as on the CPU.
fn flux(g: vec2<f32>, west: vec2<f32>, east: vec2<f32>, north: vec2<f32>, south: vec2<f32>, joined: vec4<f32>) -> vec2<f32> {
    let along_x = joined.x * (west - g) + joined.y * (east - g);
    let along_y = joined.z * (north - g) + joined.w * (south - g);
    return along_x + along_y;
}

// The update of a sample g with the flux lg into it: an explicit step, or a term of the Chebyshev recurrence.
fn updated(g: vec2<f32>, lg: vec2<f32>, earlier: vec2<f32>, term: u32) -> vec2<f32> {
    if !IS_EXPANSION {
        return g + params.time_step * lg;
    }
    if term == 1u {
        return -0.25 * lg - g;
    }
    return -0.5 * lg - (2.0 * g + earlier);
}
