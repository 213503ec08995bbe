// Silhouettes between two pixels.

// A sample, if known.
struct Sample {
    value: f32,
    is_known: bool,
}

// The difference between two samples.
fn difference(a: Sample, b: Sample) -> Sample {
    return Sample(b.value - a.value, a.is_known && b.is_known);
}

// The part of a jump beyond so many times the slope to either side, where one is known.
fn beyond_slopes(jump: f32, times: f32, before: Sample, behind: Sample) -> Sample {
    let past_before = abs(jump - times * before.value);
    let past_behind = abs(jump - times * behind.value);
    if before.is_known && behind.is_known {
        return Sample(min(past_before, past_behind), true);
    }
    return Sample(select(past_behind, past_before, before.is_known), before.is_known || behind.is_known);
}

fn steepness(slope: Sample) -> f32 {
    return select(0.0, abs(slope.value), slope.is_known);
}

// The jump of a map between the third and the fourth of six samples, beyond the part explained by the slopes to either
// side.
fn unexplained_jump(a: array<Sample, 6>) -> f32 {
    let jump = difference(a[2], a[3]);
    if !jump.is_known {
        return 0.0;
    }
    let beyond = beyond_slopes(jump.value, 1.0, difference(a[1], a[2]), difference(a[3], a[4]));
    let sharp = select(abs(jump.value), beyond.value, beyond.is_known);
    let before = difference(a[0], a[1]);
    let behind = difference(a[4], a[5]);
    let steepest = max(steepness(before), steepness(behind));
    let wide = difference(a[1], a[4]);
    let spread = beyond_slopes(wide.value, 3.0, before, behind);
    let counts = wide.is_known && spread.is_known && spread.value > KINK * steepest;
    return max(sharp, select(0.0, spread.value, counts));
}

// Position of the edge, in pixels behind the crack, between pixels of the values `raw`, both blended with the other
// side by a filter; unblended they would be `sharp`.
fn spread_offset(raw: vec2<f32>, sharp: vec2<f32>) -> f32 {
    let shares = min(abs((raw - sharp) / (sharp.y - sharp.x)), vec2<f32>(0.5));
    let offset = shares.y - shares.x;
    return select(0.0, offset, is_finite(offset));
}

// The nearer of the least and the greatest value around a pixel.
fn nearer_extreme(value: f32, least: f32, greatest: f32) -> f32 {
    return select(greatest, least, value - least < greatest - value);
}
