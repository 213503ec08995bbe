//! Statistics that tones are fitted to, of one picture or of several together.

use crate::params::ToneLevels;

/// Shares of the form-showing pixels at which quantiles are stored.
pub(super) const SHARES: [f32; 13] = [
    0.0, 0.02, 0.05, 0.10, 0.20, 0.30, 0.40, 0.50, 0.60, 0.70, 0.80, 0.95, 1.0,
];

/// The places among them of the brightness that counts as darkest, and as lightest.
const ENDS: [usize; 2] = [1, 11];

/// The least spread between the 10th and the 90th percentile, in stops, that is taken for a surface's own: less is noise.
const LEAST_SPREAD: f32 = 0.3;

/// Centre and spread of values, to compare those of two kinds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scatter {
    /// The median.
    pub(super) middle: f32,
    /// Distance from the 10th to the 90th percentile.
    pub(super) width: f32,
}

impl Scatter {
    /// Distance of a value above the centre, in spreads.
    #[inline(always)]
    pub(super) fn standard(self, value: f32) -> f32 {
        (value - self.middle) / self.width.max(LEAST_SPREAD)
    }
}

/// Scales of brightness in stops, and in spreads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scales {
    /// The median luminance.
    pub(super) median: f32,
    /// Brightness of the picture, in stops about the median, and brightness in the key light.
    pub(super) picture: Scatter,
    pub(super) key: Scatter,
}

/// The brightness that each of [`SHARES`] is below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ranks(pub(super) [f32; SHARES.len()]);

impl Ranks {
    /// The rank, 0..1, of a brightness.
    pub(super) fn rank(&self, value: f32) -> f32 {
        let above = self.0.partition_point(|&brightness| brightness <= value);
        let Some(below) = above.checked_sub(1) else {
            return 0.0;
        };
        if above == SHARES.len() {
            return 1.0;
        }
        let share = (value - self.0[below]) / (self.0[above] - self.0[below]);
        SHARES[below] + share * (SHARES[above] - SHARES[below])
    }

    /// Relative position of a brightness between the darkest, 0, and the lightest, 1, or beyond.
    pub(super) fn place(&self, value: f32) -> f32 {
        let [darkest, lightest] = ENDS.map(|end| self.0[end]);
        (value - darkest) / (lightest - darkest).max(f32::MIN_POSITIVE)
    }
}

/// The levels that were given, if they were.
pub(super) fn given(levels: ToneLevels) -> Option<(Scales, Ranks)> {
    let ToneLevels::Given([median, picture, picture_width, key, key_width, ranks @ ..]) = levels
    else {
        return None;
    };
    let spread = |middle, width| Scatter { middle, width };
    let scales = Scales {
        median,
        picture: spread(picture, picture_width),
        key: spread(key, key_width),
    };
    Some((scales, Ranks(ranks)))
}

/// The levels as numbers, in the order of [`ToneLevels::Given`].
pub(super) fn as_numbers(scales: &Scales, ranks: &Ranks) -> [f32; ToneLevels::COUNT] {
    let Scales {
        median,
        picture,
        key,
    } = *scales;
    let scales = [median, picture.middle, picture.width, key.middle, key.width];
    std::array::from_fn(|i| {
        scales
            .get(i)
            .copied()
            .unwrap_or_else(|| ranks.0[i - scales.len()])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_lie_between_those_that_are_known() {
        // Half-way between the brightness of 40 % and that of 50 % it is 45 %; equal quantiles give the rank of the
        // last of them. From 2 to 95 % brightness runs from 1 to 10 here.
        let ranks = Ranks([
            0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0,
        ]);
        let found = [-1.0, 0.0, 4.0, 5.5, 11.0, 12.0].map(|value| ranks.rank(value));
        let expected = [0.0, 0.0, 0.3, 0.45, 1.0, 1.0];
        let near = |(a, b): (&f32, f32)| (a - b).abs() < 1e-6;
        assert!(found.iter().zip(expected).all(near), "{found:?}");
        assert_eq!(
            [1.0, 5.5, 10.0].map(|value| ranks.place(value)),
            [0.0, 0.5, 1.0]
        );
        let level = Ranks([2.0; SHARES.len()]);
        assert_eq!([1.0, 2.0].map(|value| level.rank(value)), [0.0, 1.0]);
    }

    #[test]
    fn levels_are_numbers_and_back() {
        let numbers = std::array::from_fn(|i| i as f32);
        let (scales, ranks) = given(ToneLevels::Given(numbers)).expect("they are given");
        assert_eq!(as_numbers(&scales, &ranks), numbers);
        assert_eq!(given(ToneLevels::Auto), None);
    }
}
