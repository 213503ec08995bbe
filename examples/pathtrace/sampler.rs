//! Sample points that fill the unit square evenly.

use sobol_burley::{NUM_DIMENSIONS, sample};

/// Points of the sequence.
const POINTS: u32 = 1 << 16;

/// Numbers for one path, in 0..1, in pairs that are evenly spread over the many paths of a pixel: Sobol's sequence, Owen
/// scrambled. Different pixels and seeds are independent.
#[derive(Debug, Clone)]
pub(crate) struct Sampler {
    /// Which of the pixel's paths.
    index: u32,
    seed: u32,
    dimension: u32,
}

impl Sampler {
    /// The path number `index` of the pixel `pixel`, in the picture of the seed `seed`.
    pub(crate) fn new(seed: u32, pixel: u32, index: u32) -> Self {
        Self {
            index,
            // Neighbours of the sequence's own seeds are independent too; this keeps pictures apart.
            seed: seed.wrapping_mul(0x9e37_79b9) ^ pixel,
            dimension: 0,
        }
    }

    /// The next number.
    #[inline]
    pub(crate) fn one(&mut self) -> f32 {
        // What outlives points or dimensions begins anew, scrambled otherwise.
        let (block, index) = (self.index / POINTS, self.index % POINTS);
        let seed =
            self.seed ^ (self.dimension / NUM_DIMENSIONS) << 24 ^ block.wrapping_mul(0x85eb_ca6b);
        let number = sample(index, self.dimension % NUM_DIMENSIONS, seed);
        self.dimension += 1;
        number
    }

    /// The next pair; both of one pair of dimensions.
    #[inline]
    pub(crate) fn pair(&mut self) -> [f32; 2] {
        self.dimension = self.dimension.next_multiple_of(2);
        [self.one(), self.one()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_dimensions_are_independent() {
        // The mean of x y over 4096 pixels is 1/4 within 4 of its standard errors, sqrt(7)/12 / 64 each.
        let product = |partner: fn(&mut Sampler) -> f32| {
            let products = (0..4096).map(|pixel| {
                let mut sampler = Sampler::new(1, pixel, 3);
                f64::from(sampler.one() * partner(&mut sampler))
            });
            products.sum::<f64>() / 4096.0
        };
        let error = 7.0_f64.sqrt() / 12.0 / 64.0;
        assert!((product(|s| s.one()) - 0.25).abs() < 4.0 * error);
        assert!((product(|s| s.pair()[1]) - 0.25).abs() < 4.0 * error);
    }
}
