//! Coverage: backgrounds and missing samples only affect the mask.

use super::depth::{HALF_INFINITY, is_distance, to_distances};
use super::normals::{MIN_LENGTH, normalise_row};
use super::plane::each_row_beside;
use super::repair::fill;
use super::{Mask, Plane, StoredDepth, Vector3Planes};
use glam::Vec3;
use rayon::prelude::*;

/// Samples looked at by a task.
const SAMPLES_PER_TASK: usize = 1 << 16;

/// Pixels where decoded normals have a direction, depth is a distance, and mask and alpha are above one half, as far as
/// these are given.
pub(crate) fn of_normals(
    normal: &Vector3Planes,
    depth: Option<&Plane>,
    alpha: Option<&Plane>,
    mask: Option<&Plane>,
) -> Mask {
    let (width, height) = (normal.x.width(), normal.x.height());
    Mask::new(Plane::of_rows(width, height, |y, row| {
        let normals = [&normal.x, &normal.y, &normal.z].map(|plane| plane.row(y));
        cover_row(row, y, normals, depth, [mask, alpha]);
    }))
}

/// The same for row `y`, whose normals these are; mask and alpha are `shares`.
fn cover_row(
    row: &mut [bool],
    y: usize,
    [nx, ny, nz]: [&[f32]; 3],
    depth: Option<&Plane>,
    shares: [Option<&Plane>; 2],
) {
    let normals = nx.iter().zip(ny).zip(nz);
    for (covered, ((&x, &y), &z)) in row.iter_mut().zip(normals) {
        *covered = has_direction(Vec3::new(x, y, z));
    }
    narrow(row, depth.map(|depth| depth.row(y)), is_distance);
    for shares in shares {
        narrow(row, shares.map(|shares| shares.row(y)), |share| share > 0.5);
    }
}

/// Leaves only those pixels of a row covered whose sample is as it must be.
fn narrow(row: &mut [bool], samples: Option<&[f32]>, holds: impl Fn(f32) -> bool) {
    let Some(samples) = samples else { return };
    for (covered, &sample) in row.iter_mut().zip(samples) {
        *covered &= holds(sample);
    }
}

/// Whether a normal has a direction.
#[inline(always)]
pub(crate) fn has_direction(normal: Vec3) -> bool {
    // Finite only if all components are.
    let square = normal.length_squared();
    (square > MIN_LENGTH * MIN_LENGTH) & square.is_finite()
}

/// The covered pixels.
pub(crate) struct Covered {
    pub(crate) mask: Mask,
    /// Original lengths of the normals.
    pub(crate) lengths: Plane,
    /// Number of missing depth samples that were filled.
    pub(crate) filled: usize,
}

/// Finds the covered pixels, and converts their normals and depth: unit normals, and values that increase with
/// distance; both 0 elsewhere. Depth of unknown encoding is left unchanged; isolated missing samples of it are filled.
pub(crate) fn cover(
    normal: &mut Vector3Planes,
    mut depth: Option<(&mut Plane, Option<StoredDepth>)>,
    alpha: Option<&Plane>,
    mask: Option<&Plane>,
) -> Covered {
    if let Some((depth, Some(stored))) = &mut depth {
        to_distances(depth, *stored);
    }
    let filled = depth.as_mut().map(|(depth, _)| fill(depth, normal));
    let stored = depth.as_ref().and_then(|(_, stored)| *stored);
    let depth_shows_coverage = depth.is_some() && stored.is_none_or(StoredDepth::shows_coverage);
    // Alpha decides only if nothing else does.
    let alpha = alpha.filter(|_| !depth_shows_coverage && mask.is_none());
    let distances = depth.as_ref().map(|(depth, _)| &**depth);
    let (width, height) = (normal.x.width(), normal.x.height());
    let mut covered = Plane::filled(width, height, false);
    let mut lengths = Plane::filled(width, height, 0.0);
    let Vector3Planes { x, y, z } = normal;
    // In one pass, since normals are too large for caches.
    let planes = [x, y, z, &mut lengths];
    each_row_beside(&mut covered, planes, |row, covered, [x, y, z, lengths]| {
        cover_row(covered, row, [&*x, &*y, &*z], distances, [mask, alpha]);
        normalise_row([x, y, z], covered, lengths);
    });
    let mask = Mask::new(covered);
    if let Some((depth, _)) = depth {
        blank_outside(depth, &mask);
    }
    Covered {
        mask,
        lengths,
        filled: filled.unwrap_or(0),
    }
}

/// Removes pixels without a distance from the mask, and sets depth to 0 outside it, so that no NaN or sentinel remains.
pub(crate) fn narrow_to(mask: &mut Mask, depth: &mut Plane) {
    *mask = Mask::new(Plane::from_fn(mask.width(), mask.height(), |x, y| {
        mask.at(x, y) && is_distance(depth.at(x, y))
    }));
    blank_outside(depth, mask);
}

fn blank_outside(depth: &mut Plane, mask: &Mask) {
    depth.each_with(mask.plane(), |sample, covered| {
        *sample = if covered { *sample } else { 0.0 };
    });
}

/// The plane, if it is not constant: alpha that is 1 everywhere shows no edge.
pub(crate) fn varying(plane: Option<&Plane>) -> Option<Plane> {
    let plane = plane?;
    let first = plane.at(0, 0);
    let varies = plane.samples().iter().any(|&v| v != first);
    varies.then(|| plane.clone())
}

/// Coverage brought to 0..1; NaN covers nothing.
pub(crate) fn shares(mut plane: Plane) -> Plane {
    for sample in plane.samples_mut() {
        *sample = if *sample > 0.0 { sample.min(1.0) } else { 0.0 };
    }
    plane
}

/// Replaces NaN by 0 and infinities by the largest half float. Returns the number of samples replaced.
pub(crate) fn sanitise(plane: &mut Plane) -> usize {
    let replaced = |samples: &mut [f32]| {
        // Rare: all are looked at, many at a time.
        if samples.iter().fold(true, |all, v| all & v.is_finite()) {
            return 0;
        }
        let odd = samples.iter_mut().filter(|sample| !sample.is_finite());
        odd.map(|sample| {
            *sample = match sample.is_nan() {
                true => 0.0,
                false => HALF_INFINITY.copysign(*sample),
            }
        })
        .count()
    };
    let parts = plane.samples_mut().par_chunks_mut(SAMPLES_PER_TASK);
    parts.map(replaced).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_without_direction_are_not_covered() {
        let x = vec![0.0, f32::NAN, f32::INFINITY, 1e30, 1.0, 0.01];
        let zero = Plane::filled(6, 1, 0.0);
        let normal = Vector3Planes {
            x: Plane::from_samples(6, 1, x),
            y: zero.clone(),
            z: zero,
        };
        assert_eq!(
            of_normals(&normal, None, None, None).row(0),
            [false, false, false, false, true, false]
        );
    }

    #[test]
    fn coverage_is_a_share() {
        let stored = vec![0.25, 1.0002, 1e10, f32::INFINITY, -0.1, -1e38, f32::NAN];
        let read = shares(Plane::from_samples(7, 1, stored));
        assert_eq!(read.row(0), [0.25, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn what_cannot_be_shown_is_replaced() {
        let mut plane =
            Plane::from_samples(4, 1, vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -2.0]);
        assert_eq!(sanitise(&mut plane), 3);
        assert_eq!(plane.row(0), [0.0, 65504.0, -65504.0, -2.0]);
    }
}
