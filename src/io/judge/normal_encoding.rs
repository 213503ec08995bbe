//! Checks that vectors are normals, and tells signed from unsigned components.

use crate::error::{Error, Result};
use crate::frame::normals::MIN_LENGTH;
use crate::frame::sampling::one_in;
use crate::frame::{Plane, Vector3Planes};
use crate::io::inputs::NormalEncoding;
use crate::io::photo::{CodeMeaning, StoredPhoto};
use crate::kernel::quantile::quantile;
use glam::Vec3;
use std::path::Path;

/// Vectors that are looked at, about.
const WANTED: usize = 20_000;

fn sample(stored: &Vector3Planes) -> impl Iterator<Item = Vec3> {
    places(stored).map(|(x, y)| stored.at(x, y).as_vec3())
}

fn places(stored: &Vector3Planes) -> impl Iterator<Item = (usize, usize)> {
    let (width, height) = (stored.x.width(), stored.x.height());
    let area = (width * height) as f64 / WANTED as f64;
    one_in(area, 0..width, 0..height)
}

/// Distinguishes signed from unsigned components: unsigned ones hold no negatives, and have unit length only once decoded.
pub(crate) fn judge_encoding(stored: &Vector3Planes) -> NormalEncoding {
    let (mut decoded, mut as_stored) = (0_usize, 0_usize);
    for n in sample(stored).filter(|n| n.length() > MIN_LENGTH) {
        if n.min_element() < -0.01 {
            return NormalEncoding::Signed;
        }
        let near_unit = |n: Vec3| (n.length() - 1.0).abs() < 0.05;
        decoded += usize::from(near_unit(2.0 * n - Vec3::ONE));
        as_stored += usize::from(near_unit(n));
    }
    match decoded > as_stored {
        true => NormalEncoding::Unsigned,
        false => NormalEncoding::Signed,
    }
}

/// A decoded vector is taken for a normal if its length is this near to 1: mipmaps and JPEG move it by less.
pub(crate) const NEAR_UNIT: f32 = 0.15;

/// Smallest share of such vectors, among those written, in a normal map. On all normal maps tried it was 0.94 or more,
/// on photographs and other pictures below 0.4.
const FEWEST_UNIT: f64 = 0.5;

/// The vectors of a picture of integers, decoded, that are written where all of the `alphas` cover.
fn written(stored: &Vector3Planes, alphas: [Option<&Plane>; 2]) -> Vec<Vec3> {
    let is_written = |n: &Vec3| *n != Vec3::ZERO && *n != Vec3::ONE;
    let covers = |x: usize, y: usize| alphas.iter().flatten().all(|alpha| alpha.at(x, y) > 0.5);
    let covered = places(stored).filter(|&(x, y)| covers(x, y));
    let decoded = covered
        .map(|(x, y)| stored.at(x, y).as_vec3())
        .filter(is_written)
        .map(|n| 2.0 * n - Vec3::ONE);
    decoded.filter(|n| n.length() > MIN_LENGTH).collect()
}

/// The share of `vectors` for which this holds; `None` without any.
fn share_of(vectors: &[Vec3], holds: impl Fn(Vec3) -> bool) -> Option<f64> {
    let count = vectors.iter().filter(|v| holds(**v)).count();
    (!vectors.is_empty()).then(|| count as f64 / vectors.len() as f64)
}

/// The share of `vectors` that are about so long.
fn share_of_length(vectors: &[Vec3], length: f32) -> Option<f64> {
    share_of(vectors, |v| {
        (v.length() - length).abs() < NEAR_UNIT * length
    })
}

/// The same share in a picture that is taken for a normal map though nobody says so.
const FEWEST_UNIT_UNNAMED: f64 = 0.9;

/// Rows that are looked at for it.
const ROWS: usize = 256;

/// Whether a photo is a normal map, by the rows in its middle. One that cannot be decoded is none.
pub(crate) fn holds_normals(photo: &StoredPhoto) -> bool {
    let header = &photo.header;
    if header.color_channels() != 3 {
        return false;
    }
    let rows = ROWS.min(header.height);
    let first = (header.height - rows) / 2;
    let planes = photo.planes(first..first + rows, CodeMeaning::Stored);
    planes.is_ok_and(|mut planes| {
        planes.truncate(3);
        let stored = Vector3Planes::of(planes);
        // Pictures of light hold no negatives.
        let is_signed = || sample(&stored).any(|n| n.min_element() < -0.01);
        let vectors = match header.is_float && is_signed() {
            true => sample(&stored)
                .filter(|n| n.length() > MIN_LENGTH)
                .collect(),
            false => written(&stored, [None; 2]),
        };
        let share = share_of_length(&vectors, 1.0);
        share.is_some_and(|share| share >= FEWEST_UNIT_UNNAMED)
    })
}

/// Vectors of one length that need not be 1: the least length, the share that has it, and the share that faces the viewer.
const SHORT: (f32, f64, f64) = (0.3, 0.9, 0.98);

/// Refuses a picture of integers that is no normal map, looked at where the `alphas` cover it; the length of the vectors of
/// one that a user has named, where it is not 1.
///
/// # Errors
/// [`Error::Unsupported`] with the share of its vectors that could be normals.
pub(crate) fn refuse_pictures(
    stored: &Vector3Planes,
    alphas: [Option<&Plane>; 2],
    is_named: bool,
    path: &Path,
) -> Result<Option<f32>> {
    let vectors = written(stored, alphas);
    let share = share_of_length(&vectors, 1.0);
    let Some(share) = share.filter(|share| *share < FEWEST_UNIT) else {
        return Ok(None);
    };
    let (least, fewest, facing) = SHORT;
    let mut lengths: Vec<f32> = vectors.iter().map(|v| v.length()).collect();
    let median = quantile(&mut lengths, 0.5, f32::total_cmp).unwrap_or_default();
    let is_even = share_of_length(&vectors, median) >= Some(fewest);
    let faces = share_of(&vectors, |v| v.z > 0.0) >= Some(facing);
    if is_named && median >= least && is_even && faces {
        return Ok(Some(median));
    }
    let or = match is_named {
        true => "name another map",
        false => "give the map of the picture with --normal",
    };
    let remedy = format!("{or}, or --normal-encoding unsigned if it is one");
    Err(no_normals(share, stored, path, remedy))
}

