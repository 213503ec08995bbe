//! Tone: how dark a picture is drawn.

use crate::params::Adaptive;
use crate::params::light::LEVELS;
use crate::params::table::{by_factors, even};

params! {
    /// From the luminance of a picture to the tone of paper: 0 black, 1 the paper itself.
    pub struct ToneParams in Tone {
        /// Luminance from which on paper stays white, or auto to fit the picture.
        ///
        /// It is scene-linear. Auto takes a high percentile of the surface's own.
        white_point: Adaptive = Adaptive::Auto,
            flag: "--white-point", form: "L|auto", valid: LEVELS, useful: by_factors(0.01, 10.0);
        /// Share of the white point up to which all is black.
        black_point: f32 = 0.0, flag: "--black-point", form: "B", valid: 0.0..=0.99, useful: even(0.0, 0.9);
        /// Tone curve: at 1 the drawing is as bright as the picture from afar; more lightens it.
        ///
        /// Tone is the share of white to the power of 1 / gamma. Higher values approach what eyes call as bright.
        gamma: f32 = 2.2, flag: "--tone-gamma", form: "G", valid: 0.1..=10.0, useful: even(0.2, 3.0);
    }
}

choices! {
    /// Where the tone of a drawing comes from.
    pub enum ToneSource {
        /// New light where any is given or there is no picture, else the picture by radiance scaling.
        Auto = "auto",
        /// The picture by radiance scaling.
        Enhance = "enhance",
        /// The picture as it is.
        Picture = "picture",
        /// New light.
        Relight = "relight",
    }
}
