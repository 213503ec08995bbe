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

    /// The composition of both flips.
    pub fn and(self, other: Self) -> Self {
        Self {
            x: self.x ^ other.x,
            y: self.y ^ other.y,
            z: self.z ^ other.z,
        }
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
        if text == "none" {
            return Ok(flip);
        }
        for axis in text.chars().filter(|&c| c != ',') {
            match axis.to_ascii_lowercase() {
                'x' => flip.x = true,
                'y' => flip.y = true,
                'z' => flip.z = true,
                _ => return Err("expected axes out of x, y and z, as in y or xz".into()),
            }
        }
        Ok(flip)
    }
}
