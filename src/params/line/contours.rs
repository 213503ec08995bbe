//! The parameters of contours.

use crate::params::table::{Unit, even};
use std::ops::RangeInclusive;

/// Shares of a width.
const SHARES: RangeInclusive<f32> = 0.0..=1.0;

/// Lengths in pixels.
const LENGTHS: RangeInclusive<f32> = 0.0..=1e6;

choices! {
    /// Whether lines are drawn between objects.
    pub enum ObjectLines {
        /// Where Cryptomatte or an index pass tells objects apart and no silhouette or crease runs.
        Auto = "auto",
        /// No.
        Off = "off",
    }
}

/// Distance along a line over which steps are smoothed, in pixels.
const SMOOTHINGS: RangeInclusive<f32> = 0.0..=100.0;

params! {
    /// Drawing of silhouettes and creases ([LA] section 6: last, over the hatching).
    pub struct ContourParams in Contours {
        /// Width of the line around the nearest object, in pixels at scale 1.
        ///
        /// The scale is that of [strokes](crate::params::StrokeParams::scale). Widths below 1 give grey lines; wide
        /// lines merge.
        width_px: f32 = 2.0,
            flag: "--contour-width", form: "PX", unit: Unit::Pixels, valid: 1e-3..=1e3, useful: even(0.2, 10.0);
        /// Width of creases as a share of the contour width; 0 draws none.
        ///
        /// 1 makes them as heavy as silhouettes.
        crease_share: f32 = 0.6, flag: "--crease-width", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Lines between objects that touch in one plane, as wide as those of middling jumps of depth.
        object_lines: ObjectLines = ObjectLines::Auto, flag: "--object-lines", form: "WHEN";
        /// Share of its width that the line around the farthest object loses.
        ///
        /// At 0 line width does not depend on depth; at 1 the farthest lines vanish.
        depth_emphasis: f32 = 0.4, flag: "--depth-emphasis", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Share of its width that a line across the faintest jump of depth, or along the bluntest crease, loses.
        ///
        /// Relative to a line in front of the background, or along a sharp crease. At 1 faint lines vanish.
        jump_emphasis: f32 = 0.5, flag: "--jump-emphasis", form: "SHARE", valid: SHARES;
        /// Length in pixels below which lines, measured with all lines joined to them, are left out; blunt creases count
        /// in part.
        ///
        /// Where the frame was enlarged much it is at least that of two to three of its own pixels. 0 draws every speck of
        /// noise; high values lose small objects.
        shortest_px: f32 = 12.0, flag: "--shortest-contour", form: "PX", unit: Unit::Pixels, valid: LENGTHS;
        /// Pixels over which the open end of a line tapers.
        ///
        /// 0 gives a round end.
        taper_px: f32 = 10.0, flag: "--contour-taper", form: "PX", unit: Unit::Pixels, valid: LENGTHS;
        /// Pixels to either side along a line over which its stair steps are smoothed.
        ///
        /// Smoothing stops where the line would leave the pixels it was found between, so corners stay sharp. 0 keeps
        /// the steps; high values take longer.
        smoothing_px: f32 = 24.0, flag: "--contour-smoothing", form: "PX", unit: Unit::Pixels, valid: SMOOTHINGS;
        /// Width of the stair steps in pixels: more than 1 where the frame was
        /// [enlarged](crate::frame::Frame::enlarged).
        step_px: f32 = 1.0, unit: Unit::Pixels, valid: 1.0..=16.0;
    }
}

on_or_off! {
    /// Switches contours. When off, their settings are validated and dropped.
    ContourParams as contours in Contours, flag: "--contours",
    doc: ["Lines along silhouettes and creases, over the strokes."]
}

impl ContourParams {
    /// These lines `factor` times as large.
    pub fn scaled(self, factor: f32) -> Self {
        Self {
            width_px: factor * self.width_px,
            shortest_px: factor * self.shortest_px,
            taper_px: factor * self.taper_px,
            ..self
        }
    }

    /// These lines in a frame enlarged by `times`.
    pub fn enlarged(self, times: f32) -> Self {
        Self {
            step_px: times * self.step_px,
            smoothing_px: (times * self.smoothing_px).min(*SMOOTHINGS.end()),
            ..self
        }
    }

    /// Whether lines run along creases.
    pub fn has_creases(&self) -> bool {
        self.crease_share > 0.0
    }
}
