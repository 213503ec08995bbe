//! A step without corners.

/// From 0 to 1 between two values, with level ends.
#[inline(always)]
pub(super) fn smooth_step([from, to]: [f32; 2], value: f32) -> f32 {
    let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
