//! A distance map as a surface for ray hits.

use super::bounds::{Bounds, of_planes};
use super::search::{Bounded, Crossing, first_crossing, steps_for};
use super::texels::{
    BeyondSides, Reached, TangentPlane, TexelShare, agreed, around, heaviest, mean_at,
};
use crate::frame::{ColorPlanes, Ray, Surroundings, Vector3Planes};
use crate::params::SearchParams;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::ops::{Range, RangeInclusive};

/// The surroundings of an object, for world-space rays.
#[derive(Debug, Clone)]
pub(crate) struct DistanceMap<'a> {
    surroundings: &'a Surroundings,
    /// Tangent planes relative to the centre, row-major.
    planes: Vec<TangentPlane>,
    bounds: Bounds,
}

/// Cells of the bounds along each axis of the cube around all unit directions.
const CELLS: usize = 24;

/// Rows of blocks of texels that bounds are collected from: more cost time, fewer make bounds wider.
const BLOCKS: usize = 64;

/// Texels from the centre of one as far as it counts, bilinearly, and a tenth more: bounds are found by other roundings.
const COUNTS: f64 = 1.1;

/// Sine of what is left of a turn, as a share of its terms, below which rounding makes bounds uncertain.
const NEAR_END: f64 = 1e-5;

/// Sine of the angle between a ray and the direction from the centre to its start, below which the ray effectively
/// passes through the centre.
const THROUGH_CENTER: f64 = 1e-9;

impl<'a> DistanceMap<'a> {
    /// The map of `surroundings`.
    pub(crate) fn new(surroundings: &'a Surroundings) -> Self {
        let (width, height) = (surroundings.width(), surroundings.height());
        let plane = |i: usize| {
            let (x, y) = (i % width, i / width);
            let point = surroundings.point_at(x, y);
            match point == DVec3::ZERO {
                true => TangentPlane::NONE,
                false => TangentPlane::new(point, surroundings.normal_at(x, y), point.length()),
            }
        };
        let planes: Vec<TangentPlane> = (0..width * height).map(plane).collect();
        Self {
            bounds: bounds(&planes, width, height),
            surroundings,
            planes,
        }
    }

