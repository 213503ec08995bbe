//! Normals of the surface that depth alone shows.
//!
//! One over the distance along the view axis is affine on planes seen in perspective, and the distance itself on planes
//! seen in parallel lines: slopes are found in these, and planes come out exact.

use super::depth::is_distance;
use super::plane::each_row_of;
use super::slopes::{Rounding, Slopes, slopes};
use super::{Mask, Plane, Projection, StoredDepth, Vector3Planes, Window};
use glam::DVec3;

/// How many times farther than its nearest point depth without a scale is taken to reach.
const FAR_TO_NEAR: f32 = 5.0;

/// From this share of pixels on at the least value, they are taken for sky, which is infinitely far.
const SKY: f64 = 0.02;

/// Unit normals in view space, facing the viewer, of the surface seen in `window` whose depth this is, as it was stored;
/// 0 where none is, or no neighbour along one axis. `shown` tells the pixels whose depth counts.
///
/// Depth that was mapped to 0..1 has no scale: white-near is taken for one over the distance, five times as far at its
/// least as at its most, or infinitely far if many pixels share the least value; white-far for a distance from 1 to 5. Then
/// creases, outlines and the signs of curvature are right, and slopes are not.
pub(crate) fn normals_of_depth(
    depth: &Plane,
    stored: StoredDepth,
    (projection, window): (Projection, Window),
    shown: impl Fn(usize, usize) -> bool,
    precision: Precision,
) -> Vector3Planes {
    let (width, height) = (depth.width(), depth.height());
    let is_perspective = matches!(projection, Projection::Perspective { .. });
    let sky = sky_of(depth, stored);
    let value = |x: usize, y: usize| -> Option<f32> {
        let d = depth.at(x, y);
        let range = d.clamp(0.0, 1.0);
        if !shown(x, y) || d.is_nan() || sky == Some(range) {
            return None;
        }
        let nearness = match stored {
            StoredDepth::Height => return d.is_finite().then_some(d),
            StoredDepth::Planar | StoredDepth::Relative => is_distance(d).then(|| 1.0 / d),
            StoredDepth::Ray => {
                let at = window.middle(x, y);
                is_distance(d)
                    .then(|| projection.to_eye(at.x, at.y).extend(1.0).length() as f32 / d)
            }
            StoredDepth::Inverse => (d > 0.0 && d.is_finite()).then_some(d),
            StoredDepth::WhiteFar => Some(1.0 / (1.0 + (FAR_TO_NEAR - 1.0) * range)),
            StoredDepth::NormalizedNearIsOne if sky.is_some() => Some(range),
            StoredDepth::NormalizedNearIsOne => Some(range + (1.0 - range) / FAR_TO_NEAR),
        };
        nearness.map(|near| if is_perspective { near } else { -1.0 / near })
    };
    let values = Plane::from_fn(width, height, |x, y| value(x, y).unwrap_or(0.0));
    let valid = Mask::new(Plane::from_fn(width, height, |x, y| value(x, y).is_some()));
    // Rounding of distances, as it is in their inverses: the derivative of 1/z is -1/z^2.
    let of_distance = |far: f32| {
        move |value: f32| match is_perspective {
            true => far * precision.step(1.0 / value) * value * value,
            false => far * precision.step(value),
        }
    };
    let (plain, mapped) = (of_distance(1.0), of_distance(FAR_TO_NEAR - 1.0));
    let near = |value: f32| precision.step(value);
    let rounding = match (stored, precision) {
        (_, Precision::Float) => Rounding::Step(0.0),
        (StoredDepth::NormalizedNearIsOne, Precision::Codes(step)) if is_perspective => {
            let share = if sky.is_some() {
                1.0
            } else {
                1.0 - 1.0 / FAR_TO_NEAR
            };
            Rounding::Step(share * step)
        }
        (StoredDepth::Height, Precision::Codes(step)) => Rounding::Step(step),
        (StoredDepth::Height, _) => Rounding::Of(&near),
        (StoredDepth::Inverse, Precision::Codes(step)) if is_perspective => Rounding::Step(step),
        (StoredDepth::Inverse | StoredDepth::NormalizedNearIsOne, _) if is_perspective => {
            Rounding::Of(&near)
        }
        (StoredDepth::WhiteFar | StoredDepth::NormalizedNearIsOne, _) => Rounding::Of(&mapped),
        _ => Rounding::Of(&plain),
    };
    let found = slopes(values.clone(), &valid, &rounding);
    normals(&values, &found, projection, window)
}

/// How finely depth was stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Precision {
    /// 32 bits of floating point.
    Float,
    /// 16 bits of it.
    Half,
    /// Codes this far apart.
    Codes(f32),
}

impl Precision {
    /// The distance of what can be stored around a value.
    fn step(self, value: f32) -> f32 {
        match self {
            Self::Float => 0.0,
            Self::Half => (value.abs().max(f32::MIN_POSITIVE).log2().floor() - 10.0).exp2(),
            Self::Codes(step) => step,
        }
    }
}

/// The least value of depth that marks no near and no far, where it stands for the sky.
fn sky_of(depth: &Plane, stored: StoredDepth) -> Option<f32> {
    let is_far_least = stored == StoredDepth::NormalizedNearIsOne;
    let at_least = depth.samples().iter().filter(|&&d| d <= 0.0).count();
    let share = at_least as f64 / depth.samples().len().max(1) as f64;
    (is_far_least && share >= SKY).then_some(0.0)
}

/// The normals of affine values by their slopes.
///
/// A plane n P = -1 is seen at P = z (X / fx, -Y / fy, -1), X and Y pixels from the principal point, where 1/z =
/// -nx X / fx + ny Y / fy + nz: its slopes are -nx / fx and ny / fy, and nz is what is left at X = Y = 0.
fn normals(
    values: &Plane,
    slopes: &Slopes,
    projection: Projection,
    window: Window,
) -> Vector3Planes {
    let (width, height) = (values.width(), values.height());
    let [mut x, mut y, mut z] = [(); 3].map(|()| Plane::filled(width, height, 0.0));
    let normal = |column: usize, row: usize| {
        let [across, down] =
            [&slopes.across, &slopes.down].map(|plane| f64::from(plane.at(column, row)));
        let at = window.middle(column, row);
        match projection {
            Projection::Perspective { fx, fy, cx, cy } => {
                let value = f64::from(values.at(column, row));
                let at_axis = value - (at.x - cx) * across - (at.y - cy) * down;
                DVec3::new(-fx * across, fy * down, at_axis)
            }
            Projection::Orthographic { sx, sy, .. } => DVec3::new(-sx * across, sy * down, 1.0),
        }
    };
    each_row_of([&mut x, &mut y, &mut z], |row, [x, y, z]| {
        for column in (0..width).filter(|&column| slopes.found.at(column, row)) {
            let n = normal(column, row).normalize_or_zero().as_vec3();
            (x[column], y[column], z[column]) = (n.x, n.y, n.z);
        }
    });
    Vector3Planes { x, y, z }
}
