//! What contours can be told.

use crate::error::Result;
use crate::params::in_range;
use serde::Serialize;

/// How silhouettes and creases are drawn ([LA] section 6: they come last, over the hatching).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ContourParams {
    /// Width in pixels at [stroke scale](crate::params::StrokeParams::scale) 1 of the line around the nearest
    /// thing, above 0, at most 1000. Below 1 lines are grey; wide ones run together.
    pub width_px: f32,
    /// Width of creases as a share of that, 0..1. 0 draws none; 1 makes them as heavy as silhouettes.
    pub crease_share: f32,
    /// Share of its width, 0..1, that the line around the farthest thing loses. 0 tells nothing of depth; at
    /// 1 the farthest lines vanish.
    pub depth_emphasis: f32,
    /// Share of its width, 0..1, that a line across a faint jump of depth, or along a blunt crease, loses
    /// against one before the background, or along a sharp one. At 1 faint lines vanish.
    pub jump_emphasis: f32,
    /// Length in pixels, 0 or more, that lines joined to each other must have together to be drawn; creases
    /// twice that, blunt ones more. 0 draws every speck of noise; high values lose small things.
    pub shortest_px: f32,
    /// Length in pixels, 0 or more, over which the open end of a line runs thin. 0 ends it round.
    pub taper_px: f32,
    /// How far along a line, in pixels to either side and 0 to 100, the steps between pixels are evened out.
    /// It goes no farther than the line stays within the pixels it was found between, so corners stay. 0 leaves
    /// the steps; high values cost time.
    pub smoothing_px: f32,
}

impl Default for ContourParams {
    fn default() -> Self {
        Self {
            width_px: 2.0,
            crease_share: 0.6,
            depth_emphasis: 0.4,
            jump_emphasis: 0.5,
            shortest_px: 12.0,
            taper_px: 10.0,
            smoothing_px: 24.0,
        }
    }
}

impl ContourParams {
    /// The same for lines `factor` times as large.
    pub fn scaled(self, factor: f32) -> Self {
        Self {
            width_px: factor * self.width_px,
            shortest_px: factor * self.shortest_px,
            taper_px: factor * self.taper_px,
            ..self
        }
    }

    /// Whether lines run along creases.
    pub fn has_creases(&self) -> bool {
        self.crease_share > 0.0
    }

    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        let (share, length) = (0.0..=1.0, 0.0..=1e6);
        in_range("--contour-width", self.width_px, 1e-3..=1e3)?;
        in_range("--crease-width", self.crease_share, share.clone())?;
        in_range("--depth-emphasis", self.depth_emphasis, share.clone())?;
        in_range("--jump-emphasis", self.jump_emphasis, share)?;
        in_range("--shortest-contour", self.shortest_px, length.clone())?;
        in_range("--contour-taper", self.taper_px, length)?;
        in_range("--contour-smoothing", self.smoothing_px, 0.0..=100.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_pass_and_values_out_of_range_do_not() {
        let params = ContourParams::default();
        assert!(params.validate().is_ok());
        for bad in [
            ContourParams {
                width_px: 0.0,
                ..params
            },
            ContourParams {
                width_px: f32::INFINITY,
                ..params
            },
            ContourParams {
                crease_share: 1.5,
                ..params
            },
            ContourParams {
                depth_emphasis: f32::NAN,
                ..params
            },
            ContourParams {
                jump_emphasis: -0.1,
                ..params
            },
            ContourParams {
                shortest_px: -1.0,
                ..params
            },
            ContourParams {
                taper_px: f32::NAN,
                ..params
            },
            ContourParams {
                smoothing_px: 101.0,
                ..params
            },
        ] {
            assert!(bad.validate().is_err(), "{bad:?}");
        }
    }
}
