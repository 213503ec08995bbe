//! Tone: how dark a picture is drawn.

use crate::params::Adaptive;
use crate::params::light::LEVELS;
use crate::params::line::levels::ToneLevels;
use crate::params::table::{by_factors, even};

params! {
    /// From the luminance of a picture to the tone of paper: 0 black, 1 the paper itself.
    pub struct ToneParams in Tone {
        /// Share of a key light in a tone that shows the shape; the rest is the picture's own light.
        ///
        /// It is for --tone auto. More show forms in flat light; 0 leaves the picture its light and its colours' tones.
        key_share: f32 = 0.65, flag: "--key-share", form: "SHARE", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// How surfaces without form that reach the border of the picture are drawn: floors, walls.
        ///
        /// It is for --tone auto too.
        background: Background = Background::Plain, flag: "--background", form: "HOW";
        /// Paper left bare behind the rim of what stands before something else, as a factor of a 350th of the picture's
        /// size.
        ///
        /// It is for --tone auto too, and takes depth. 0 leaves none; wide ones read as light.
        halo: f32 = 1.0, flag: "--halo", form: "FACTOR", valid: 0.0..=20.0, useful: even(0.0, 4.0);
        /// What a tone that shows the shape is fit to, as a run prints it to a recipe; auto fits the picture.
        ///
        /// It is for --tone auto. In a sequence it is chosen once, so that tones do not flicker.
        levels: ToneLevels = ToneLevels::Auto, flag: "--tone-levels", form: "L,...|auto";
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
    /// How surfaces without form that reach the border of the picture are drawn.
    pub enum Background {
        /// As all others.
        Strokes = "strokes",
        /// With few strokes: the subject stands out.
        Plain = "plain",
        /// Not at all.
        None = "none",
    }
}

choices! {
    /// Where the tone of a drawing comes from.
    pub enum ToneSource {
        /// What shows the shape: a key light with the picture, or with new light where any is given, from ink to paper.
        Auto = "auto",
        /// The picture by radiance scaling.
        Enhance = "enhance",
        /// The picture as it is.
        Picture = "picture",
        /// New light.
        Relight = "relight",
    }
}
