//! Colour spaces: primaries and encoding of pictures, and their conversion for a display.
//!
//! Work is done in the linear light of the picture's own primaries, and layers are written in them. Only pictures for a
//! display are converted to Rec. 709. Data (normals, depth, positions) have no colour and are never converted.

use glam::{DMat3, DVec3};

/// x and y of red, green and blue primaries and of white.
pub(crate) type Chromaticities = [f32; 8];

/// Chromaticities of ITU-R BT.709 and sRGB.
pub(crate) const REC709: Chromaticities = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];
/// AP0, of ACES2065-1 (SMPTE ST 2065-1).
pub(crate) const AP0: Chromaticities = [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767];

/// The primaries of a picture, if given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorSpace {
    /// Linear light of Rec. 709 primaries.
    Linear,
    /// The same primaries, encoded by the sRGB curve.
    Srgb,
    /// Linear light of AP1 primaries.
    AcesCg,
    /// Linear light of AP0 primaries.
    Aces,
}

impl ColorSpace {
    /// AP1, of ACEScg (S-2014-004).
    pub const AP1: Chromaticities = [0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767];

    /// All spaces, with their names for `--colorspace`.
    pub const ALL: [(Self, &'static str); 4] = [
        (Self::Linear, "linear"),
        (Self::Srgb, "srgb"),
        (Self::AcesCg, "acescg"),
        (Self::Aces, "aces2065-1"),
    ];

    /// Its primaries.
    pub fn chromaticities(self) -> Chromaticities {
        match self {
            Self::Linear | Self::Srgb => REC709,
            Self::AcesCg => Self::AP1,
            Self::Aces => AP0,
        }
    }

    /// The space named by a `colorInteropID`, if it is one of these.
    pub fn of_interop_id(id: &str) -> Option<Self> {
        match id {
            "lin_rec709_scene" => Some(Self::Linear),
            "srgb_rec709_scene" => Some(Self::Srgb),
            "lin_ap1_scene" => Some(Self::AcesCg),
            "lin_ap0_scene" => Some(Self::Aces),
            _ => None,
        }
    }
}

/// Largest absolute chromaticity of real and imaginary primaries; cameras' own reach 2.
const FARTHEST: f32 = 10.0;

/// Largest entry of a plausible matrix between colours: those of real spaces stay below 10.
const LARGEST_ENTRY: f64 = 1e4;

/// Matrix from linear colours with these chromaticities to CIE XYZ with white at luminance 1. `None` for collinear
/// primaries or unusable numbers.
pub(crate) fn xyz_from(chromaticities: Chromaticities) -> Option<DMat3> {
    let [rx, ry, gx, gy, bx, by, wx, wy] = chromaticities.map(f64::from);
    let xyz = |x: f64, y: f64| DVec3::new(x, y, 1.0 - x - y);
    let primaries = DMat3::from_cols(xyz(rx, ry), xyz(gx, gy), xyz(bx, by));
    let in_range = chromaticities.iter().all(|c| c.abs() <= FARTHEST);
    let usable = in_range && wy > 1e-6 && primaries.determinant().abs() > 1e-6;
    // Scales of the primaries that add up to white with luminance 1.
    let scales = usable.then(|| primaries.inverse() * (xyz(wx, wy) / wy))?;
    let matrix = primaries * DMat3::from_diagonal(scales);
    is_moderate(matrix).then_some(matrix)
}

/// Whether all entries are within the reach of single precision: nearly collinear primaries exceed it.
pub(crate) fn is_moderate(matrix: DMat3) -> bool {
    matrix
        .to_cols_array()
        .iter()
        .all(|entry| entry.abs() <= LARGEST_ENTRY)
}

/// Weights of linear red, green and blue in luminance: the Y row of [`xyz_from`].
pub(crate) fn luminance_weights(chromaticities: Chromaticities) -> Option<[f32; 3]> {
    let row = xyz_from(chromaticities)?.row(1);
    Some(row.to_array().map(|weight| weight as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_rec709_are_the_standard_ones() {
        let weights = luminance_weights(REC709).unwrap();
        for (weight, expected) in weights.iter().zip([0.2126, 0.7152, 0.0722]) {
            assert!((weight - expected).abs() < 1e-4, "{weights:?}");
        }
    }

    #[test]
    fn degenerate_primaries_have_no_weights() {
        assert_eq!(luminance_weights([0.3; 8]), None);
        assert_eq!(luminance_weights([f32::NAN; 8]), None);
        let black = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.0];
        assert_eq!(luminance_weights(black), None);
    }
}
