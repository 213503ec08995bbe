//! Compression of the pixels of a written part.

use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// The names of all compressions that are read, by their numbers in files.
pub(super) const NAMES: [&str; 10] = [
    "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab",
];

/// Compression of the pixels of a part when it is written.
///
/// All but the last two are lossless. `Default` is ZIP, which every program reads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum OutputCompression {
    /// Uncompressed.
    None = 0,
    /// Runs of equal bytes: small only where the picture is flat.
    Rle,
    /// ZIP, row by row: rows can be read alone.
    Zips,
    /// ZIP, 16 rows at a time.
    #[default]
    Zip,
    /// Wavelets, 32 rows at a time: smallest for grainy pictures.
    Piz,
    /// DWA, 32 rows at a time: loses invisible detail, in colours only. It stores colours of any type as half floats:
    /// values beyond 32768 are clamped, NaN becomes 0.
    Dwaa = 8,
    /// DWA, 256 rows at a time.
    Dwab,
}

impl OutputCompression {
    /// All compressions.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::Rle,
        Self::Zips,
        Self::Zip,
        Self::Piz,
        Self::Dwaa,
        Self::Dwab,
    ];

    /// The name, as files and the command line have it.
    pub fn name(self) -> &'static str {
        NAMES[usize::from(self.code())]
    }

    /// Whether some samples change.
    pub fn is_lossy(self) -> bool {
        matches!(self, OutputCompression::Dwaa | OutputCompression::Dwab)
    }

    /// The number in the file.
    pub(super) fn code(self) -> u8 {
        self as u8
    }

    /// Refuses to lose precision of channels that are not colours but that DWA treats as such by the last token of
    /// their name, in a layer without red, green or blue.
    pub(super) fn check_channels(self, names: &[&str]) -> Result<()> {
        let is_color = |name: &str| {
            let layer = name.strip_suffix(last_token(name)).unwrap_or_default();
            let component = |c: &str| names.contains(&format!("{layer}{c}").as_str());
            ["R", "G", "B"].contains(&last_token(name))
                && ["R", "G", "B"].into_iter().all(component)
        };
        let spoiled = names.iter().find(|n| dwa_spoils(n) && !is_color(n));
        match spoiled.filter(|_| self.is_lossy()) {
            Some(name) => Err(Error::BadParameter {
                name: "--compression",
                found: format!("{self} would lose precision of the channel {name:?}"),
                remedy: format!("use a lossless one, such as {}", Self::default()),
            }),
            None => Ok(()),
        }
    }
}

fn last_token(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

/// Whether DWA treats the floating-point channel `name` as colour, with loss.
pub(super) fn dwa_spoils(name: &str) -> bool {
    ["R", "G", "B", "Y", "RY", "BY"].contains(&last_token(name))
}

impl fmt::Display for OutputCompression {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for OutputCompression {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let found = Self::ALL.into_iter().find(|c| c.name() == name);
        found.ok_or_else(|| Error::BadParameter {
            name: "--compression",
            found: format!("is {name:?}"),
            remedy: format!("use one of {}", Self::ALL.map(Self::name).join(", ")),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for compression in OutputCompression::ALL {
            assert_eq!(
                compression
                    .to_string()
                    .parse::<OutputCompression>()
                    .unwrap(),
                compression
            );
        }
        let error = "lzw".parse::<OutputCompression>().unwrap_err().to_string();
        assert!(
            error.contains("none, rle, zips, zip, piz, dwaa, dwab"),
            "{error}"
        );
    }

    #[test]
    fn only_colours_may_lose_precision() {
        let dwaa = |names: &[&str]| OutputCompression::Dwaa.check_channels(names).is_ok();
        assert!(dwaa(&["R", "G", "B", "A"]));
        assert!(dwaa(&["relievo.R", "relievo.G", "relievo.B", "Z"]));
        // In a vector X, Y, Z it would spoil only Y.
        assert!(!dwaa(&["normal.X", "normal.Y", "normal.Z"]));
        assert!(!dwaa(&["Y"]));
        assert!(!dwaa(&["R", "G", "B", "flow.R", "flow.G"]));
        let zip = OutputCompression::Zip.check_channels(&["normal.Y"]);
        assert!(zip.is_ok());
    }
}
