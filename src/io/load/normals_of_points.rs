//! Normals where a file has none: from the points that neighbouring pixels show.

use crate::frame::{Vector3Planes, step_between};
use glam::DVec3;

/// Unit normals of the surface through `points`, facing `toward` the viewer; 0 without a point, or without a neighbour
/// along one axis. With `wraps` the left and right edges of the picture are adjacent.
pub(crate) fn normals_of_points(
    size: [usize; 2],
    wraps: bool,
    point: impl Fn(usize, usize) -> Option<DVec3>,
    toward: impl Fn(DVec3) -> DVec3,
) -> Vector3Planes {
    let [width, height] = size;
    let normal = |x: usize, y: usize| {
        let here = point(x, y)?;
        let row = |y: Option<usize>| point(x, y.filter(|&y| y < height)?);
        let [left, right] = match wraps {
            true => [(x + width - 1) % width, (x + 1) % width].map(|x| point(x, y)),
            false => [x.checked_sub(1), Some(x + 1).filter(|&x| x < width)].map(|x| point(x?, y)),
        };
        let across = step_between(left, here, right)?;
        let down = step_between(row(y.checked_sub(1)), here, row(Some(y + 1)))?;
        let normal = across.cross(down).try_normalize()?;
        Some(if normal.dot(toward(here)) < 0.0 {
            -normal
        } else {
            normal
        })
    };
    Vector3Planes::from_fn(width, height, |x, y| normal(x, y).unwrap_or(DVec3::ZERO))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_seen_from_its_middle_has_its_normals_at_every_edge() {
        use crate::frame::map_direction;
        let (width, height) = (64, 32);
        let point = |x, y| Some(2.0 * map_direction(x, y, width, height));
        let found = normals_of_points([width, height], true, point, |p| -p);
        for (x, y) in [(0, 16), (63, 16), (20, 3), (40, 30), (0, 0)] {
            let expected = -map_direction(x, y, width, height);
            let n = [&found.x, &found.y, &found.z].map(|p| f64::from(p.at(x, y)));
            // Central steps along a circle are exact; at the first and last row they are one-sided, off by half a
            // step of 5.6 degrees.
            let limit = if (1..31).contains(&y) { 1e-3 } else { 0.06 };
            assert!(DVec3::from(n).distance(expected) < limit, "{x} {y} {n:?}");
        }
    }

    #[test]
    fn a_step_between_surfaces_is_not_a_slope() {
        // Two walls, at 1 and 3: square to z up to the last pixel.
        let point = |x: usize, y: usize| {
            let z = if x < 4 { -1.0 } else { -3.0 };
            (y > 0).then_some(DVec3::new(x as f64 * 0.1, y as f64 * -0.1, z))
        };
        let found = normals_of_points([8, 4], false, point, |p| -p);
        for x in 0..8 {
            assert_eq!(
                [found.x.at(x, 2), found.y.at(x, 2), found.z.at(x, 2)],
                [0.0, 0.0, 1.0]
            );
            assert_eq!(found.z.at(x, 0), 0.0);
        }
    }
}
