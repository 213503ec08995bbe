// A soft step: 0 up to lo, 1 from hi, linear between.
fn soft_weight(value: f32, lo: f32, hi: f32) -> f32 {
    if value >= hi {
        return 1.0;
    }
    if value <= lo {
        return 0.0;
    }
    return (value - lo) / (hi - lo);
}
