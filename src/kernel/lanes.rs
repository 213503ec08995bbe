//! What kernels do to the lanes of a vector in a way that depends on their [level](super::simd::Level).
//!
//! `fma` is whether the level that the caller is compiled for has fused multiply-adds, as `wide` tells a kernel: a constant
//! by then.
//! Shifts take it to mean that there is AVX2, and must not be told so elsewhere.
//!
//! The loops over lanes are written so that the compiler makes shuffles of them: time any other form.

/// The lanes one place to the right of those of `at`, behind the last one of `before`.
#[inline(always)]
pub(crate) fn shifted_right<const N: usize>(
    fma: bool,
    before: &[f32; N],
    at: &[f32; N],
) -> [f32; N] {
    #[cfg(target_arch = "x86_64")]
    if fma && N == 8 {
        return straddling_avx2::<N, 7>(before, at);
    }
    let mut shifted = [before[N - 1]; N];
    for (to, from) in shifted[1..].iter_mut().zip(at) {
        *to = *from;
    }
    shifted
}

/// The lanes one place to the left of those of `at`, in front of the first one of `after`.
#[inline(always)]
pub(crate) fn shifted_left<const N: usize>(fma: bool, at: &[f32; N], after: &[f32; N]) -> [f32; N] {
    #[cfg(target_arch = "x86_64")]
    if fma && N == 8 {
        return straddling_avx2::<N, 1>(at, after);
    }
    let mut shifted = [after[0]; N];
    for (to, from) in shifted.iter_mut().zip(&at[1..]) {
        *to = *from;
    }
    shifted
}

/// The eight lanes from `FROM`, 1 or 7, of `a` and `b` in a row, by two instructions of AVX2 where the compiler takes
/// three.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "lanes are loaded and stored by address")]
#[inline(always)]
fn straddling_avx2<const N: usize, const FROM: usize>(a: &[f32; N], b: &[f32; N]) -> [f32; N] {
    use std::arch::x86_64::*;
    assert_eq!(N, 8);
    let mut lanes = [0.0; N];
    // SAFETY: there are eight lanes, and the levels with fused multiply-adds have AVX2.
    unsafe {
        let [a, b] = [a, b].map(|lanes| _mm256_loadu_si256(lanes.as_ptr().cast()));
        let middle = _mm256_permute2x128_si256::<0x21>(a, b);
        let straddling = match FROM {
            1 => _mm256_alignr_epi8::<4>(middle, a),
            _ => _mm256_alignr_epi8::<12>(b, middle),
        };
        _mm256_storeu_si256(lanes.as_mut_ptr().cast(), straddling);
    }
    lanes
}

/// `a b + c`, rounded once where multiply-adds are fused.
#[inline(always)]
pub(crate) fn multiply_add(fma: bool, a: f32, b: f32, c: f32) -> f32 {
    match fma {
        true => a.mul_add(b, c),
        false => a * b + c,
    }
}
