// A piece of a line of varying width, round at both ends.
struct Piece {
    from_along: vec4<f32>,
    // 1 over the squared length; half the width at the start, and its growth; half the extent of a pixel perpendicular
    // to the line.
    per_square: f32,
    radius: f32,
    growth: f32,
    half_pixel: f32,
}

// The share of a pixel with its centre at p covered by a piece, as if the pixel were rotated to the line's direction.
fn round_stroke_coverage(piece: Piece, p: vec2<f32>) -> f32 {
    let along = piece.from_along.zw;
    let offset = p - piece.from_along.xy;
    let t = clamp((offset.x * along.x + offset.y * along.y) * piece.per_square, 0.0, 1.0);
    let radius = piece.radius + t * piece.growth;
    let rest = offset - t * along;
    let distance = sqrt(rest.x * rest.x + rest.y * rest.y);
    // Overlap of the interval from -radius to radius and the pixel's around the distance.
    let half_pixel = piece.half_pixel;
    let both = min(radius, distance + half_pixel) - max(distance - half_pixel, -radius);
    return clamp(both / (2.0 * half_pixel), 0.0, 1.0);
}
