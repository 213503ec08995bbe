//! The parameters of contours.

use crate::params::table::{Unit, even};
use std::ops::RangeInclusive;

/// Parts of a width.
const SHARES: RangeInclusive<f32> = 0.0..=1.0;

/// Lengths in pixels.
const LENGTHS: RangeInclusive<f32> = 0.0..=1e6;

/// How far along a line steps are evened out, in pixels.
const SMOOTHINGS: RangeInclusive<f32> = 0.0..=100.0;

params! {
    /// How silhouettes and creases are drawn ([LA] section 6: they come last, over the hatching).
    pub struct ContourParams in Contours {
        /// Width of the line around the nearest thing, in pixels at scale 1.
        ///
        /// The scale is that of [strokes](crate::params::StrokeParams::scale). Below 1 lines are grey; wide ones run
        /// together.
        width_px: f32 = 2.0,
            flag: "--contour-width", form: "PX", unit: Unit::Pixels, valid: 1e-3..=1e3, useful: even(0.2, 10.0);
        /// Width of creases as a share of that; 0 draws none.
        ///
        /// 1 makes them as heavy as silhouettes.
        crease_share: f32 = 0.6, flag: "--crease-width", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Share of its width that the line around the farthest thing loses.
        ///
        /// At 0 lines say nothing of depth; at 1 the farthest vanish.
        depth_emphasis: f32 = 0.4, flag: "--depth-emphasis", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Share of its width that a line across the faintest jump of depth, or along the bluntest crease, loses.
        ///
        /// It is measured against a line before the background, or along a sharp crease. At 1 faint lines vanish.
        jump_emphasis: f32 = 0.5, flag: "--jump-emphasis", form: "SHARE", valid: SHARES;
        /// Lines that are shorter with all they are joined to are left out, in pixels; creases twice that.
        ///
        /// Blunt creases need more. 0 draws every speck of noise; high values lose small things.
        shortest_px: f32 = 12.0, flag: "--shortest-contour", form: "PX", unit: Unit::Pixels, valid: LENGTHS;
        /// Pixels over which the open end of a line runs thin.
        ///
        /// 0 ends it round.
        taper_px: f32 = 10.0, flag: "--contour-taper", form: "PX", unit: Unit::Pixels, valid: LENGTHS;
        /// Pixels to either side along a line over which the steps between pixels are evened out.
        ///
        /// It goes no farther than the line stays within the pixels it was found between, so corners stay. 0 leaves the
        /// steps; high values cost time.
        smoothing_px: f32 = 24.0, flag: "--contour-smoothing", form: "PX", unit: Unit::Pixels, valid: SMOOTHINGS;
        /// How many pixels wide the steps are that are evened out: more than 1 where the frame was
        /// [enlarged](crate::frame::Frame::enlarged).
        step_px: f32 = 1.0, unit: Unit::Pixels, valid: 1.0..=16.0;
    }
}

on_or_off! {
    /// Contours are drawn or not. Where they are not, their settings are checked and dropped.
    ContourParams as contours in Contours, flag: "--contours",
    doc: ["Lines along silhouettes and creases, over the strokes."]
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

    /// The same in a frame that was made so many `times` as large.
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
