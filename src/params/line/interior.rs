//! The parameters of interior lines.

use crate::params::line::levels::LineLevels;
use crate::params::table::{Unit, by_factors, even};
use std::ops::RangeInclusive;

/// Shares of a width.
const SHARES: RangeInclusive<f32> = 0.0..=1.0;

params! {
    /// Lines inside surfaces, where the normal turns fastest and where a surface almost turns away.
    ///
    /// Lengths are relative to the size of the picture, the root of its area.
    pub struct InteriorParams in Contours {
        /// Amount of lines inside surfaces: divides the strength that a line needs, and multiplies their total length.
        ///
        /// Below 1 only the strongest remain; high values draw every ripple.
        detail: f32 = 1.0, flag: "--line-detail", common: true, form: "D", valid: 0.05..=20.0, useful: by_factors(0.25, 4.0);
        /// Size of the folds traced by lines inside surfaces, as a factor of a 300th of the picture's size.
        ///
        /// Below 1 they follow finer forms, such as letters in stone; above 1 only broad ones.
        scale: f32 = 1.0, flag: "--line-scale", form: "S", valid: 0.1..=10.0, useful: by_factors(0.2, 5.0);
        /// Width of the heaviest line inside a surface, in pixels of a 640 by 480 picture; it scales with the picture,
        /// not with --stroke-scale.
        width_px: f32 = 2.3,
            flag: "--line-width", form: "PX", unit: Unit::Pixels, valid: 1e-3..=1e3, useful: even(0.2, 10.0);
        /// Width of ridge lines as a share of the width of valley lines; 0 draws none.
        ridge_share: f32 = 0.7, flag: "--ridge-width", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Width of lines along cast shadow edges as a share of the width of valley lines; 0 draws none.
        ///
        /// They run where the picture changes by more than the turning of the surface explains. Where the frame has an
        /// albedo, paint does not count as shadow.
        shadow_share: f32 = 0.0, flag: "--shadow-width", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Share of its width that the faintest line inside a surface loses.
        strength_emphasis: f32 = 0.5, flag: "--line-strength", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Share of its width that the farthest line inside a surface loses.
        depth_emphasis: f32 = 0.2, flag: "--line-depth", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Share of its width that a line inside a surface loses where a lamp from the upper left lights it fully.
        ///
        /// Lines in shadow keep their width. At 1 lines in full light vanish.
        light_emphasis: f32 = 0.2, flag: "--line-light", form: "SHARE", valid: SHARES, useful: even(0.0, 1.0);
        /// Levels that widths of lines inside surfaces are fitted to, as a run writes them to a recipe; auto fits the
        /// picture.
        ///
        /// Chosen once per sequence, so that lines keep their weight.
        levels: LineLevels = LineLevels::Auto, flag: "--line-levels", form: "STRONGEST,NEAR,FAR|auto";
    }
}

on_or_off! {
    /// Switches interior lines. When off, their settings are validated and dropped.
    InteriorParams as interior in Contours, flag: "--interior",
    doc: ["Lines inside surfaces: along valleys and ridges, and where a surface all but turns away."]
}

impl InteriorParams {
    /// Whether lines run along ridges.
    pub fn has_ridges(&self) -> bool {
        self.ridge_share > 0.0
    }

    /// Whether lines run along the edges of cast shadows.
    pub fn has_shadows(&self) -> bool {
        self.shadow_share > 0.0
    }
}