/// Refuses numbers that are light or heights: none is negative, or all components are equal, and few vectors are of unit
/// length, as stored or decoded.
///
/// # Errors
/// [`Error::Unsupported`] with the share of its vectors that could be normals.
pub(crate) fn refuse_light(stored: &Vector3Planes, path: &Path) -> Result<()> {
    let vectors: Vec<_> = sample(stored)
        .filter(|n| n.is_finite() && *n != Vec3::ZERO)
        .collect();
    let is_unit = |n: Vec3| (n.length() - 1.0).abs() < NEAR_UNIT;
    let share = share_of(&vectors, |n| is_unit(n) || is_unit(2.0 * n - Vec3::ONE));
    let holds_negatives = vectors.iter().any(|n| n.min_element() < 0.0);
    match share {
        Some(share) if share < FEWEST_UNIT && (!holds_negatives || is_grey(stored)) => {
            let remedy = "name another layer, or --normal-encoding signed or unsigned if it is one";
            Err(no_normals(share, stored, path, remedy.into()))
        }
        _ => Ok(()),
    }
}

/// Whether each pixel holds one number, as of heights.
fn is_grey(stored: &Vector3Planes) -> bool {
    sample(stored).all(|n| n.x == n.y && n.y == n.z)
}

fn no_normals(share: f64, stored: &Vector3Planes, path: &Path, remedy: String) -> Error {
    Error::Unsupported {
        path: path.to_path_buf(),
        found: format!(
            "is no normal map: {:.0} % of its pixels hold a vector of unit length",
            100.0 * share
        ),
        remedy: match is_grey(stored) {
            true => "a map of heights is named with --height".into(),
            false => remedy,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(normals: &[Vec3]) -> Vector3Planes {
        Vector3Planes::from_fn(normals.len(), 1, |x, _| normals[x].as_dvec3())
    }

    fn slopes() -> Vec<Vec3> {
        (-4..=4)
            .map(|i| Vec3::new(0.2 * i as f32, 0.1, 1.0).normalize())
            .collect()
    }

    #[test]
    fn encodings_are_told_apart() {
        assert_eq!(judge_encoding(&planes(&slopes())), NormalEncoding::Signed);
        let encoded: Vec<_> = slopes()
            .iter()
            .map(|n| 0.5 * *n + Vec3::splat(0.5))
            .collect();
        assert_eq!(judge_encoding(&planes(&encoded)), NormalEncoding::Unsigned);
        // A wall facing the viewer: (0, 0, 1) is unit as it is; (0.5, 0.5, 1) only once decoded.
        assert_eq!(
            judge_encoding(&planes(&[Vec3::Z; 4])),
            NormalEncoding::Signed
        );
        let wall = [Vec3::new(0.5, 0.5, 1.0); 4];
        assert_eq!(judge_encoding(&planes(&wall)), NormalEncoding::Unsigned);
    }

    #[test]
    fn a_photograph_is_no_normal_map() {
        let path = Path::new("map.png");
        let encoded: Vec<_> = slopes()
            .iter()
            .map(|n| 0.5 * *n + Vec3::splat(0.5))
            .collect();
        let refuse = |normals: &[Vec3], is_named| {
            refuse_pictures(&planes(normals), [None; 2], is_named, path)
        };
        assert_eq!(refuse(&encoded, true).unwrap(), None);
        // Half of it was never written, or is white.
        let blank = [Vec3::ZERO, Vec3::ONE].repeat(encoded.len());
        refuse(&[&encoded[..], &blank].concat(), false).unwrap();
        refuse(&blank, false).unwrap();
        // Stone of the colour (0.56, 0.45, 0.33): 2c - 1 is (0.12, -0.1, -0.34), 0.37 long.
        let stone: Vec<_> = (0..9)
            .map(|i| (0.9 + 0.02 * i as f32) * Vec3::new(0.56, 0.45, 0.33))
            .collect();
        let said = refuse(&stone, true).unwrap_err().to_string();
        assert!(
            said.contains("map.png") && said.contains("is no normal map: 0 %"),
            "{said}"
        );
    }
    /// Vectors of length 0.65 are 0.65 long in the median too. Half of the pixels are stone, which alpha leaves out.
    #[test]
    fn named_vectors_of_one_length_are_normals_where_alpha_covers() {
        let path = Path::new("map.png");
        let short = slopes().into_iter().map(|n| 0.325 * n + Vec3::splat(0.5));
        let half: Vec<_> = short
            .flat_map(|n| [n, Vec3::new(0.56, 0.45, 0.33)])
            .collect();
        let alpha = Plane::from_fn(half.len(), 1, |x, _| (1 - x % 2) as f32);
        let judge =
            |alpha, is_named| refuse_pictures(&planes(&half), [None, alpha], is_named, path);
        let length = judge(Some(&alpha), true).unwrap().unwrap();
        assert!((length - 0.65).abs() < 1e-6, "{length}");
        judge(Some(&alpha), false).unwrap_err();
        judge(None, true).unwrap_err();
    }
}
