//! Row kernels compiled for vectors wider than the baseline's, chosen at run time.
//!
//! The compiler widens the same loops; it neither reorders nor contracts floating-point operations, so every level
//! gives the same bits. Only a kernel that asks for fused multiply-adds may give others where there are none.

/// Vector extensions of this machine. Only [`Simd::widest`] constructs one, for features it has detected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Simd(Level);

/// Vector extensions that a kernel is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Level {
    /// The baseline of the target.
    Baseline,
    /// 256 bits, with fused multiply-adds.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 512 bits, with fused multiply-adds.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Simd {
    /// All levels of this machine, the widest last.
    #[cfg(test)]
    pub(crate) fn available() -> Vec<Self> {
        let widest = Self::widest();
        #[cfg(target_arch = "x86_64")]
        let all = [Level::Baseline, Level::Avx2, Level::Avx512];
        #[cfg(not(target_arch = "x86_64"))]
        let all = [Level::Baseline];
        let levels = all.map(Self).into_iter();
        levels
            .filter(|level| level.bits() <= widest.bits())
            .collect()
    }

    /// The widest level of this machine. What was detected is kept, so that kernels can ask for each row.
    #[inline]
    pub(crate) fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            let is_wider = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq");
            return Self(if is_wider { Level::Avx512 } else { Level::Avx2 });
        }
        Self(Level::Baseline)
    }

    /// Runs a kernel compiled for this level, which must be inlined to be: see [`wide`]. It gets whether the level has fused
    /// multiply-adds.
    #[allow(
        unsafe_code,
        reason = "calling a function compiled for features that were just detected"
    )]
    #[inline]
    pub(crate) fn run<T>(self, kernel: impl FnOnce(bool) -> T) -> T {
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2,fma")]
        fn avx2<T>(kernel: impl FnOnce(bool) -> T) -> T {
            kernel(true)
        }
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2,fma,avx512f,avx512vl,avx512bw,avx512dq")]
        fn avx512<T>(kernel: impl FnOnce(bool) -> T) -> T {
            kernel(true)
        }
        match self.0 {
            Level::Baseline => kernel(Level::Baseline.has_fma()),
            // SAFETY: only `widest` constructs this level, after detecting the features.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { avx2(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { avx512(kernel) },
        }
    }

    /// Vector width in bits.
    pub(crate) fn bits(self) -> u32 {
        match self.0 {
            Level::Baseline => 128,
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => 256,
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => 512,
        }
    }
}

impl Level {
    /// Whether kernels may ask for fused multiply-adds: elsewhere each would be a call of a function. On x86 such a level
    /// has AVX2.
    pub(crate) const fn has_fma(self) -> bool {
        !matches!(self, Self::Baseline) || cfg!(target_arch = "aarch64")
    }
}

/// Calls a kernel compiled for the widest level of this machine: `wide!(hessian::trace_row(..))`, or, for one that may ask
/// for fused multiply-adds, `wide!(|fma| kernel::sweep_row(fma, ..))`. The kernel and all it calls per sample are
/// `#[inline(always)]`.
macro_rules! wide {
    (|$fma:ident| $call:expr) => {
        $crate::kernel::simd::Simd::widest().run(
            #[inline(always)]
            |$fma| $call,
        )
    };
    ($call:expr) => {
        $crate::kernel::simd::wide!(|_fma| $call)
    };
}
pub(crate) use wide;

#[cfg(test)]
pub(crate) mod levels {
    //! Whether kernels give the same bits at every level.

    use super::*;

    /// Columns of a sample row; it has two samples more.
    pub(crate) const WIDTH: usize = 83;

    /// A row of numbers between 0 and 1, determined by the seed.
    pub(crate) fn row(seed: u32) -> Vec<f32> {
        let hash = |x: u32| (x.wrapping_mul(0x9e37_79b9) ^ seed.wrapping_mul(0x85eb_ca6b)) >> 8;
        let value = |x| (hash(hash(x)) % 1000) as f32 / 1000.0;
        (0..WIDTH as u32 + 2).map(value).collect()
    }

    pub(crate) fn rows(seed: u32) -> [Vec<f32>; 3] {
        [row(seed), row(seed + 1), row(seed + 2)]
    }

    /// Calls a kernel as compiled for a level.
    macro_rules! at {
        ($simd:expr, |$fma:ident| $call:expr) => {
            $simd.run(
                #[inline(always)]
                |$fma| $call,
            )
        };
        ($simd:expr, $call:expr) => {
            $crate::kernel::simd::levels::at!($simd, |_fma| $call)
        };
    }
    pub(crate) use at;

    /// Asserts that kernels give the same bits at every level as at the baseline.
    pub(crate) fn assert_same_bits(made: impl Fn(Simd) -> Vec<Vec<f32>>) {
        let bits = |simd| -> Vec<u32> {
            let rows = made(simd).into_iter();
            rows.flatten().map(f32::to_bits).collect()
        };
        let expected = bits(Simd(Level::Baseline));
        for simd in Simd::available() {
            println!("{simd:?}");
            assert!(bits(simd) == expected, "{simd:?} has other bits");
        }
    }

    /// The levels that have fused multiply-adds.
    pub(crate) fn fused() -> impl Iterator<Item = Simd> {
        Simd::available()
            .into_iter()
            .filter(|simd| simd.0.has_fma())
    }

    /// The level without.
    pub(crate) const BASELINE: Simd = Simd(Level::Baseline);
}
