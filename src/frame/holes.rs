//! Filling of isolated missing depth samples inside a surface.
//!
//! Through fog, glass or a leaf's alpha, a renderer that keeps the first sample's depth sometimes writes the depth of
//! the background, or none: every such pixel would be surrounded by silhouettes.

use super::depth::is_distance;
use super::normals::MIN_LENGTH;
use super::{Plane, Vector3Planes};
use glam::DVec3;
use rayon::prelude::*;

/// Number of passes over the depth: filled samples allow filling their neighbours.
const PASSES: usize = 4;

/// Number of rows and columns within which a sample can affect the filling of another.
pub(crate) const HOLE_REACH: usize = PASSES;

/// Two depths belong to one surface if their relative difference is below this.
const SAME_SURFACE: f32 = 0.05;

/// Cosine of the largest angle between normals of one surface at neighbouring pixels: 25 degrees.
const SAME_DIRECTION: f64 = 0.9;

/// Minimum number of the four pairs of opposite neighbours that must show the surface.
const FEWEST_PAIRS: usize = 2;

/// One neighbour of each pair of opposite ones, as offsets in columns and rows.
const OPPOSITE: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];

/// Fills samples of `depth`, in distances, that are missing or lie behind the surface shown by all their neighbours,
/// where there is a normal. Returns the number filled.
///
/// On a plane in perspective, the depth between opposite neighbours at depths a and b is 2 / (1/a + 1/b).
pub(crate) fn fill(depth: &mut Plane, normal: &Vector3Planes) -> usize {
    let mut filled = 0;
    for _ in 0..PASSES {
        let found: Vec<_> = (1..depth.height().saturating_sub(1))
            .into_par_iter()
            .flat_map_iter(|y| holes_in_row(depth, normal, y))
            .collect();
        if found.is_empty() {
            break;
        }
        filled += found.len();
        for ([x, y], surface) in found {
            depth.row_mut(y)[x] = surface;
        }
    }
    filled
}

/// The holes of row `y`, neither the first nor the last, with the depth of the surface there.
fn holes_in_row(depth: &Plane, normal: &Vector3Planes, y: usize) -> Vec<([usize; 2], f32)> {
    let (row, above) = (depth.row(y), depth.row(y - 1));
    let mut found = Vec::new();
    for x in 1..row.len().saturating_sub(1) {
        // Most samples are not farther than some neighbour.
        let nearest = 1.0 + SAME_SURFACE;
        let (here, before, after) = (row[x], row[x - 1], row[x + 1]);
        if is_distance(here) && (here <= nearest * before || here <= nearest * after) {
            continue;
        }
        // Without depth above only one pair is left, along the row, which is too few: most of a background is like
        // that.
        if !above[x - 1..=x + 1].iter().copied().any(is_distance) {
            continue;
        }
        if let Some(surface) = surface_at(depth, x, y)
            && (!is_distance(here) || here > nearest * surface)
            && is_smooth(normal, x, y)
        {
            found.push(([x, y], surface));
        }
    }
    found
}

/// The depth of the surface shown by opposite neighbours, if enough pairs do and all agree.
fn surface_at(depth: &Plane, x: usize, y: usize) -> Option<f32> {
    let at = |[dx, dy]: [isize; 2]| {
        let sample = depth.at(x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
        is_distance(sample).then_some(sample)
    };
    let pairs = OPPOSITE.iter().filter_map(|&[dx, dy]| {
        let (a, b) = (at([dx, dy])?, at([-dx, -dy])?);
        Some(2.0 / (1.0 / a + 1.0 / b))
    });
    let (mut count, mut sum) = (0, 0.0);
    let (mut least, mut most) = (f32::INFINITY, 0.0f32);
    for between in pairs {
        count += 1;
        sum += between;
        (least, most) = (least.min(between), most.max(between));
    }
    let agree = most <= (1.0 + SAME_SURFACE) * least;
    (count >= FEWEST_PAIRS && agree).then(|| sum / count as f32)
}

/// Whether a normal has a direction, shared approximately by all around it.
fn is_smooth(normal: &Vector3Planes, x: usize, y: usize) -> bool {
    let has_direction = |n: &DVec3| n.is_finite() && n.length() > f64::from(MIN_LENGTH);
    let unit = |dx: isize, dy: isize| {
        let n = normal.at(x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
        has_direction(&n).then(|| n.normalize())
    };
    let Some(here) = unit(0, 0) else {
        return false;
    };
    let around = OPPOSITE
        .iter()
        .flat_map(|&[dx, dy]| [unit(dx, dy), unit(-dx, -dy)]);
    around.flatten().all(|n| n.dot(here) > SAME_DIRECTION)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: usize = 24;

    /// Normals toward the viewer everywhere.
    fn facing() -> Vector3Planes {
        let zero = Plane::filled(SIZE, SIZE, 0.0);
        Vector3Planes {
            x: zero.clone(),
            y: zero.clone(),
            z: Plane::filled(SIZE, SIZE, 1.0),
        }
    }

    /// The distance of a plane: its inverse is linear in the picture.
    fn slope(x: usize, y: usize) -> f32 {
        1.0 / (0.2 + 0.002 * x as f32 - 0.001 * y as f32)
    }

    #[test]
    fn samples_of_fog_are_filled_with_the_plane_around_them() {
        for behind in [1e10, f32::INFINITY, 0.0, f32::NAN, 40.0] {
            let is_hole = |x: usize, y: usize| x % 3 == 1 && y % 2 == 1;
            let mut depth = Plane::from_fn(SIZE, SIZE, |x, y| match is_hole(x, y) {
                true => behind,
                false => slope(x, y),
            });
            assert!(fill(&mut depth, &facing()) > SIZE * SIZE / 8);
            for y in 2..SIZE - 2 {
                for x in 2..SIZE - 2 {
                    // A mean of harmonic means on a plane is exact up to rounding.
                    let error = depth.at(x, y) / slope(x, y) - 1.0;
                    assert!(error.abs() < 1e-5, "{behind} at {x}, {y}: {error}");
                }
            }
        }
    }

    #[test]
    fn what_is_seen_between_things_and_beside_them_stays() {
        let mut normal = facing();
        let scenes: [fn(usize, usize) -> f32; 4] = [
            // A step to a wall behind, a gap of one pixel to it, a wire in front, and single nearer pixels.
            |x, y| if x + y < SIZE { 5.0 } else { 9.0 },
            |x, _| if x == 9 { 9.0 } else { 5.0 },
            |x, y| if x == y { 5.0 } else { 9.0 },
            |x, y| if x % 5 == 2 && y % 5 == 2 { 5.0 } else { 9.0 },
        ];
        for scene in scenes {
            let stored = Plane::from_fn(SIZE, SIZE, scene);
            let mut depth = stored.clone();
            assert_eq!(fill(&mut depth, &normal), 0);
            assert_eq!(depth.samples(), stored.samples());
        }
        // Without a normal there is no surface.
        let mut depth = Plane::filled(SIZE, SIZE, 5.0);
        depth.row_mut(9)[9] = f32::INFINITY;
        normal.z.row_mut(9)[9] = 0.0;
        assert_eq!(fill(&mut depth, &normal), 0);
        assert_eq!(fill(&mut Plane::filled(1, 1, 0.0), &normal), 0);
    }
}
