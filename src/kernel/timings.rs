//! Times of passes.

use std::time::Duration;

/// Passes by name, with the time of each, in order.
pub(crate) type Timings = Vec<(&'static str, Duration)>;

/// Adds times to those of the same passes.
pub(crate) fn add_timings(sum: &mut Timings, more: &[(&'static str, Duration)]) {
    for &(pass, time) in more {
        match sum.iter_mut().find(|(name, _)| *name == pass) {
            Some((_, sum)) => *sum += time,
            None => sum.push((pass, time)),
        }
    }
}
