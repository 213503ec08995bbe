//! Widths of interior lines.

use crate::line::contours::network::Line;
use crate::line::contours::{Contour, ContourKind, DepthRange, tapered};
use crate::line::interior::fade::by_strength;
use crate::line::interior::sizes::Sizes;
use crate::line::smooth_step::smooth_step;
use crate::params::{InteriorParams, LineLevels};
use glam::Vec3;

/// The inputs of line widths besides the line itself.
pub(super) struct Pen {
    /// Width of the heaviest line, in pixels.
    pub(super) width_px: f32,
    /// Pixels over which open ends run thin.
    pub(super) taper_px: f32,
    /// The strength from which lines get their full weight.
    pub(super) strongest: f32,
    pub(super) depths: DepthRange,
    /// The least strength of a line, at which it fades to nothing; `None` if lines do not fade.
    pub(super) faded: Option<f32>,
}

/// Spots to either side over which widths change.
const WIDTH_REACH: usize = 4;

/// Exponent of the taper at an open end: below 1 it stays heavy for long, and comes to a point.
const TAPER: f32 = 0.6;

/// Part of the taper whose width the very end has.
const TIP: f32 = 0.05;

/// Direction to the lamp that makes lines lighter: from the upper left, 135 degrees around and 38 up.
const LAMP: Vec3 = Vec3::new(-0.5572, 0.5572, 0.6157);

/// The root of the area of a picture for which widths are given: 640 by 480.
const PICTURE: f32 = 554.3;

impl Pen {
    /// The pen for lines of a picture whose area has the root `picture`.
    pub(super) fn new(
        picture: f32,
        params: &InteriorParams,
        [strongest, near, far]: [f32; LineLevels::COUNT],
        sizes: &Sizes,
    ) -> Self {
        Self {
            width_px: params.width_px * picture / PICTURE,
            taper_px: picture / 45.0,
            strongest,
            depths: DepthRange { near, far },
            faded: sizes.fades.then_some(sizes.thresholds[0]),
        }
    }

    /// The contour along a line of a kind drawn with a share of its width, with strengths in its spots; `normal` gives the
    /// normal of the surface at a spot by its number.
    pub(super) fn contour(
        &self,
        (kind, fade): (ContourKind, f32),
        line: &Line,
        params: &InteriorParams,
        normal: impl Fn(usize) -> Vec3,
    ) -> Contour {
        let share = match kind {
            ContourKind::Ridge => params.ridge_share,
            ContourKind::Shadow => params.shadow_share,
            _ => 1.0,
        };
        let widths = line.spots.iter().enumerate().map(|(i, spot)| {
            let strongest = self.strongest.max(f32::MIN_POSITIVE);
            let faint = 1.0 - smooth_step([0.0, strongest], spot.strength);
            let lit = LAMP.dot(normal(i)).max(0.0);
            let far = self.depths.farness(spot.log_depth);
            let left = |emphasis: f32, share: f32| 1.0 - emphasis * share;
            let light = left(params.light_emphasis, lit) * left(params.depth_emphasis, far);
            let there = |least: f32| fade * by_strength(spot.strength / least);
            let width = self.width_px * share * light * left(params.strength_emphasis, faint);
            width * self.faded.map_or(1.0, there)
        });
        let taper = |from_end: f32, _| self.taper(from_end);
        tapered(line, kind, widths.collect(), WIDTH_REACH, taper)
    }

    /// The share of its width that a line has so far from an open end: it comes to a point.
    fn taper(&self, from_end: f32) -> f32 {
        match from_end < self.taper_px {
            true => (from_end / self.taper_px).max(TIP).powf(TAPER),
            false => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_ends_come_to_a_point() {
        let params = InteriorParams::default();
        let sizes = Sizes::of_picture(PICTURE, &params);
        let pen = Pen::new(PICTURE, &params, [20.0, 0.0, 0.0], &sizes);
        // A taper of 554.3/45 = 12.3 pixels: 0.05^0.6 at the end, (6/12.3)^0.6 six pixels on.
        assert!((pen.taper(0.0) - 0.166).abs() < 1e-3 && (pen.taper(6.0) - 0.650).abs() < 1e-3);
        assert_eq!(pen.taper(50.0), 1.0);
    }
}
