//! Sample points that fill the unit square evenly.

/// Numbers for one path, in 0..1, in pairs that are evenly spread over the many paths of a pixel.
///
/// Every pair is the (0, 2)-sequence of Sobol with its digits scrambled and its order shuffled, by hashes, as in B.
/// Burley: Practical Hash-based Owen Scrambling, JCGT 9(4), 2020. Each number alone is uniform, so estimates stay
/// unbiased; different seeds are independent.
#[derive(Debug, Clone)]
pub(crate) struct Sampler {
    /// Which of the pixel's paths.
    index: u32,
    seed: u32,
}

impl Sampler {
    /// The path number `index` of the pixel `pixel`, in the picture of the seed `seed`.
    pub(crate) fn new(seed: u32, pixel: u32, index: u32) -> Self {
        Self {
            index,
            seed: hash(hash(seed) ^ pixel),
        }
    }

    /// The next pair.
    #[inline]
    pub(crate) fn pair(&mut self) -> [f32; 2] {
        self.seed = hash(self.seed.wrapping_add(0x9e37_79b9));
        // Numbers that differ in their last digits stay together: a power of two of them is a whole block.
        let place = owen_scrambled(self.index, self.seed);
        let [x, y] = [place.reverse_bits(), second_sobol(place)];
        [
            unit(owen_scrambled(x, hash(self.seed ^ 0x68bc_21eb))),
            unit(owen_scrambled(y, hash(self.seed ^ 0x02e5_be93))),
        ]
    }

    /// The next number; its partner is dropped.
    #[inline]
    pub(crate) fn one(&mut self) -> f32 {
        self.pair()[0]
    }
}

/// 24 bits, so that the largest is below 1.
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

/// The second dimension of Sobol's sequence: direction numbers are the rows of Pascal's triangle modulo 2.
fn second_sobol(mut index: u32) -> u32 {
    let (mut direction, mut sum) = (1_u32 << 31, 0);
    while index != 0 {
        sum ^= direction * (index & 1);
        index >>= 1;
        direction ^= direction >> 1;
    }
    sum
}

/// Flips every bit by a hash of the bits above it: Laine and Karras' mixing acts on reversed bits.
fn owen_scrambled(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// All bits of the result depend on all bits of `x`.
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_fill_every_elementary_interval() {
        // A (0, 2)-sequence: for any division of the square into 64 elementary intervals, each holds one of the first
        // 64 points.
        for dimension in 0..5 {
            let points: Vec<[f32; 2]> = (0..64)
                .map(|i| {
                    let mut sampler = Sampler::new(7, 99, i);
                    (0..dimension).for_each(|_| _ = sampler.pair());
                    sampler.pair()
                })
                .collect();
            for wide in 0..=6 {
                let [columns, rows] = [1 << wide, 64 >> wide];
                let mut held = vec![0; 64];
                for [x, y] in &points {
                    let [column, row] = [x * columns as f32, y * rows as f32];
                    held[column as usize + columns * row as usize] += 1;
                }
                assert!(held.iter().all(|&n| n == 1), "{dimension}: {held:?}");
            }
        }
    }

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
