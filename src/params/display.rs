//! The parameters of the mapping from linear light to a display.

use super::Group;
use super::table::even;
use std::ops::RangeInclusive;

number_or_word! {
    /// Exposure compensation in stops.
    pub enum Exposure {
        /// New light is darkened where it would clip, and as bright as the picture whose colours the surface takes; an
        /// enhanced picture keeps its exposure.
        Auto = "auto",
        /// A given number of stops.
        Stops(f32),
    }
    whole: false,
    numbers: |number| number.is_finite(),
    expected: "expected auto or a number of stops",
}

choices! {
    /// Treatment of light brighter than the display's white.
    #[derive(Default)]
    pub enum Highlights {
        /// Highlights near or above white that are new, or brightened by enhancement, are compressed; their order and
        /// hue stay. Where the input already exceeds white, enhancement works on the range that remains.
        Compress = "compress" [default],
        /// Values are clipped at white, channel by channel.
        Clip = "clip",
    }
}

choices! {
    /// Mapping of a picture's linear light to the numbers of a file for a display.
    #[derive(Default)]
    pub enum DisplayView {
        /// Exposure, compressed highlights, the sRGB curve.
        Standard = "standard" [default],
        /// Another word for standard.
        Srgb = "srgb",
        /// Exposure, AgX, the sRGB curve.
        Agx = "agx",
        /// Exposure, Filmic, the sRGB curve.
        Filmic = "filmic",
        /// Nothing: linear numbers from 0 to 1.
        None = "none",
    }
}

/// Stops: a factor of 2^30 makes any picture all white, 2^-30 all black.
const STOPS: RangeInclusive<f32> = -30.0..=30.0;

params! {
    /// Mapping of linear light to the range of a display. Files that hold linear values, EXR and HDR, are not mapped.
    pub struct DisplayParams in Display {
        /// Exposure compensation in stops; auto darkens new light where it would clip, keeps the brightness of a picture
        /// whose colours the surface takes, and leaves the exposure of an enhanced picture unchanged.
        exposure: Exposure = Exposure::Auto,
            flag: "--exposure", common: true, form: "EV|auto", valid: STOPS, useful: even(-8.0, 8.0);
        /// Treatment of highlights near white that are new or brighter than before: compress keeps their order and hue,
        /// clip cuts them off.
        highlights: Highlights = Highlights::Compress, flag: "--highlights", form: "HOW";
        /// Pictures: mapping from scene-linear to display. standard, also called srgb, is the sRGB curve; agx and
        /// filmic are Blender's; none writes the linear numbers from 0 to 1.
        view_transform: DisplayView = DisplayView::Standard,
            flag: "--view-transform", form: "CURVE", group: Group::Print;
    }
}
