//! Levels that a drawing is fitted to: from the picture itself, or chosen once for a whole sequence.

use crate::params::Param;
use crate::params::table::Kind;
use crate::params::value::{Value, finite};
use serde::Serialize;

/// The levels that a drawing is fitted to: `COUNT` numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase", bound = "[f32; COUNT]: Serialize")]
pub enum Levels<const COUNT: usize> {
    /// Levels of the picture itself.
    Auto,
    /// Given levels.
    Given([f32; COUNT]),
}

/// Levels of shape-showing tones: median luminance; centre and spread of the picture's brightness in stops about it,
/// and the same for the key light; then brightness, in spreads, at the percentiles 0, 2, 5, 10, 20 and so on to 80, 95
/// and 100 of pixels that show form.
pub type ToneLevels = Levels<18>;

/// Levels for widths of interior lines: the strength, in radians of normal turn over the picture, from which lines have
/// full weight, and the natural logarithms of the nearest and farthest depth.
pub type LineLevels = Levels<3>;

impl<const COUNT: usize> Levels<COUNT> {
    /// Number of levels.
    pub const COUNT: usize = COUNT;
}

impl<const COUNT: usize> Value for Levels<COUNT> {
    const KIND: Kind = Kind::Text;

    fn parse(text: &str, _: &Param) -> Result<Self, String> {
        if text == AUTO {
            return Ok(Self::Auto);
        }
        let levels: Option<Vec<f32>> = text.split(',').map(finite).collect();
        let levels = levels.and_then(|levels| levels.try_into().ok());
        let expected = || format!("expected auto or {COUNT} numbers with commas between");
        levels.map(Self::Given).ok_or_else(expected)
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(match self {
            Self::Auto => AUTO.into(),
            Self::Given(levels) => levels.map(|level| level.to_string()).join(","),
        })
    }
}

/// Word for levels fitted to the picture.
const AUTO: &str = "auto";