    /// The surroundings.
    pub(crate) fn surroundings(&self) -> &'a Surroundings {
        self.surroundings
    }

    /// Where a world-space ray first passes through the surroundings from inside, and the position that shows it: the
    /// same point if the centre sees it. `None` if there are no surroundings.
    ///
    /// Steps are even in the angle seen from the centre. For a ray that starts at distance `r0`, at the angle `Theta`
    /// to its direction, the point at the angle phi from the start is `r0 sin(Theta) / sin(Theta - phi)` away from the
    /// centre.
    pub(crate) fn reached(&self, ray: &Ray, search: &SearchParams) -> Option<Reached<DVec3>> {
        let center = self.surroundings.center;
        let from = ray.start - center;
        let ahead = ray.direction.try_normalize()?;
        let start = from.length();
        let toward = from.try_normalize().unwrap_or(ahead);
        let across = ahead - toward.dot(ahead) * toward;
        let sine = across.length();
        if sine < THROUGH_CENTER {
            let (distance, ..) = self.distance_toward(ahead)?;
            let point = center + distance * ahead;
            return Some(Reached::Seen(point, point));
        }
        let across = across / sine;
        let cosine = toward.dot(ahead);
        let turn = sine.atan2(cosine);
        let place = |s: f64| {
            let (sin, cos) = (s * turn).sin_cos();
            // The sine of what is left of the turn, from its own sine and cosine.
            let rest = (sine * cos - cosine * sin).max(0.0);
            (cos * toward + sin * across, start * sine / rest)
        };
        let about_center = Ray {
            start: from,
            direction: ahead,
        };
        let steps = steps_for(search, turn / PI);
        let crossing = first_crossing(
            steps,
            search.refinements,
            self.bounded_along(
                [toward, across],
                start,
                [sine, cosine],
                turn / f64::from(steps),
            ),
            |s| {
                let (direction, distance) = place(s);
                let (surface, ..) = self.distance_toward(direction)?;
                // At the end of the turn the ray is at infinity.
                Some(1.0 - (distance / surface).min(FAR_BEHIND))
            },
            |s| {
                let plane = self.heaviest_plane(place(s).0).1;
                let point =
                    from + plane.crossed(about_center.start, about_center.direction) * ahead;
                point.dot(across).atan2(point.dot(toward)) / turn
            },
        );
        match crossing {
            Crossing::Hit(s) => {
                let (direction, distance) = place(s);
                let point = center + distance * direction;
                Some(Reached::Seen(point, point))
            }
            Crossing::Unseen(s) => {
                let (direction, distance) = place(s);
                let (texel, plane) = self.heaviest_plane(direction);
                let point = plane.continued(&about_center, distance * direction)?;
                let shown = self.surroundings.point_at(texel.x, texel.y);
                Some(Reached::Beyond(center + point, center + shown))
            }
            Crossing::Nothing => None,
        }
    }

    /// Bounds at the places of a ray, one `step` of its turn after another.
    #[inline]
    fn bounded_along(
        &self,
        [toward, across]: [DVec3; 2],
        start: f64,
        [sine, cosine]: [f64; 2],
        step: f64,
    ) -> impl FnMut(f64) -> Bounded {
        let own_space = 0.5 * CELLS as f64 * self.surroundings.map_from_world;
        let (toward, across) = (own_space * toward, own_space * across);
        let (step_sin, step_cos) = step.sin_cos();
        let (mut sin, mut cos) = (0.0, 1.0);
        move |_| {
            let place = cos * toward + sin * across + 0.5 * CELLS as f64;
            let rest = sine * cos - cosine * sin;
            let is_certain = rest > NEAR_END * sine.max(sin);
            (sin, cos) = (
                sin * step_cos + cos * step_sin,
                cos * step_cos - sin * step_sin,
            );
            let cell = number(place.to_array().map(along));
            match is_certain {
                true => self.bounds.compared(cell, start * sine, rest),
                false => Bounded::Open,
            }
        }
    }

    /// The distance of the surroundings from their centre in the direction of a world-space point.
    #[inline]
    pub(crate) fn distance_of(&self, point: DVec3) -> Option<f64> {
        let toward = (point - self.surroundings.center).try_normalize()?;
        self.distance_toward(toward).map(|(distance, ..)| distance)
    }

    /// The unit normal at a point of the surroundings.
    #[inline]
    pub(crate) fn normal_at(&self, point: DVec3) -> Option<DVec3> {
        self.mean_at(point, |t| self.surroundings.normal_at(t.x, t.y))?
            .try_normalize()
    }

    /// The colour at a point of the surroundings.
    #[inline]
    pub(crate) fn color_at(&self, color: &ColorPlanes, point: DVec3) -> Option<[f32; 3]> {
        let mean = self.mean_at(point, |t| {
            let [r, g, b] = [&color.r, &color.g, &color.b].map(|p| f64::from(p.at(t.x, t.y)));
            DVec3::new(r, g, b)
        })?;
        Some(mean.as_vec3().to_array())
    }

    /// The direction at a point, of any length, from a field of directions on the surfaces, opposites being equal;
    /// `None` where the field is 0.
    #[inline]
    pub(crate) fn direction_at(&self, field: &Vector3Planes, point: DVec3) -> Option<DVec3> {
        let own = |t: &TexelShare| field.at(t.x, t.y);
        let mut sense = DVec3::ZERO;
        for t in self.texels(point - self.surroundings.center) {
            let here = own(&t);
            if t.weight * here.length_squared() > sense.length_squared() {
                sense = t.weight.sqrt() * here;
            }
        }
        let alike = |t: &TexelShare| {
            let here = own(t);
            if here.dot(sense) < 0.0 { -here } else { here }
        };
        self.mean_at(point, alike)
            .filter(|mean| mean.length_squared() > 0.0)
    }

    #[inline]
    fn mean_at(&self, point: DVec3, value: impl Fn(&TexelShare) -> DVec3) -> Option<DVec3> {
        let toward = point - self.surroundings.center;
        let (_, distances, texels) = self.distance_toward(toward.try_normalize()?)?;
        mean_at(toward.length(), distances, &texels, value)
    }

    #[inline]
    fn texels(&self, direction: DVec3) -> [TexelShare; 4] {
        let map = self.surroundings;
        let size = [map.width(), map.height()];
        around(map.position(direction), size, BeyondSides::Wraps)
    }

    /// The texel that counts most in a direction, and its plane.
    #[inline]
    fn heaviest_plane(&self, direction: DVec3) -> (TexelShare, &TangentPlane) {
        let texel = heaviest(&self.texels(direction));
        (
            texel,
            &self.planes[texel.y * self.surroundings.width() + texel.x],
        )
    }

    /// The distance of the surroundings in a unit direction, and the distance by each texel around it.
    #[inline]
    fn distance_toward(
        &self,
        direction: DVec3,
    ) -> Option<(f64, [Option<f64>; 4], [TexelShare; 4])> {
        let map = self.surroundings;
        let texels = self.texels(direction);
        // Mapping the array is not inlined.
        let mut distances = [None; 4];
        for (distance, t) in distances.iter_mut().zip(&texels) {
            let plane = &self.planes[t.y * map.width() + t.x];
            *distance = plane.along(DVec3::ZERO, direction);
        }
        Some((agreed(distances, &texels)?, distances, texels))
    }
}

