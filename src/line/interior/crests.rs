//! Crests: pixels where a strength is largest across a direction, placed to a part of a pixel.

use crate::frame::{Mask, Plane};
use crate::line::interior::facing::Viewer;
use crate::line::interior::level::FormLevel;
use crate::line::interior::sizes::Sizes;
use crate::line::turning::Turning;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// A pixel that a line passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::line) struct Crest {
    /// Its number, row by row.
    pub(in crate::line) pixel: u32,
    /// Position of the line in or beside the pixel: x right, y down, pixel edges at integers.
    pub(in crate::line) at: Vec2,
    /// Strength of the line there, in radians over the picture.
    pub(in crate::line) strength: f32,
}

/// Largest distance of a crest from its pixel's centre.
const FARTHEST: f32 = 0.6;

/// Component of a unit direction, above which it leads across a border.
const ACROSS: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// Strength required of ridges, as a multiple of that of valleys.
const RIDGE_STRENGTH: f32 = 2.0;

/// Strength required of suggestive contours, as a share of that of valleys.
const SUGGESTIVE_STRENGTH: f32 = 0.6;

/// Suggestive contours keep away from where a surface faces the viewer: sine of 20 degrees.
const LEAST_SLANT: f32 = 0.342;

/// Edges of a level's surface: it ends, or hides another.
pub(super) struct FormRims<'a> {
    mask: &'a Mask,
    conductance: &'a Plane,
    /// Offsets of the pixels that lines keep away from.
    around: Vec<[isize; 2]>,
}

impl<'a> FormRims<'a> {
    pub(super) fn new(level: &'a FormLevel, margin: f32) -> Self {
        let reach = margin as isize;
        let square = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
        let mut around: Vec<_> = square
            .filter(|[x, y]| ((x * x + y * y) as f32) <= margin * margin)
            .collect();
        // The nearest pixels first: most pixels near a rim are found early.
        around.sort_by_key(|[x, y]| x * x + y * y);
        Self {
            mask: &level.frame.mask,
            conductance: &level.conductance,
            around,
        }
    }

    /// Whether a pixel is within the margin of a rim. The border of the picture is not a rim.
    pub(super) fn is_near(&self, x: usize, y: usize) -> bool {
        self.around.iter().any(|&[dx, dy]| {
            let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            let covered = self.mask.plane().get(x, y);
            covered.is_some_and(|covered| !covered || self.conductance.at(x, y) < 0.5)
        })
    }
}

/// The crests of the curvature of normals: those of valleys, and those of ridges.
pub(super) fn valleys_and_ridges(
    normals: &Plane<Vec3>,
    curvature: &Plane,
    rims: [&FormRims; 2],
    sizes: &Sizes,
) -> [Vec<Crest>; 2] {
    let found = each_pixel(rims[0].mask, |x, y| {
        let strength = curvature.at(x, y) * sizes.picture;
        if strength < sizes.thresholds[0] {
            return None;
        }
        let turning = Turning::at(normals, x, y);
        let across = turning.direction();
        let is_ridge = turning.bend(across) > 0.0;
        let strength = if is_ridge {
            strength / RIDGE_STRENGTH
        } else {
            strength
        };
        let crest = crest(curvature, x, y, across, || strength)?;
        let is_strong = strength >= sizes.thresholds[0];
        let is_free = is_strong && !rims[usize::from(is_ridge)].is_near(x, y);
        is_free.then_some((is_ridge, crest))
    });
    [false, true].map(|ridges| {
        let own = found.iter().filter(|(is_ridge, _)| *is_ridge == ridges);
        own.map(|&(_, crest)| crest).collect()
    })
}

