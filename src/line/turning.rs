//! Rate at which the normal turns across the picture.

use crate::frame::{Mask, Plane};
use glam::{Vec2, Vec3, Vec3A};

/// Derivatives of the unit normal per pixel, x right and y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turning {
    x: Vec3A,
    y: Vec3A,
}

impl Turning {
    /// The turning of normals at a pixel, by Sobel's differences; 0 marks a missing normal, beyond which the surface
    /// continues unchanged.
    pub(crate) fn at(normals: &Plane<Vec3>, x: usize, y: usize) -> Self {
        Self::between(rows_around(normals, y), x)
    }

    /// The turning in the middle of three rows of normals.
    #[inline]
    fn between(rows: [&[Vec3]; 3], x: usize) -> Self {
        let here = Vec3A::from(rows[1][x]);
        let (left, right) = (x.saturating_sub(1), (x + 1).min(rows[1].len() - 1));
        let there = |normal: Vec3| {
            let normal = Vec3A::from(normal);
            if normal == Vec3A::ZERO { here } else { normal }
        };
        // Mapping arrays is not inlined.
        let around = |row: &[Vec3]| [there(row[left]), there(row[x]), there(row[right])];
        Self::amid([around(rows[0]), around(rows[1]), around(rows[2])])
    }

    /// The turning amid three rows of three normals.
    #[inline]
    pub(crate) fn amid([above, level, below]: [[Vec3A; 3]; 3]) -> Self {
        let smooth = |a: Vec3A, b: Vec3A, c: Vec3A| 0.25 * (a + c) + 0.5 * b;
        let column = |i: usize| smooth(above[i], level[i], below[i]);
        let row = |row: [Vec3A; 3]| smooth(row[0], row[1], row[2]);
        Self {
            x: 0.5 * (column(2) - column(0)),
            y: 0.5 * (row(above) - row(below)),
        }
    }

    /// The squares and the product of both: a metric of the picture in which lengths are angles of the normal.
    #[inline]
    fn metric(&self) -> [f32; 3] {
        [self.x.dot(self.x), self.x.dot(self.y), self.y.dot(self.y)]
    }

    /// The view-dependent curvature `q`, in radians per pixel: the largest singular value.
    #[inline]
    pub(crate) fn largest(&self) -> f32 {
        largest_eigenvalue(self.metric()).sqrt()
    }

    /// Whether the normal turns across the fastest direction too, by half as much at the least.
    pub(crate) fn is_both_ways(&self) -> bool {
        let [xx, xy, yy] = self.metric();
        let largest = largest_eigenvalue([xx, xy, yy]);
        xx + yy - largest > 0.25 * largest
    }

    /// The unit direction in which the normal turns fastest, x right and y up.
    pub(crate) fn direction(&self) -> Vec2 {
        let [xx, xy, yy] = self.metric();
        let square = largest_eigenvalue([xx, xy, yy]);
        // The larger of two that are square to the rows of the metric less its eigenvalue.
        let (a, b) = (Vec2::new(square - yy, xy), Vec2::new(xy, square - xx));
        let longer = if a.length_squared() >= b.length_squared() {
            a
        } else {
            b
        };
        longer.try_normalize().unwrap_or(Vec2::X)
    }

    /// Tilt of the normal along a direction, per pixel in it: positive where the surface is convex.
    pub(crate) fn bend(&self, along: Vec2) -> f32 {
        (along.x * self.x + along.y * self.y).truncate().dot(along)
    }
}

/// The rows above, at and below a row of normals; the border is repeated.
fn rows_around(normals: &Plane<Vec3>, y: usize) -> [&[Vec3]; 3] {
    [y.saturating_sub(1), y, (y + 1).min(normals.height() - 1)].map(|y| normals.row(y))
}

/// The view-dependent curvature of normals, in radians per pixel; 0 outside the mask.
pub(crate) fn curvature(normals: &Plane<Vec3>, mask: &Mask) -> Plane {
    Plane::of_covered(mask, |y| {
        let around = rows_around(normals, y);
        move |x| Turning::between(around, x).largest()
    })
}

/// The larger eigenvalue of a symmetric matrix.
#[inline]
fn largest_eigenvalue([xx, xy, yy]: [f32; 3]) -> f32 {
    let half = 0.5 * (xx - yy);
    0.5 * (xx + yy) + (half * half + xy * xy).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cylinder_turns_across_its_axis() {
        // Radius 40, with the axis at 30 degrees to the horizontal: at the top the normal turns by 1/40 a pixel across
        // it.
        let across = Vec2::from_angle(30_f32.to_radians()).perp();
        for sign in [1.0, -1.0] {
            let normals = Plane::from_fn(21, 21, |x, y| {
                let lean = across.dot(Vec2::new(x as f32 - 10.0, 10.0 - y as f32)) / 40.0;
                let flat = sign * lean * across;
                Vec3::new(flat.x, flat.y, (1.0 - lean * lean).sqrt())
            });
            let turning = Turning::at(&normals, 10, 10);
            assert!((turning.largest() - 0.025).abs() < 1e-4);
            assert!(turning.direction().perp_dot(across).abs() < 1e-3);
            assert!((turning.bend(turning.direction()) - sign * 0.025).abs() < 1e-4);
        }
    }
}