/// Multiple of the distance of the surroundings that counts as infinitely far behind them.
const FAR_BEHIND: f64 = 1e3;

/// The place of a cell along an axis, in cells.
#[inline]
fn along(at: f64) -> usize {
    // A cast of less than 0 is 0.
    (at as usize).min(CELLS - 1)
}

#[inline]
fn number([x, y, z]: [usize; 3]) -> usize {
    (z * CELLS + y) * CELLS + x
}

/// The numbers of the cells in a box.
fn cells([x, y, z]: [&RangeInclusive<usize>; 3]) -> impl Iterator<Item = usize> {
    let rows = z.clone().flat_map(|z| y.clone().map(move |y| [y, z]));
    rows.flat_map(|[y, z]| x.clone().map(move |x| number([x, y, z])))
}

/// The bounds of a map with these tangent planes, by directions in its own space.
fn bounds(planes: &[TangentPlane], width: usize, height: usize) -> Bounds {
    let mut bounds = Bounds::new(CELLS * CELLS * CELLS);
    let side = (height / BLOCKS).max(1);
    let blocks = |size: usize| {
        let starts = (0..size).step_by(side);
        starts.map(move |start| start..(start + side).min(size))
    };
    // The angle of the middle of a block, and from there as far as its texels count.
    let angles = |block: &Range<usize>, size: usize, turn: f64| {
        let middle = 0.5 * (block.start + block.end) as f64;
        let reach = 0.5 * (block.len() - 1) as f64 + COUNTS;
        [middle / size as f64 - 0.5, reach / size as f64].map(|share| share * turn)
    };
    for rows in blocks(height) {
        let [down, reach_down] = angles(&rows, height, PI);
        let (sin_e, cos_e) = (-down).sin_cos();
        for columns in blocks(width) {
            let of_rows = rows.clone().map(|y| &planes[y * width..][columns.clone()]);
            let [azimuth, reach] = angles(&columns, width, TAU);
            let (sin_a, cos_a) = azimuth.sin_cos();
            let reach = reach.hypot(reach_down);
            let [x, y, z] = [cos_e * sin_a, sin_e, -cos_e * cos_a].map(|at| {
                let [first, last] =
                    [at - reach, at + reach].map(|at| along(0.5 * CELLS as f64 * (at + 1.0)));
                first..=last
            });
            let own = of_planes(of_rows.flatten());
            for cell in cells([&x, &y, &z]) {
                bounds.widen(cell, own);
            }
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::map_direction;
    use crate::trace::bounds::vectors;
    use glam::DMat3;

    #[test]
    fn bounds_change_no_hit() {
        // Surfaces at random, and holes between them: rays pass behind edges everywhere.
        let mut vector = vectors();
        for [width, height] in [[1, 1], [2, 1], [3, 2], [40, 20], [41, 23], [400, 200]] {
            let (turn, center) = (vector(), vector());
            let map_from_world = DMat3::from_rotation_x(turn.x) * DMat3::from_rotation_z(turn.y);
            let points = Vector3Planes::from_fn(width, height, |x, y| {
                let far = vector();
                let toward = map_direction(x, y, width, height) + 0.01 * far;
                let distance = if far.x < -0.8 { 0.0 } else { 3.0 + 0.4 * far.y };
                map_from_world.transpose() * (distance * toward)
            });
            let surroundings = Surroundings {
                center,
                map_from_world,
                points,
                normal: Vector3Planes::from_fn(width, height, |_, _| vector().normalize()),
                normal_rounding: 0.0,
                color: None,
            };
            let map = DistanceMap::new(&surroundings);
            let open = DistanceMap {
                bounds: Bounds::open(CELLS * CELLS * CELLS),
                ..map.clone()
            };
            let mut seen = 0;
            for i in 0..2_000 {
                let axis = [DVec3::X, DVec3::Y, DVec3::Z][i % 3];
                let ray = Ray {
                    start: center + 2.0 * vector(),
                    direction: if i < 30 { axis } else { vector() },
                };
                let search = SearchParams::default();
                let found = map.reached(&ray, &search);
                assert_eq!(
                    found,
                    open.reached(&ray, &search),
                    "{width}x{height}: {ray:?}"
                );
                seen += usize::from(matches!(found, Some(Reached::Seen(..))));
            }
            assert!(width < 40 || seen > 500, "{width}x{height}: {seen}");
        }
    }
}
