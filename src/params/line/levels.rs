//! Numbers that a drawing is fit to: of the picture itself, or chosen once for several that go together.

use crate::params::Param;
use crate::params::table::Kind;
use crate::params::value::{Value, finite};
use crate::quantile::quantile;
use serde::Serialize;

/// The levels that a drawing is fit to: `N` numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase", bound = "[f32; COUNT]: Serialize")]
pub enum Levels<const COUNT: usize> {
    /// The picture.
    Auto,
    /// These.
    Given([f32; COUNT]),
}

/// What a tone that shows the shape is fit to: the median luminance; middle and spread of the picture's brightness in stops
/// about it, and of that in the key light; and the brightness, in spreads, that 0, 2, 5, 10, 20, 30 and so on to 80, 95 and
/// 100 % of what shows form are below.
pub type ToneLevels = Levels<18>;

/// What widths of lines inside surfaces are fit to: the strength, in radians that the normal turns over the picture, from
/// which on lines are as heavy as they become, and the natural logarithms of the depth of the nearest and of the farthest.
pub type LineLevels = Levels<3>;

impl<const COUNT: usize> Levels<COUNT> {
    /// How many there are.
    pub const COUNT: usize = COUNT;

    /// Of each level the median of those of several pictures.
    pub(crate) fn median(each: impl Iterator<Item = [f32; COUNT]>) -> Option<[f32; COUNT]> {
        let each: Vec<_> = each.collect();
        let middle = |i: usize| {
            let mut levels: Vec<f32> = each.iter().map(|levels| levels[i]).collect();
            quantile(&mut levels, 0.5, f32::total_cmp).unwrap_or_default()
        };
        (!each.is_empty()).then(|| std::array::from_fn(middle))
    }
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

/// The word for levels that fit the picture.
const AUTO: &str = "auto";
