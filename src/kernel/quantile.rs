//! Quantiles of a list of values.

use std::cmp::Ordering;

/// The `share` quantile of `values`, 0..1: the value of rank `share (n - 1)`, rounded, so that the median of an even
/// count is the upper of the middle two. `None` if `values` is empty. Reorders `values`.
pub(crate) fn quantile<T: Copy>(
    values: &mut [T],
    share: f64,
    order: impl FnMut(&T, &T) -> Ordering,
) -> Option<T> {
    let last = values.len().checked_sub(1)?;
    let rank = (share * last as f64).round() as usize;
    Some(*values.select_nth_unstable_by(rank, order).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_rounded() {
        let mut values = [4.0, 1.0, 3.0, 2.0_f64];
        let mut of = |share| quantile(&mut values, share, f64::total_cmp);
        assert_eq!([0.0, 0.5, 1.0].map(&mut of), [1.0, 3.0, 4.0].map(Some));
        assert_eq!(of(0.8), Some(3.0));
        assert_eq!(quantile(&mut [], 0.5, f32::total_cmp), None);
    }
}
