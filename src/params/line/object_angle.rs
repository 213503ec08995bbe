//! Stroke directions of single objects.

use super::Fallback;
use crate::params::range::ANGLES_DEG;
use std::str::FromStr;

/// Stroke direction where curvature gives none, for the objects that match a name.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectAngle {
    /// The object's name in Cryptomatte, with `*` and `?` for any letters, or its number in an index pass.
    pub name: String,
    /// The direction of strokes.
    pub fallback: Fallback,
}

impl FromStr for ObjectAngle {
    type Err = String;

    /// Reads `NAME=DEG` or `NAME=surface`, split at the last `=`: names may contain others.
    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected NAME=DEG or NAME=surface, as in Floor=20";
        let parts = text.rsplit_once('=');
        let (name, angle) = parts.filter(|(name, _)| !name.is_empty()).ok_or(EXPECTED)?;
        if name.starts_with('!') {
            return Err("names the objects it is for: it takes no !NAME".into());
        }
        let degrees = angle.parse().ok().filter(|deg| ANGLES_DEG.contains(deg));
        let fallback = match angle {
            "surface" => Fallback::Surface,
            _ => Fallback::Angle(degrees.ok_or(EXPECTED)?),
        };
        let name = name.into();
        Ok(Self { name, fallback })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_follows_the_last_equals_sign() {
        let read = |text: &str| text.parse::<ObjectAngle>();
        let angle = |name: &str, fallback| {
            Ok(ObjectAngle {
                name: name.into(),
                fallback,
            })
        };
        assert_eq!(read("Floor=20"), angle("Floor", Fallback::Angle(20.0)));
        assert_eq!(read("a=b=-30.5"), angle("a=b", Fallback::Angle(-30.5)));
        assert_eq!(read("B*k=surface"), angle("B*k", Fallback::Surface));
        for wrong in [
            "",
            "Floor",
            "=20",
            "Floor=",
            "Floor=up",
            "Floor=NaN",
            "!Floor=20",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
