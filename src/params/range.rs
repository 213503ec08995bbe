//! Ranges of numbers.

use crate::error::{Error, Result, short};
use std::ops::RangeInclusive;

/// Angles in degrees: beyond a million, single precision no longer resolves a direction.
pub(super) const ANGLES_DEG: RangeInclusive<f32> = -1e6..=1e6;

/// Refuses a `value` of the parameter `name` unless it lies in `range`.
///
/// # Errors
/// [`Error::BadParameter`] naming the range.
pub(crate) fn in_range(name: &'static str, value: f32, range: RangeInclusive<f32>) -> Result<()> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(Error::BadParameter {
        name,
        found: format!("is {}", short(value)),
        remedy: format!("give {} to {}", short(*range.start()), short(*range.end())),
    })
}
