//! Normals of the surface that depth alone shows.
//!
//! One over the distance along the view axis is affine on planes seen in perspective, and the distance itself on planes
//! seen in parallel lines: slopes are found in these, and planes come out exact.

use super::depth::is_distance;
use super::plane::each_row_of;
use super::slopes::{Rounding, Slopes, TOO_LARGE, slopes};
use super::{Plane, Projection, StoredDepth, Vector3Planes, Window};
use crate::kernel::simd::wide;
use half::f16;

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
    shown: impl Fn(usize, usize) -> bool + Sync,
    precision: Precision,
) -> Vector3Planes {
    let is_perspective = matches!(projection, Projection::Perspective { .. });
    let sky = sky_of(depth, stored);
    let values_of = |values: &mut [f32], y: usize| {
        let depth = depth.row(y);
        let if_distance = |d: f32, near: f32| if is_distance(d) { near } else { f32::NAN };
        match stored {
            StoredDepth::Height => values.copy_from_slice(depth),
            StoredDepth::Planar | StoredDepth::Relative => {
                row_of(values, depth, |d| if_distance(d, 1.0 / d));
            }
            StoredDepth::Ray => {
                for (x, (value, &d)) in values.iter_mut().zip(depth).enumerate() {
                    let at = window.middle(x, y);
                    let length = projection.to_eye(at.x, at.y).extend(1.0).length() as f32;
                    *value = if_distance(d, length / d);
                }
            }
            StoredDepth::Inverse => row_of(values, depth, |d| if d > 0.0 { d } else { f32::NAN }),
            mapped => row_of(values, depth, |d| match (d.clamp(0.0, 1.0), mapped) {
                (range, _) if sky == Some(range) => f32::NAN,
                (range, StoredDepth::WhiteFar) => 1.0 / (1.0 + (FAR_TO_NEAR - 1.0) * range),
                (range, _) if sky.is_some() => range,
                (range, _) => range + (1.0 - range) / FAR_TO_NEAR,
            }),
        }
        if !is_perspective && stored != StoredDepth::Height {
            values.iter_mut().for_each(|value| *value = -1.0 / *value);
        }
        for (x, value) in values.iter_mut().enumerate() {
            let is_value = shown(x, y) & (value.abs() < TOO_LARGE);
            *value = if is_value { *value } else { f32::NAN };
        }
    };
    let mut values = Plane::of_rows(depth.width(), depth.height(), |y, row| values_of(row, y));
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
    let mut found = slopes(&mut values, &rounding);
    if stored == StoredDepth::Height {
        found.go_over_steps(&values);
    }
    normals(values, found, projection, window)
}

/// A row of what depth stands for.
fn row_of(values: &mut [f32], depth: &[f32], of: impl Fn(f32) -> f32) {
    wide!(for (value, &depth) in values.iter_mut().zip(depth) {
        *value = of(depth);
    });
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
    /// That of samples of half floats, or of codes this far apart; where that is 0, what their numbers tell.
    pub(crate) fn stored(is_half: bool, rounding: f32, numbers: &Plane) -> Self {
        match (is_half, rounding > 0.0) {
            (true, _) => Self::Half,
            (false, true) => Self::Codes(rounding),
            (false, false) => Self::of(numbers),
        }
    }

    /// That of numbers which nothing else is known of: whole ones are codes, so are shares of the largest code of a picture,
    /// and those that halves can hold are halves.
    fn of(numbers: &Plane) -> Self {
        let all = |holds: fn(f32) -> bool| {
            let mut finite = numbers.samples().iter().filter(|v| v.is_finite());
            finite.all(|&v| holds(v))
        };
        if all(|v| v == 0.0) {
            Self::Float
        } else if all(|v| v.fract() == 0.0) {
            Self::Codes(1.0)
        } else if all(|v| is_code(v, 255.0)) {
            Self::Codes(1.0 / 255.0)
        } else if all(|v| f32::from(f16::from_f32(v)) == v) {
            Self::Half
        } else if all(|v| is_code(v, 65_535.0)) {
            Self::Codes(1.0 / 65_535.0)
        } else {
            Self::Float
        }
    }

    /// The same of numbers times `factor`.
    pub(crate) fn times(self, factor: f32) -> Self {
        match self {
            Self::Codes(step) => Self::Codes(factor.abs() * step),
            other => other,
        }
    }

    /// The distance of what can be stored around a value.
    fn step(self, value: f32) -> f32 {
        match self {
            Self::Float => 0.0,
            Self::Half => (value.abs().max(f32::MIN_POSITIVE).log2().floor() - 10.0).exp2(),
            Self::Codes(step) => step,
        }
    }
}

