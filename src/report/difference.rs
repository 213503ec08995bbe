//! How far a picture is from another, in the grey levels of a display.

use serde::Serialize;

/// A picture as a display has it, of 65,535 codes a channel, red, green, blue and alpha: 257 codes are a grey level.
pub(super) type Codes = Vec<[u16; 4]>;

const CODES_PER_LEVEL: f64 = 257.0;

/// Differences of two pictures over the pixels that count: of each pixel the largest of its channels, in levels of 255.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct CodeDifference {
    /// What half of the pixels do not exceed.
    pub p50: f64,
    /// What 99 of 100 pixels do not exceed.
    pub p99: f64,
    pub largest: f64,
    /// Share of pixels that differ by more than 1 level.
    pub beyond_1: f64,
    /// Share of pixels that differ by more than 2 levels.
    pub beyond_2: f64,
}

impl CodeDifference {
    /// The difference of two pictures of one size, over the pixels for which `counts`; none is no difference.
    pub(super) fn between(a: &Codes, b: &Codes, counts: &[bool]) -> Self {
        let mut histogram = vec![0_usize; usize::from(u16::MAX) + 1];
        let mut pixels = 0_usize;
        // Several maps are one after the other, over the same pixels.
        for ((a, b), _) in a
            .iter()
            .zip(b)
            .zip(counts.iter().cycle())
            .filter(|(_, counts)| **counts)
        {
            let off = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
            histogram[usize::from(off.unwrap_or(0))] += 1;
            pixels += 1;
        }
        let exceeded_by = |rank: usize| {
            let mut below = 0;
            let found = histogram.iter().position(|&count| {
                below += count;
                below >= rank.max(1)
            });
            found.unwrap_or(0) as f64 / CODES_PER_LEVEL
        };
        let quantile = |share: f64| exceeded_by((share * pixels as f64).ceil() as usize);
        let beyond = |levels: usize| {
            let from = levels * CODES_PER_LEVEL as usize + 1;
            histogram[from..].iter().sum::<usize>() as f64 / pixels.max(1) as f64
        };
        match pixels {
            0 => Self::default(),
            _ => Self {
                p50: quantile(0.5),
                p99: quantile(0.99),
                largest: exceeded_by(pixels),
                beyond_1: beyond(1),
                beyond_2: beyond(2),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_and_shares_of_known_differences() {
        // 100 pixels: 60 alike, 38 off by 1.5 levels in one channel, one by 3, one by 50 that does not count.
        let at = |code: u16| [100, 100 + code, 100, u16::MAX];
        let a: Codes = vec![at(0); 101];
        let b = (0..101).map(|i| match i {
            0..60 => at(0),
            60..99 => at(385),
            99 => at(771),
            _ => at(12_850),
        });
        let counts: Vec<bool> = (0..101).map(|i| i < 100).collect();
        let found = CodeDifference::between(&a, &b.collect(), &counts);
        assert_eq!(found.p50, 0.0);
        assert_eq!(found.p99, 385.0 / 257.0);
        assert_eq!(found.largest, 3.0);
        assert_eq!((found.beyond_1, found.beyond_2), (0.4, 0.01));
        let nothing = CodeDifference::between(&a, &a, &[false]);
        assert_eq!(nothing, CodeDifference::default());
    }
}
