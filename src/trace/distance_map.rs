//! A distance map as a surface for ray hits.

use super::search::{Crossing, first_crossing, steps_for};
use super::texels::{Reached, Sides, TangentPlane, Texel, agreed, around, heaviest, mean_at};
use crate::frame::{ColorPlanes, Ray, Surroundings, Vector3Planes};
use crate::params::SearchParams;
use glam::DVec3;

/// The surroundings of an object, for world-space rays.
#[derive(Debug, Clone)]
pub(crate) struct DistanceMap<'a> {
    surroundings: &'a Surroundings,
    /// Tangent planes relative to the centre, row-major.
    planes: Vec<TangentPlane>,
}

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
        Self {
            surroundings,
            planes: (0..width * height).map(plane).collect(),
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
        let steps = steps_for(search, turn / std::f64::consts::PI);
        let crossing = first_crossing(steps, search.refinements, |s| {
            let (direction, distance) = place(s);
            let (surface, ..) = self.distance_toward(direction)?;
            // At the end of the turn the ray is at infinity.
            Some(1.0 - (distance / surface).min(FAR_BEHIND))
        });
        match crossing {
            Crossing::Hit(s) => {
                let (direction, distance) = place(s);
                let point = center + distance * direction;
                Some(Reached::Seen(point, point))
            }
            Crossing::Unseen(s) => {
                let (direction, distance) = place(s);
                let texel = heaviest(&self.texels(direction));
                let plane = &self.planes[texel.y * self.surroundings.width() + texel.x];
                let about_center = Ray {
                    start: from,
                    direction: ahead,
                };
                let point = plane.continued(&about_center, distance * direction)?;
                let shown = self.surroundings.point_at(texel.x, texel.y);
                Some(Reached::Beyond(center + point, center + shown))
            }
            Crossing::Nothing => None,
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
        let own = |t: &Texel| field.at(t.x, t.y);
        let mut sense = DVec3::ZERO;
        for t in self.texels(point - self.surroundings.center) {
            let here = own(&t);
            if t.weight * here.length_squared() > sense.length_squared() {
                sense = t.weight.sqrt() * here;
            }
        }
        let alike = |t: &Texel| {
            let here = own(t);
            if here.dot(sense) < 0.0 { -here } else { here }
        };
        self.mean_at(point, alike)
            .filter(|mean| mean.length_squared() > 0.0)
    }

    #[inline]
    fn mean_at(&self, point: DVec3, value: impl Fn(&Texel) -> DVec3) -> Option<DVec3> {
        let toward = point - self.surroundings.center;
        let (_, distances, texels) = self.distance_toward(toward.try_normalize()?)?;
        mean_at(toward.length(), distances, &texels, value)
    }

    #[inline]
    fn texels(&self, direction: DVec3) -> [Texel; 4] {
        let map = self.surroundings;
        let size = [map.width(), map.height()];
        around(map.position(direction), size, Sides::Wraps)
    }

    /// The distance of the surroundings in a unit direction, and the distance by each texel around it.
    #[inline]
    fn distance_toward(&self, direction: DVec3) -> Option<(f64, [Option<f64>; 4], [Texel; 4])> {
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
