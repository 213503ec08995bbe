// A texture of strokes, as the tones at which each texel turns from paper to ink: a repeating square.

// Thresholds at which a texel begins to take ink and is full, from two bytes of a word.
fn ramp_of(word: u32) -> vec2<f32> {
    return vec2<f32>(f32(word & 0xffu), f32((word >> 8u) & 0xffu));
}

// Between the two texels of a word.
fn ramp_between(word: u32, across: f32) -> vec2<f32> {
    let left = ramp_of(word);
    return left + across * (ramp_of(word >> 16u) - left);
}

// Ink at a position in texels, at a threshold.
fn ink(at: vec2<f32>, threshold: f32) -> f32 {
    let corner = floor(at);
    let within = at - corner;
    let wrap = i32(params.texture_width) - 1;
    let column = u32(i32(corner.x) & wrap);
    let row = i32(corner.y);
    let upper = ramp_between(texels[u32(row & wrap) * params.texture_width + column], within.x);
    let lower = ramp_between(texels[u32((row + 1) & wrap) * params.texture_width + column], within.x);
    let ramp = upper + within.y * (lower - upper);
    return clamp((threshold - ramp.x) / (ramp.y - ramp.x), 0.0, 1.0);
}
