//! Random and hostile values.

use wgpu::naga::ScalarKind;

/// Numbers at which formulas break.
const HOSTILE: [f32; 20] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    // The smallest and the largest subnormal.
    1e-45,
    -1e-45,
    1.175_494_2e-38,
    f32::EPSILON,
    1e-20,
    -1e20,
    1e20,
    16_777_216.0,
];

/// A reproducible source of values.
pub(super) struct Values {
    state: u64,
    /// Numbers at which the function branches.
    thresholds: Vec<f32>,
    /// The previous value, since equal arguments are a case of their own.
    last: u32,
    /// Whether only numbers of ordinary magnitude are given, as on most pixels.
    is_tame: bool,
}

impl Values {
    /// Values for the function `name` with these thresholds.
    pub(super) fn new(name: &str, thresholds: Vec<f32>) -> Self {
        let seed = name.bytes().fold(1, |sum: u64, b| {
            sum.wrapping_mul(0x100_0000_01b3) ^ u64::from(b)
        });
        Self {
            state: seed,
            thresholds,
            last: 0,
            is_tame: false,
        }
    }

    /// Words of these kinds; all of ordinary magnitude on every second call.
    pub(super) fn fill(&mut self, words: &mut Vec<u32>, kinds: &[ScalarKind]) {
        self.is_tame = !self.is_tame;
        words.clear();
        for &kind in kinds {
            let word = self.next(kind);
            words.push(word);
        }
    }

    pub(super) fn next(&mut self, kind: ScalarKind) -> u32 {
        let word = match kind {
            ScalarKind::Float => self.float(),
            ScalarKind::Bool => self.bits() & 1,
            _ => match self.bits() % 4 {
                0 => self.bits(),
                1 => [0, 1, u32::MAX, i32::MAX as u32, i32::MIN as u32][self.below(5)],
                _ => self.bits() % 16,
            },
        };
        self.last = word;
        word
    }

    fn float(&mut self) -> u32 {
        if self.is_tame {
            return self.common().to_bits();
        }
        match self.bits() % 8 {
            0 | 1 => HOSTILE[self.below(HOSTILE.len())].to_bits(),
            2 if !self.thresholds.is_empty() => {
                let chosen = self.below(self.thresholds.len());
                let at = self.thresholds[chosen];
                let at = if self.bits() & 3 == 0 { -at } else { at };
                [at, at.next_up(), at.next_down()][self.below(3)].to_bits()
            }
            // Any exponent.
            3 => self.bits(),
            4 => self.last,
            _ => self.common().to_bits(),
        }
    }

    /// -1..1, or up to a hundred in magnitude.
    fn common(&mut self) -> f32 {
        let signed = self.bits() as i32 as f32 / 2_147_483_648.0;
        match self.bits() % 4 {
            0 => 100.0 * signed,
            _ => signed,
        }
    }

    fn below(&mut self, count: usize) -> usize {
        self.bits() as usize % count
    }

    /// 32 random bits (splitmix64).
    fn bits(&mut self) -> u32 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }
}
