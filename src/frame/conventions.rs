//! How normals and depth are stored in files and in memory, before decoding.

use super::DepthKind;
use glam::DVec3;

/// Encoding of a normal's components.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NormalEncoding {
    /// Unchanged, -1..1.
    Signed,
    /// As (n + 1) / 2, 0..1.
    Unsigned,
    /// x and y alone, unsigned in integers and else signed; z follows from the unit length, toward the viewer.
    Xy,
    /// The same with x in alpha and y in green, as in DXT5nm.
    Ag,
    /// Octahedral coordinates in the first two components, unsigned in integers and else signed. Cigolle et al., "A Survey
    /// of Efficient Representations for Independent Unit Vectors", JCGT 3(2), 2014.
    Oct,
}

/// Axes to negate, in the space the normals were stored in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flip {
    /// Negate x.
    pub x: bool,
    /// Negate y: DirectX normal maps store green downward.
    pub y: bool,
    /// Negate z.
    pub z: bool,
}

impl Flip {
    /// No axis.
    pub const NONE: Self = Self {
        x: false,
        y: false,
        z: false,
    };

    /// A vector with its axes negated.
    pub(crate) fn of(self, vector: DVec3) -> DVec3 {
        let signs = [self.x, self.y, self.z].map(|flipped| if flipped { -1.0 } else { 1.0 });
        vector * DVec3::from_array(signs)
    }

    /// Whose axes are reversed, by name, in view space with x right, y up and z toward the viewer.
    const PRESETS: [(&str, &str); 7] = [
        ("none", ""),
        ("opengl", ""),
        ("directx", "y"),
        ("opencv", "yz"),
        ("stablenormal", "x"),
        ("dsine", "x"),
        ("bae", "x"),
    ];

    /// The composition of both flips.
    pub fn and(self, other: Self) -> Self {
        Self {
            x: self.x ^ other.x,
            y: self.y ^ other.y,
            z: self.z ^ other.z,
        }
    }
}

impl NormalEncoding {
    /// Whether z is not stored.
    pub(crate) fn is_pair(self) -> bool {
        matches!(self, Self::Xy | Self::Ag | Self::Oct)
    }
}

impl std::fmt::Display for Flip {
    /// The axes, as in `xz`, or `none`, in the form of `--normal-flip`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let axes = [(self.x, "x"), (self.y, "y"), (self.z, "z")];
        let turned: String = axes.iter().filter(|a| a.0).map(|a| a.1).collect();
        f.write_str(if turned.is_empty() { "none" } else { &turned })
    }
}

/// The quantity that a depth layer stores.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StoredDepth {
    /// Distance along the view axis.
    Planar,
    /// Distance along the sight line, from the eye.
    Ray,
    /// One over the distance along the view axis; 0 where nothing was seen.
    Inverse,
    /// A value that increases with distance, or a distance too coarse for positions; 0 where nothing was seen.
    Relative,
    /// Distance mapped to 0..1, black near and white far, possibly clamped. It does not mark where nothing was seen.
    WhiteFar,
    /// The same reversed, white near and black far.
    NormalizedNearIsOne,
    /// Height toward the viewer, in pixels, seen along parallel lines: 0 and less are heights too.
    Height,
}

impl StoredDepth {
    /// All kinds, with their names in `--depth-kind`.
    pub const ALL: [(Self, &'static str); 7] = [
        (Self::Planar, "z"),
        (Self::Ray, "distance"),
        (Self::Inverse, "inverse"),
        (Self::Relative, "relative"),
        (Self::WhiteFar, "white-far"),
        (Self::NormalizedNearIsOne, "white-near"),
        (Self::Height, "height"),
    ];

    /// Its name in `--depth-kind`.
    pub fn name(self) -> &'static str {
        let named = Self::ALL.iter().find(|(kind, _)| *kind == self);
        named.expect("every kind has a name").1
    }

    /// The kind of a frame's depth after decoding.
    pub fn kind(self) -> DepthKind {
        match self {
            Self::Planar | Self::Inverse | Self::Height => DepthKind::Planar,
            Self::Ray => DepthKind::Ray,
            Self::Relative | Self::WhiteFar | Self::NormalizedNearIsOne => DepthKind::Relative,
        }
    }

    /// The kind for samples that may be half floats, whose inverse is too coarse for a distance.
    pub(crate) fn kind_of(self, is_half: bool) -> DepthKind {
        match self {
            Self::Inverse if is_half => DepthKind::Relative,
            _ => self.kind(),
        }
    }

    /// Whether the layer marks where nothing was seen.
    pub(crate) fn shows_coverage(self) -> bool {
        !matches!(
            self,
            Self::WhiteFar | Self::NormalizedNearIsOne | Self::Height
        )
    }
}

impl std::fmt::Display for StoredDepth {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Planar | Self::Ray | Self::Relative => self.kind().fmt(f),
            Self::Inverse => f.write_str("one over the depth along the view axis"),
            Self::WhiteFar => f.write_str("relative depth, white far"),
            Self::NormalizedNearIsOne => f.write_str("relative depth, white near"),
            Self::Height => f.write_str("height toward the viewer"),
        }
    }
}

impl std::str::FromStr for Flip {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut flip = Self::default();
        let text = text.to_ascii_lowercase();
        let preset = Self::PRESETS.iter().find(|(name, _)| *name == text);
        let axes = preset.map_or(text.as_str(), |(_, axes)| axes);
        for axis in axes.chars().filter(|&c| c != ',') {
            match axis {
                'x' => flip.x = true,
                'y' => flip.y = true,
                'z' => flip.z = true,
                _ => {
                    let names: Vec<_> = Self::PRESETS.iter().map(|(name, _)| *name).collect();
                    return Err(format!(
                        "expected axes out of x, y and z, as in y or xz, or one of {}",
                        names.join(", ")
                    ));
                }
            }
        }
        Ok(flip)
    }
}
