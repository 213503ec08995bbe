//! Colour spaces: primaries and encoding of pictures, and their conversion for a display.
//!
//! Work is done in the linear light of the picture's own primaries, and layers are written in them. Only pictures for a
//! display are converted to Rec. 709, by the matrix from the chromaticities, adapted to its white (Bradford). Data
//! (normals, depth, positions) have no colour and are never converted.

use crate::frame::ColorPlanes;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// x and y of red, green and blue primaries and of white.
pub(crate) type Chromaticities = [f32; 8];

/// Chromaticities of ITU-R BT.709 and sRGB.
pub(crate) const REC709: Chromaticities = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];
/// AP1, of ACEScg (S-2014-004).
pub const AP1: Chromaticities = [0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767];
/// AP0, of ACES2065-1 (SMPTE ST 2065-1).
pub(crate) const AP0: Chromaticities = [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767];

/// XYZ to the cone responses scaled by Bradford's adaptation.
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

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
            Self::AcesCg => AP1,
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
pub(super) fn xyz_from(chromaticities: Chromaticities) -> Option<DMat3> {
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
fn is_moderate(matrix: DMat3) -> bool {
    matrix
        .to_cols_array()
        .iter()
        .all(|entry| entry.abs() <= LARGEST_ENTRY)
}

/// Weights of linear red, green and blue in luminance: the Y row of [`xyz_from`].
pub(super) fn luminance_weights(chromaticities: Chromaticities) -> Option<[f32; 3]> {
    let row = xyz_from(chromaticities)?.row(1);
    Some(row.to_array().map(|weight| weight as f32))
}

/// Matrix from linear colours with these chromaticities to Rec. 709; `None` for Rec. 709 itself and unusable numbers.
pub(crate) fn rec709_from(chromaticities: Chromaticities) -> Option<DMat3> {
    let near = |(a, b): (f32, f32)| (a - b).abs() < 1e-4;
    if chromaticities.into_iter().zip(REC709).all(near) {
        return None;
    }
    let (from, to) = (xyz_from(chromaticities)?, xyz_from(REC709)?);
    let cones = |xyz_from: DMat3| BRADFORD * (xyz_from * DVec3::ONE);
    let adapted = DMat3::from_diagonal(cones(to) / cones(from));
    let matrix = to.inverse() * BRADFORD.inverse() * adapted * BRADFORD * from;
    is_moderate(matrix).then_some(matrix)
}

/// Colours transformed by a matrix.
pub(crate) fn converted(color: &ColorPlanes, matrix: DMat3) -> ColorPlanes {
    let matrix = matrix.as_mat3();
    let mut made = color.clone();
    let planes = [&mut made.r, &mut made.g, &mut made.b].map(|plane| plane.samples_mut());
    let [r, g, b] = planes;
    r.par_iter_mut().zip(g).zip(b).for_each(|((r, g), b)| {
        let turned = matrix * glam::Vec3::new(*r, *g, *b);
        (*r, *g, *b) = (turned.x, turned.y, turned.z);
    });
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

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
        // Impossible primaries, and a white that needs 1e5 times the primaries.
        for (index, value) in [(0, 1e30), (3, f32::INFINITY), (6, -1e20), (7, 2e-6)] {
            let mut bad = REC709;
            bad[index] = value;
            assert_eq!(rec709_from(bad), None, "{bad:?}");
        }
    }

    #[test]
    fn acescg_turns_to_rec709_as_published() {
        // The matrix from ACEScg to linear Rec. 709 with Bradford's adaptation that the ACES distribution lists.
        let expected = [
            [1.705_05, -0.621_79, -0.083_26],
            [-0.130_26, 1.140_80, -0.010_55],
            [-0.024_00, -0.128_97, 1.152_97],
        ];
        let matrix = rec709_from(AP1).unwrap();
        for (row, expected) in expected.into_iter().enumerate() {
            for (found, expected) in matrix.row(row).to_array().into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
            }
        }
        // White stays white.
        let one = Plane::filled(1, 1, 1.0);
        let white = ColorPlanes {
            r: one.clone(),
            g: one.clone(),
            b: one,
        };
        let white = converted(&white, matrix);
        assert!(
            [&white.r, &white.g, &white.b]
                .iter()
                .all(|p| (p.at(0, 0) - 1.0).abs() < 1e-5)
        );
        assert_eq!(rec709_from(REC709), None);
        assert_eq!(rec709_from([0.3; 8]), None);
    }
}
