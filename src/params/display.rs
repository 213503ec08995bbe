//! The parameters of the mapping from linear light to a display.

use super::table::even;
use std::ops::RangeInclusive;

number_or_word! {
    /// Stops by which a picture is made brighter, or darker.
    pub enum Exposure {
        /// New light is dimmed where it would burn; a picture keeps its own.
        Auto = "auto",
        /// Given.
        Stops(f32),
    }
    whole: false,
    numbers: |number| number.is_finite(),
    expected: "expected auto or a number of stops",
}

choices! {
    /// What becomes of light that is brighter than a display's white.
    #[derive(Default)]
    pub enum Highlights {
        /// What new light or enhancement brings close to white or beyond is compressed, in its order and hue; where a picture
        /// was too bright before, enhancement changes the white that is left of it.
        Compress = "compress" [default],
        /// It is cut off at white, channel by channel.
        Clip = "clip",
    }
}

/// Stops: a factor of 2^30 leaves nothing of any picture.
const STOPS: RangeInclusive<f32> = -30.0..=30.0;

params! {
    /// How linear light is brought to the range of a display. Files that hold linear numbers, EXR and HDR, are left as
    /// they are.
    pub struct DisplayParams in Display {
        /// Stops by which pictures are brighter, or darker; auto dims new light where it would burn, and leaves what is
        /// enhanced as bright as it is.
        exposure: Exposure = Exposure::Auto,
            flag: "--exposure", form: "EV|auto", valid: STOPS, useful: even(-8.0, 8.0);
        /// What becomes of light near the white of pictures, where it is new or brighter than it was: compress keeps its
        /// order and hue, clip cuts it off.
        highlights: Highlights = Highlights::Compress, flag: "--highlights", form: "HOW";
    }
}