/// The crests of suggestive contours, in normals of the scale `sigma`.
pub(super) fn suggestive(
    normals: &Plane<Vec3>,
    sigma: f32,
    viewer: &Viewer,
    rims: &FormRims,
    sizes: &Sizes,
) -> Vec<Crest> {
    let facings = viewer.facings(normals, rims.mask);
    let slants = facings.map(|facing| 1.0 - facing);
    let most = (1.0 - LEAST_SLANT * LEAST_SLANT).sqrt();
    each_pixel(rims.mask, |x, y| {
        let facing = facings.at(x, y);
        if facing > most {
            return None;
        }
        let uphill = viewer.uphill(x, y, normals.at(x, y))?;
        let side = |steps: f32| sampled(&facings, x, y, steps * uphill);
        let second = || (side(sigma) + side(-sigma) - 2.0 * facing) / (sigma * sigma);
        let strength = || sigma * second() * sizes.picture / SUGGESTIVE_STRENGTH;
        let crest = crest(&slants, x, y, uphill, strength)?;
        (crest.strength >= sizes.thresholds[0] && !rims.is_near(x, y)).then_some(crest)
    })
}

/// The results at the covered pixels, in order.
pub(in crate::line) fn each_pixel<T: Send>(
    mask: &Mask,
    find: impl Fn(usize, usize) -> Option<T> + Sync,
) -> Vec<T> {
    let rows = (0..mask.height()).into_par_iter();
    let rows = rows.flat_map_iter(|y| {
        let find = &find;
        mask.runs(y).flatten().filter_map(move |x| find(x, y))
    });
    rows.collect()
}

/// The crest of this strength at the maximum of a plane along a direction (x right, y up) close to a pixel, if there is
/// one. Along the border there is none, as nothing is known beyond it.
pub(in crate::line) fn crest(
    plane: &Plane,
    x: usize,
    y: usize,
    along: Vec2,
    strength: impl FnOnce() -> f32,
) -> Option<Crest> {
    let (across_columns, across_rows) = (along.x.abs() > ACROSS, along.y.abs() > ACROSS);
    let is_at_end = |i: usize, count: usize| i == 0 || i + 1 == count;
    if across_columns && is_at_end(x, plane.width()) || across_rows && is_at_end(y, plane.height())
    {
        return None;
    }
    let here = plane.at(x, y);
    let lower = |along: Vec2| Some(sampled(plane, x, y, along)).filter(|there| here >= *there);
    let (ahead, behind) = (lower(along)?, lower(-along)?);
    if here == behind {
        return None;
    }
    // The top of the parabola through all three.
    let offset = 0.5 * (ahead - behind) / (2.0 * here - ahead - behind);
    let offset = offset.clamp(-FARTHEST, FARTHEST);
    Some(Crest {
        pixel: (y * plane.width() + x) as u32,
        at: Vec2::new(
            x as f32 + 0.5 + offset * along.x,
            y as f32 + 0.5 - offset * along.y,
        ),
        strength: strength(),
    })
}

/// A plane at an offset (x right, y up) from a pixel's centre, bilinearly; beyond the border as at it.
fn sampled(plane: &Plane, x: usize, y: usize, offset: Vec2) -> f32 {
    let last = Vec2::new((plane.width() - 1) as f32, (plane.height() - 1) as f32);
    let at =
        (Vec2::new(x as f32, y as f32) + Vec2::new(offset.x, -offset.y)).clamp(Vec2::ZERO, last);
    let (left, top) = (at.x as usize, at.y as usize);
    let (right, bottom) = (
        (left + 1).min(plane.width() - 1),
        (top + 1).min(plane.height() - 1),
    );
    let part = at - Vec2::new(left as f32, top as f32);
    let row = |y: usize| {
        let row = plane.row(y);
        (1.0 - part.x) * row[left] + part.x * row[right]
    };
    (1.0 - part.y) * row(top) + part.y * row(bottom)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_run_into_the_border_and_not_along_it() {
        // Strength that rises to the last row: as far as is known, it is largest beyond it.
        let at =
            |plane: &Plane, along: Vec2| crest(plane, 4, 8, along, || 1.0).map(|crest| crest.at);
        let rising = Plane::from_fn(9, 9, |_, y| y as f32);
        assert_eq!(at(&rising, Vec2::Y), None);
        assert_eq!(at(&rising, Vec2::NEG_Y), None);
        // A crest along column 4 is one up to that row.
        let roof = Plane::from_fn(9, 9, |x, _| -(x as f32 - 4.0).abs());
        for across in [Vec2::X, Vec2::NEG_X] {
            assert_eq!(at(&roof, across), Some(Vec2::new(4.5, 8.5)));
        }
    }
}
