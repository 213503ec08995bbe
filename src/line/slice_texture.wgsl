// A texture of pictures, from the lightest to the darkest: rectangles that repeat.

struct Within {
    first: u32,
    next: u32,
    share: f32,
}

fn within(at: f32, size: u32) -> Within {
    // Below 0 where the quotient was rounded up to a whole number.
    let rest = at - f32(size) * floor(at / f32(size));
    let inside = select(rest, rest + f32(size), rest < 0.0);
    let first = min(u32(inside), size - 1u);
    return Within(first, (first + 1u) % size, inside - f32(first));
}

fn texel(slice: u32, row: u32, column: u32) -> f32 {
    return bitcast<f32>(texels[(slice * params.texture_height + row) * params.texture_width + column]);
}

fn mix_of(a: f32, b: f32, share: f32) -> f32 {
    return a + share * (b - a);
}

fn of_slice(slice: u32, x: Within, y: Within) -> f32 {
    let upper = mix_of(texel(slice, y.first, x.first), texel(slice, y.first, x.next), x.share);
    let lower = mix_of(texel(slice, y.next, x.first), texel(slice, y.next, x.next), x.share);
    return mix_of(upper, lower, y.share);
}

// Ink at a position in texels, at a threshold: a slice number plus a fraction of the way to the next.
fn ink(at: vec2<f32>, threshold: f32) -> f32 {
    let x = within(at.x, params.texture_width);
    let y = within(at.y, params.texture_height);
    let slice = min(u32(threshold), params.slices - 2u);
    let share = clamp(threshold - f32(slice), 0.0, 1.0);
    return mix_of(of_slice(slice, x, y), of_slice(slice + 1u, x, y), share);
}
