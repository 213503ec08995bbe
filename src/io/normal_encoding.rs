//! Checks that vectors are normals, and tells signed from unsigned components.

use super::inputs::NormalEncoding;
use super::photo::{Meaning, StoredPhoto};
use crate::error::{Error, Result};
use crate::frame::Vector3Planes;
use crate::frame::normals::MIN_LENGTH;
use crate::frame::sampling::one_in;
use glam::Vec3;
use std::path::Path;

/// Vectors that are looked at, about.
const WANTED: usize = 20_000;

fn sample(stored: &Vector3Planes) -> impl Iterator<Item = Vec3> {
    let (width, height) = (stored.x.width(), stored.x.height());
    let area = (width * height) as f64 / WANTED as f64;
    one_in(area, 0..width, 0..height).map(|(x, y)| stored.at(x, y).as_vec3())
}

/// Distinguishes signed from unsigned components: unsigned ones hold no negatives, and have unit length only once decoded.
pub(super) fn judge_encoding(stored: &Vector3Planes) -> NormalEncoding {
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
const NEAR_UNIT: f32 = 0.15;

/// Smallest share of such vectors, among those written, in a normal map. On all normal maps tried it was 0.94 or more,
/// on photographs and other pictures below 0.4.
const FEWEST_UNIT: f64 = 0.5;

/// The share of vectors of unit length in a picture of integers, once decoded, among those written; `None` of a blank
/// one.
fn share_of_unit(stored: &Vector3Planes) -> Option<f64> {
    let is_written = |n: &Vec3| *n != Vec3::ZERO && *n != Vec3::ONE;
    let decoded = sample(stored)
        .filter(is_written)
        .map(|n| 2.0 * n - Vec3::ONE);
    let (mut count, mut unit) = (0_usize, 0_usize);
    for length in decoded
        .map(Vec3::length)
        .filter(|length| *length > MIN_LENGTH)
    {
        count += 1;
        unit += usize::from((length - 1.0).abs() < NEAR_UNIT);
    }
    (count > 0).then(|| unit as f64 / count as f64)
}

/// The same share in a picture that is taken for a normal map though nobody says so.
const FEWEST_UNIT_UNNAMED: f64 = 0.9;

/// Rows that are looked at for it.
const ROWS: usize = 256;

/// Whether a photo is a normal map, by the rows in its middle. One that cannot be decoded is none.
pub(super) fn holds_normals(photo: &StoredPhoto) -> bool {
    let header = &photo.header;
    if header.is_float || header.color_channels() != 3 {
        return false;
    }
    let rows = ROWS.min(header.height);
    let first = (header.height - rows) / 2;
    let planes = photo.planes(first..first + rows, Meaning::Stored);
    planes.is_ok_and(|mut planes| {
        planes.truncate(3);
        let share = share_of_unit(&Vector3Planes::of(planes));
        share.is_some_and(|share| share >= FEWEST_UNIT_UNNAMED)
    })
}

/// Refuses a picture of integers that is no normal map.
///
/// # Errors
/// [`Error::Unsupported`] with the share of its vectors that could be normals.
pub(super) fn refuse_pictures(stored: &Vector3Planes, path: &Path) -> Result<()> {
    let share = share_of_unit(stored);
    if share.is_none_or(|share| share >= FEWEST_UNIT) {
        return Ok(());
    }
    let share = share.unwrap_or_default();
    Err(Error::Unsupported {
        path: path.to_path_buf(),
        found: format!(
            "is no normal map: {:.0} % of its pixels hold a vector of unit length",
            100.0 * share
        ),
        remedy:
            "give the map of the picture with --normal, or --normal-encoding unsigned if it is one"
                .into(),
    })
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
        refuse_pictures(&planes(&encoded), path).unwrap();
        // Half of it was never written, or is white.
        let blank = [Vec3::ZERO, Vec3::ONE].repeat(encoded.len());
        refuse_pictures(&planes(&[&encoded[..], &blank].concat()), path).unwrap();
        refuse_pictures(&planes(&blank), path).unwrap();
        // Stone of the colour (0.56, 0.45, 0.33): 2c - 1 is (0.12, -0.1, -0.34), 0.37 long.
        let stone: Vec<_> = (0..9)
            .map(|i| (0.9 + 0.02 * i as f32) * Vec3::new(0.56, 0.45, 0.33))
            .collect();
        let said = refuse_pictures(&planes(&stone), path)
            .unwrap_err()
            .to_string();
        assert!(
            said.contains("map.png") && said.contains("is no normal map: 0 %"),
            "{said}"
        );
    }
}
