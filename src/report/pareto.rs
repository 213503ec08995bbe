//! The Pareto front: settings that no other setting beats in both error and time.

/// Whether each of `points`, [time, error], is on the front: no other is at least as good in both and better in one. Of
/// equal points the first counts. A point with an infinite error never does.
pub(crate) fn front(points: &[[f64; 2]]) -> Vec<bool> {
    let beats = |a: [f64; 2], b: [f64; 2], earlier: bool| {
        a[0] <= b[0] && a[1] <= b[1] && (a != b || earlier)
    };
    let beaten = |i: usize| {
        let others = points.iter().enumerate().filter(|&(j, _)| j != i);
        others
            .into_iter()
            .any(|(j, &other)| beats(other, points[i], j < i))
    };
    let counts = |p: [f64; 2]| p.iter().all(|v| v.is_finite());
    (0..points.len())
        .map(|i| counts(points[i]) && !beaten(i))
        .collect()
}

/// Marks the rows on the front, by their `place`.
pub(super) fn mark<R>(
    rows: &mut [R],
    place: impl Fn(&R) -> [f64; 2],
    on_front: impl Fn(&mut R) -> &mut bool,
) {
    let places: Vec<_> = rows.iter().map(place).collect();
    for (row, is_on_front) in rows.iter_mut().zip(front(&places)) {
        *on_front(row) = is_on_front;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_points_that_none_beats_are_on_the_front() {
        let points = [
            [1.0, 1.0],
            [2.0, 0.5],
            [2.0, 0.6], // as slow as the one before, and worse
            [3.0, 0.5], // as good, and slower
            [0.5, 3.0],
            [0.1, f64::INFINITY], // the fastest gives no numbers
            [1.0, 1.0],           // a twin
        ];
        assert_eq!(
            front(&points),
            [true, true, false, false, true, false, false]
        );
    }

    #[test]
    fn along_the_front_error_falls_as_time_grows() {
        let points: Vec<_> = (1..197_u32)
            .map(|i| [f64::from(i * 73 % 199), f64::from(i * 151 % 197)])
            .collect();
        let mut kept: Vec<_> = points
            .iter()
            .zip(front(&points))
            .filter(|p| p.1)
            .map(|p| *p.0)
            .collect();
        kept.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(
            kept.len() > 1
                && kept
                    .windows(2)
                    .all(|w| w[0][0] < w[1][0] && w[0][1] > w[1][1])
        );
    }

    #[test]
    fn nothing_has_no_front() {
        assert!(front(&[]).is_empty());
    }
}