/// Whether a number from 0 to 1 is a code over the largest one, as exactly as floats hold it.
fn is_code(number: f32, most: f32) -> bool {
    let code = number * most;
    (0.0..=1.0).contains(&number) && (code - code.round()).abs() <= f32::EPSILON * most
}

/// The least value of depth that marks no near and no far, where it stands for the sky.
fn sky_of(depth: &Plane, stored: StoredDepth) -> Option<f32> {
    if stored != StoredDepth::NormalizedNearIsOne {
        return None;
    }
    let at_least = depth.samples().iter().filter(|&&d| d <= 0.0).count();
    let share = at_least as f64 / depth.samples().len().max(1) as f64;
    (share >= SKY).then_some(0.0)
}

/// The normals of affine values by their slopes, in the memory of both.
///
/// A plane n P = -1 is seen at P = z (X / fx, -Y / fy, -1), X and Y pixels from the principal point, where 1/z =
/// -nx X / fx + ny Y / fy + nz: its slopes are -nx / fx and ny / fy, and nz is what is left at X = Y = 0.
fn normals(values: Plane, slopes: Slopes, projection: Projection, window: Window) -> Vector3Planes {
    let Slopes {
        across: mut x,
        down: mut y,
        found,
    } = slopes;
    let mut z = values;
    let from_axis: Vec<f32> = match projection {
        Projection::Perspective { cx, .. } => {
            let columns = 0..z.width();
            columns
                .map(|column| (window.middle(column, 0).x - cx) as f32)
                .collect()
        }
        Projection::Orthographic { .. } => Vec::new(),
    };
    each_row_of([&mut x, &mut y, &mut z], |row, [x, y, z]| {
        let slopes = x.iter_mut().zip(y).zip(z);
        let found = found.row(row).iter();
        match projection {
            Projection::Perspective { fx, fy, cy, .. } => {
                let (fx, fy) = (fx as f32, fy as f32);
                let down = (window.middle(0, row).y - cy) as f32;
                wide!(
                    for ((((x, y), z), found), right) in slopes.zip(found).zip(&from_axis) {
                        let (p, q) = (*x, *y);
                        let at_axis = *z - right * p - down * q;
                        [*x, *y, *z] = unit([-fx * p, fy * q, at_axis], *found);
                    }
                );
            }
            Projection::Orthographic { sx, sy, .. } => {
                let (sx, sy) = (sx as f32, sy as f32);
                wide!(for (((x, y), z), found) in slopes.zip(found) {
                    [*x, *y, *z] = unit([-sx * *x, sy * *y, 1.0], *found);
                });
            }
        }
    });
    Vector3Planes { x, y, z }
}

/// A vector of length 1, or 0 where there is none.
#[inline(always)]
fn unit([x, y, z]: [f32; 3], is_found: bool) -> [f32; 3] {
    // Divided by its size first: squares of very small and of very large numbers leave the range of floats.
    let size = x.abs() + y.abs() + z.abs();
    let scale = if is_found & (size > 0.0) {
        1.0 / size
    } else {
        0.0
    };
    let [x, y, z] = [x * scale, y * scale, z * scale];
    let square = x * x + y * y + z * z;
    let share = if square > 0.0 {
        1.0 / square.sqrt()
    } else {
        0.0
    };
    [x * share, y * share, z * share]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_tell_how_finely_they_were_stored() {
        let of = |number: fn(f32) -> f32| {
            Precision::of(&Plane::from_fn(9, 2, |x, y| number((x + 9 * y) as f32)))
        };
        assert_eq!(of(|i| 7.0 * i), Precision::Codes(1.0));
        // 1 / 1024 is the distance of halves from 1 to 2; a third is none.
        assert_eq!(of(|i| 1.0 + i / 1024.0), Precision::Half);
        assert_eq!(of(|i| 1.0 + i / 3.0), Precision::Float);
        assert_eq!(of(|_| 0.0), Precision::Float);
        assert_eq!(of(|i| 3.0 * i / 255.0), Precision::Codes(1.0 / 255.0));
        assert_eq!(of(|i| i / 65_535.0), Precision::Codes(1.0 / 65_535.0));
        assert_eq!(
            of(|i| if i > 3.0 { f32::NAN } else { i }),
            Precision::Codes(1.0)
        );
        assert_eq!(Precision::Codes(1.0).times(0.5), Precision::Codes(0.5));
    }
}
