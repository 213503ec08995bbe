//! Sizes as shares of the picture's, so that a larger render of the same scene has the same lines.

use crate::frame::Frame;
use crate::params::InteriorParams;

/// Sizes and thresholds of interior lines. Lengths are in pixels of the level that lines are found on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sizes {
    /// Pixels of the frame to one of the level, along either axis.
    pub(super) factor: usize,
    /// Root of the area of the picture.
    pub(super) picture: f32,
    /// Scale of the normals that valleys and ridges are found in.
    pub(super) sigma: f32,
    /// Smallest distance of lines from an occluding contour.
    pub(super) margin: f32,
    /// Least strength of a line anywhere, and somewhere along it: radians that the normal turns over the picture.
    pub(super) thresholds: [f32; 2],
    /// Lengths of the shortest valley and of the shortest other line.
    pub(super) shortest: [f32; 2],
    /// Strength of a line that needs no proof: it may be as short as its fold is wide, and need not persist at a coarser
    /// scale, as the cuts of a chisel do not.
    pub(super) sharp: f32,
    /// Least integral of strength along a line: faint ones have to be long, or a rough surface fills with short lines.
    pub(super) worth: f32,
    /// Valleys, ridges and suggestive contours nearer than this to another line double it.
    pub(super) apart: [f32; 3],
    /// Widest gap that is closed.
    pub(super) gap: f32,
    /// Length of all lines together over the root of the covered area.
    pub(super) budget: f32,
    /// Whether lines fade in and out, as in a sequence.
    pub(super) fades: bool,
}

/// Largest sigma, in pixels of the level, for which a coarser level would be too coarse to place lines well.
const FINE_ENOUGH: f32 = 2.0;

/// Variance of the smoothing that Sobel's differences bring with them, in square pixels.
const SOBEL: f32 = 0.25;

impl Sizes {
    pub(super) fn of(frame: &Frame, params: &InteriorParams, fades: bool) -> Self {
        Self {
            fades,
            ..Self::of_picture(frame.display_window.size_px(), params)
        }
    }

    /// Sizes in a picture whose area has the root `root`, in pixels of the frame.
    pub(super) fn of_picture(root: f32, params: &InteriorParams) -> Self {
        let InteriorParams { detail, scale, .. } = *params;
        let factor = ((scale * root / 300.0 / FINE_ENOUGH) as usize).max(1);
        let picture = root / factor as f32;
        let fold = scale * picture;
        Self {
            factor,
            picture,
            sigma: ((fold / 290.0).powi(2) - SOBEL).max(0.4).sqrt(),
            margin: (picture / 170.0).max(2.0),
            thresholds: [9.0 / detail, 22.0 / detail],
            shortest: [fold / 42.0, fold / 30.0].map(|length| length / detail.sqrt()),
            sharp: 60.0,
            worth: fold / 20.0 * 22.0 / detail,
            apart: [220.0, 90.0, 140.0].map(|share| picture / share),
            gap: (fold / 90.0).max(4.0),
            budget: 14.0 * detail,
            fades: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_pictures_are_looked_at_on_coarse_levels() {
        // 640 x 480 has a root of 554: sigma^2 = (554/290)^2 - 0.25 = 3.399. 1920 x 1080 has one of 1440 and is
        // processed at half the size: sigma^2 = (720/290)^2 - 0.25 = 5.914.
        let of = |root, detail| {
            let params = InteriorParams {
                detail,
                ..InteriorParams::default()
            };
            Sizes::of_picture(root, &params)
        };
        let [small, large] = [554.0, 1440.0].map(|root| of(root, 1.0));
        assert_eq!((small.factor, large.factor), (1, 2));
        assert!((small.sigma - 1.844).abs() < 1e-3 && (large.sigma - 2.432).abs() < 1e-3);
        // Twice the detail halves the thresholds.
        assert_eq!(of(554.0, 2.0).thresholds, [4.5, 11.0]);
    }
}
