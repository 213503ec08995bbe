// The stroke direction of each patch, as twice an angle: the mean of its own directions, or, the more those disagree,
// of those around it, with the fallback, normalised. 0 for specks.

// Whether directions were averaged at all.
override IS_CALMED: bool;

fn calm(own: vec4<f32>, around: vec4<f32>) -> vec2<f32> {
    let length = sqrt(dot(own.xy, own.xy));
    let agreement = select(0.0, length / own.z, own.z > 0.0);
    let share = clamp((agreement - AGREE_FROM) / (AGREE_TO - AGREE_FROM), 0.0, 1.0);
    let lead = share * share * (3.0 - 2.0 * share);
    return lead * own.xy + (1.0 - lead) * around.xy;
}

fn visit(i: u32) {
    let here = patches[i];
    var led = own[i].xy;
    if IS_CALMED {
        led = calm(own[i], around[i]);
    }
    let last = doubled(fallback(line(middle_of(i)), here.normal));
    let sure = sqrt(dot(led, led));
    let sum = led + FALLBACK * max(1.0 - sure / FREE, 0.0) * last;
    let length = sqrt(dot(sum, sum));
    let is_alone = all(links[i] == vec4<u32>(NO_PATCH));
    let is_speck = is_alone && 2u * pixel_count(here.pixels) < params.cell_px * params.cell_px;
    var direction = last;
    if is_finite(length) && length > 0.0 {
        direction = sum / length;
    }
    settled[i] = select(direction, vec2<f32>(0.0), is_speck);
}
