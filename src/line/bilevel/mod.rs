//! Ink in pure black and white, for print.
//!
//! Theory: error diffusion (Floyd and Steinberg, "An adaptive algorithm for spatial greyscale", 1976) passes the error
//! of each pixel on to the pixels after it, so that tone is kept whatever the threshold. Eschbach and Knox
//! ("Error-diffusion algorithm with edge enhancement", JOSA A 8, 1991) raise the threshold where the picture is dark
//! and lower it where it is light, so that edges are sharp, and errors are compensated where they show least.
//!
//! Changes: the threshold is not one half but the one that keeps the local mean, as far as one can: a grey stroke
//! becomes a thinner black one instead of a row of dots, and little is left to error diffusion. Plain paper and solid
//! ink stay as they are, and errors skip over them.
//!
//! Practice: strokes narrower than a pixel cannot be both as light as they are and unbroken; they become dashes. A
//! threshold of one half loses them: it shifts the mean of 32x32 pixels by up to .28 in a drawing of 480x360.

mod thresholds;

use crate::frame::Plane;
use thresholds::Thresholds;

/// Weight of the distance from the threshold relative to that of errors. At 1 all grey is dots; at 6 the mean of 64x64
/// pixels is kept within .019 in drawings of 320x240 to 4960x3720; at 9 there are a third fewer specks, but means are
/// off by up to .022, and at 99 by .07 in small drawings.
const SHARPNESS: f32 = 6.0;

/// Values no farther than this from black or white are plain: half a code of 8 bits.
const PLAIN: f32 = 1.0 / 510.0;

/// Shares of an error for the pixel after, and below the one before, the pixel itself and the one after.
const SHARES: [f32; 4] = [7.0 / 16.0, 3.0 / 16.0, 5.0 / 16.0, 1.0 / 16.0];

/// `light`, 0 black to 1 white, as a plane of 0 and 1 alone that has its mean everywhere.
pub fn bilevel(light: &Plane) -> Plane {
    let (width, height) = (light.width(), light.height());
    let thresholds = Thresholds::of(light, is_plain);
    let mut chosen = Plane::filled(width, height, 0.0);
    // Errors of a row, between two that are of no pixel.
    let mut own = vec![0.0; width + 2];
    let mut below = own.clone();
    for y in 0..height {
        let (from, to) = (light.row(y), chosen.row_mut(y));
        let is_rightward = y % 2 == 0;
        for step in 0..width {
            let x = if is_rightward { step } else { width - 1 - step };
            let (light, error) = (from[x], own[x + 1]);
            let (value, error) = match is_plain(light) {
                true => (light.round(), error),
                false => decided(light, error, thresholds.at(x, y)),
            };
            to[x] = value;
            let (before, after) = match is_rightward {
                true => (x, x + 2),
                false => (x + 2, x),
            };
            own[after] += SHARES[0] * error;
            below[before] += SHARES[1] * error;
            below[x + 1] += SHARES[2] * error;
            below[after] += SHARES[3] * error;
        }
        std::mem::swap(&mut own, &mut below);
        below.fill(0.0);
    }
    chosen
}

/// Whether a pixel is plain paper or solid ink already.
fn is_plain(light: f32) -> bool {
    !(PLAIN..=1.0 - PLAIN).contains(&light)
}

/// Black or white for a grey pixel with the incoming `error`, and the error to pass on.
#[inline]
fn decided(light: f32, error: f32, threshold: f32) -> (f32, f32) {
    let is_white = error + SHARPNESS * (light - threshold) > 0.0;
    let value = f32::from(u8::from(is_white));
    (value, light + error - value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slanting strokes, `width` pixels wide and 6 apart, rims smooth, on the left two thirds; solid ink at the very left.
    fn strokes(width: f32) -> Plane {
        Plane::from_fn(240, 160, |x, y| match x {
            0..40 => 0.0,
            160.. => 1.0,
            _ => {
                let across = (0.3 * x as f32 + 0.954 * y as f32).rem_euclid(6.0);
                let covered = 0.5 * (width + 1.0) - (across - 3.0).abs();
                1.0 - covered.clamp(0.0, width.min(1.0))
            }
        })
    }

    /// The largest difference of means over windows of 64x64 pixels.
    fn largest_shift(a: &Plane, b: &Plane) -> f32 {
        let mean = |plane: &Plane, x: usize, y: usize| {
            let rows = (y..y + 64).map(|y| plane.row(y)[x..x + 64].iter().sum::<f32>());
            rows.sum::<f32>() / 4096.0
        };
        let corners = (0..=176)
            .step_by(8)
            .flat_map(|x| (0..=96).step_by(8).map(move |y| (x, y)));
        corners
            .map(|(x, y)| (mean(a, x, y) - mean(b, x, y)).abs())
            .fold(0.0, f32::max)
    }

    #[test]
    fn black_and_white_alone_keep_the_tone() {
        for width in [0.4, 0.8, 1.7, 3.1] {
            let drawn = strokes(width);
            let printed = bilevel(&drawn);
            assert!(printed.samples().iter().all(|&v| v == 0.0 || v == 1.0));
            let shift = largest_shift(&drawn, &printed);
            assert!(shift < 0.02, "{width} px: {shift}");
        }
        // Thin strokes are lost to a plain threshold: .4 px of every 6 are .067 of the paper.
        let thin = strokes(0.4);
        let threshold = thin.map(|v| f32::from(u8::from(v > 0.5)));
        assert!(largest_shift(&thin, &threshold) > 0.06);
    }

    #[test]
    fn paper_and_solid_ink_stay_plain_and_wide_strokes_whole() {
        let drawn = strokes(3.1);
        let printed = bilevel(&drawn);
        for (&was, &is) in drawn.samples().iter().zip(printed.samples()) {
            // Ink that covers a pixel stays, and so does paper that nothing touches.
            assert!(was != 0.0 && was != 1.0 || is == was);
        }
    }
}
