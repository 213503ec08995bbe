//! Conversion of numbers to the integer codes of pictures.

use super::format::ViewTransform;
use super::straight::clipped;
use crate::io::srgb;
use std::sync::LazyLock;

pub(super) fn code(v: f64, transform: ViewTransform, max: u32) -> u16 {
    match (transform, max) {
        (ViewTransform::Srgb, 255) => SRGB_8.code(v).into(),
        _ => computed_code(v, transform, max),
    }
}

/// Table of the 8-bit codes of the sRGB curve: computing a power per sample takes longer than everything else.
pub(super) struct SrgbCodes {
    /// The least value of each code above 0, then a bound none reaches.
    pub(super) least: [f64; 256],
    /// The code at the start of each of [`SRGB_PARTS`] equal parts of 0..1, and of the parts beyond.
    at: [u8; 2 * SRGB_PARTS],
}

/// Enough that a part has no more than two codes.
const SRGB_PARTS: usize = 4096;

pub(super) static SRGB_8: LazyLock<SrgbCodes> = LazyLock::new(SrgbCodes::new);

impl SrgbCodes {
    fn new() -> Self {
        let computed = |v| computed_code(v, ViewTransform::Srgb, 255);
        let least: [f64; 256] = std::array::from_fn(|below| {
            if below == 255 {
                return f64::INFINITY;
            }
            // Numbers above 0 are in the order of their bits.
            let (mut lower, mut upper) = (0, 1.0_f64.to_bits());
            while lower < upper {
                let middle = lower.midpoint(upper);
                match usize::from(computed(f64::from_bits(middle))) > below {
                    true => upper = middle,
                    false => lower = middle + 1,
                }
            }
            f64::from_bits(lower)
        });
        let at = std::array::from_fn(|part| computed(part as f64 / SRGB_PARTS as f64) as u8);
        Self { least, at }
    }

    /// The code of a number. Codes are farther apart than parts: one step is enough.
    #[inline]
    pub(super) fn code(&self, v: f64) -> u8 {
        let v = clipped(v);
        // The mask only removes a bounds check.
        let code = self.at[(v * SRGB_PARTS as f64) as usize & (2 * SRGB_PARTS - 1)];
        code + u8::from(v >= self.least[usize::from(code)])
    }
}

pub(super) fn computed_code(v: f64, transform: ViewTransform, max: u32) -> u16 {
    let encoded = match transform {
        ViewTransform::Srgb => srgb::encoded(clipped(v)),
        ViewTransform::None => clipped(v),
    };
    (encoded * f64::from(max)).round() as u16
}
