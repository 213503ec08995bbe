// The factor that quantises a colour of luminance y to a few tones.
fn tone_factor(y: f32) -> f32 {
    if !is_finite(y) || !(y > 0.0) {
        return 1.0;
    }
    let position = sqrt(y) * params.tone_levels;
    let below = floor(position);
    // Position between the tones: 0 before the step, 1 after it.
    let aside = position - below - 0.5;
    var t = select(1.0, 0.0, aside < 0.0);
    if params.tone_softness > 0.0 {
        t = clamp(aside / params.tone_softness + 0.5, 0.0, 1.0);
    }
    let tone = min(below + t * t * (3.0 - 2.0 * t), params.tone_most) / params.tone_levels;
    return tone * tone / y;
}
