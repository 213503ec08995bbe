// A soft step: 0 up to lo, 1 from hi, linear between.
fn soft_threshold_weight(value: f32, lo: f32, hi: f32) -> f32 {
    let between = (value - lo) / (hi - lo);
    return select(select(between, 0.0, value <= lo), 1.0, value >= hi);
}
