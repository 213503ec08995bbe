//! Tone: how dark a picture is drawn.

use crate::params::Adaptive;
use crate::params::light::LEVELS;
use crate::params::line::levels::ToneLevels;
use crate::params::table::{by_factors, even};

params! {
    /// Mapping from the luminance of a picture to the tone of paper: 0 black, 1 the paper itself.
    pub struct ToneParams in Tone {
        /// Share of a key light in shape-showing tones; the rest is the picture's own light.
        ///
        /// Used by --tone auto. More shows forms in flat light; 0 keeps the light and local tones of the picture.
        key_share: f32 = 0.65, flag: "--key-share", form: "SHARE", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// Drawing of surfaces without form that reach the border of the picture, such as floors and walls.
        ///
        /// Used by --tone auto.
        background: Background = Background::Plain, flag: "--background", common: true, form: "HOW";
        /// Width of the gap of bare paper behind the rim of a nearer object, as a factor of a 350th of the picture's
        /// size.
        ///
        /// Used by --tone auto; needs depth. 0 leaves no gap; wide gaps read as light.
        halo: f32 = 1.0, flag: "--halo", form: "FACTOR", valid: 0.0..=20.0, useful: even(0.0, 4.0);
        /// Levels that shape-showing tones are fitted to, as a run writes them to a recipe; auto fits the picture.
        ///
        /// Used by --tone auto. Chosen once per sequence, so that tones do not flicker.
        levels: ToneLevels = ToneLevels::Auto, flag: "--tone-levels", form: "L,...|auto";
        /// Luminance above which paper stays white, or auto to fit the picture.
        ///
        /// In scene-linear units. Auto takes a high percentile over the surface.
        white_point: Adaptive = Adaptive::Auto,
            flag: "--white-point", form: "L|auto", valid: LEVELS, useful: by_factors(0.01, 10.0);
        /// Share of the white point below which the drawing is black.
        black_point: f32 = 0.0, flag: "--black-point", form: "B", valid: 0.0..=0.99, useful: even(0.0, 0.9);
        /// Tone curve: at 1 the drawing matches the picture's brightness from afar; more lightens it.
        ///
        /// Tone is (luminance / white point)^(1 / gamma). Higher values approach perceived brightness.
        gamma: f32 = 2.2, flag: "--tone-gamma", form: "G", valid: 0.1..=10.0, useful: even(0.2, 3.0);
    }
}

choices! {
    /// Drawing of surfaces without form that reach the border of the picture.
    pub enum Background {
        /// Like all other surfaces.
        Strokes = "strokes",
        /// With few strokes, so that the subject stands out.
        Plain = "plain",
        /// Left blank.
        None = "none",
    }
}

choices! {
    /// Where the tone of a drawing comes from.
    pub enum ToneSource {
        /// Shape: a key light combined with the picture, or with new light where any is given, stretched from ink to
        /// paper.
        Auto = "auto",
        /// The picture after radiance scaling.
        Enhance = "enhance",
        /// The picture unchanged.
        Picture = "picture",
        /// New light.
        Relight = "relight",
    }
}
