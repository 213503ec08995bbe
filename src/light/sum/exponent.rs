//! Powers of cosines, for a batch of pixels.

use crate::kernel::fast_math::{exp, ln};
use crate::light::batch::Lanes;

/// An exponent: small integers are computed by multiplication.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Exponent {
    /// An integer from 1 on.
    Integer(u32),
    /// Any non-negative number.
    Real(f32),
}

impl Exponent {
    /// Largest integer exponent computed by multiplication: ten squarings cost as much as a logarithm.
    const MOST: f32 = 1024.0;

    /// The representation of this exponent, clamped to at least 0.
    pub(crate) fn of(exponent: f32) -> Self {
        if (1.0..=Self::MOST).contains(&exponent) && exponent.fract() == 0.0 {
            Self::Integer(exponent as u32)
        } else {
            Self::Real(exponent)
        }
    }

    /// Raises numbers from 0 to 1 to this exponent; 0 stays 0.
    #[inline(always)]
    pub(crate) fn raise(self, base: &mut Lanes) {
        match self {
            Self::Integer(exponent) => raise_to_whole(base, exponent),
            Self::Real(exponent) => {
                for x in base.iter_mut() {
                    let raised = exp(exponent * ln(x.max(f32::MIN_POSITIVE)));
                    *x = if *x > 0.0 { raised } else { 0.0 };
                }
            }
        }
    }
}

/// Square-and-multiply from the highest bit of the exponent, a few lanes at a time in registers.
#[inline(always)]
fn raise_to_whole(base: &mut Lanes, exponent: u32) {
    let digits = u32::BITS - exponent.leading_zeros();
    for few in base.as_chunks_mut::<64>().0 {
        let mut raised = *few;
        for digit in (0..digits - 1).rev() {
            for x in &mut raised {
                *x *= *x;
            }
            if exponent >> digit & 1 == 1 {
                for (raised, once) in raised.iter_mut().zip(&*few) {
                    *raised *= once;
                }
            }
        }
        *few = raised;
    }
}
