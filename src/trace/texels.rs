//! The four texels around a position on a map, each representing the tangent plane of its surface.

use crate::frame::Ray;
use glam::{DVec2, DVec3, Vec3};

/// A texel and its bilinear weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct TexelShare {
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) weight: f64,
}

/// Extension of a map beyond its sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BeyondSides {
    /// The nearest texel is repeated.
    Ends,
    /// The opposite side follows.
    Wraps,
}

/// The texels around the position `at`, in pixels from the upper left corner of a map; all weights are 0 for a
/// non-finite position.
#[inline]
pub(super) fn around(
    at: DVec2,
    [width, height]: [usize; 2],
    sides: BeyondSides,
) -> [TexelShare; 4] {
    let corner = at - 0.5;
    let (left, top) = (corner.x.floor(), corner.y.floor());
    let (across, down) = (corner.x - left, corner.y - top);
    let column = |x: f64| match sides {
        BeyondSides::Ends => x.clamp(0.0, (width - 1) as f64) as usize,
        // Positions are on the map: one turn is enough, and a division is slow.
        BeyondSides::Wraps if x < 0.0 => width - 1,
        BeyondSides::Wraps if x as usize >= width => 0,
        BeyondSides::Wraps => x as usize,
    };
    let row = |y: f64| y.clamp(0.0, (height - 1) as f64) as usize;
    let texel = |x: f64, y: f64, weight: f64| TexelShare {
        x: column(x),
        y: row(y),
        weight: if weight >= 0.0 { weight } else { 0.0 },
    };
    [
        texel(left, top, (1.0 - across) * (1.0 - down)),
        texel(left + 1.0, top, across * (1.0 - down)),
        texel(left, top + 1.0, (1.0 - across) * down),
        texel(left + 1.0, top + 1.0, across * down),
    ]
}

/// The texel with the largest weight.
pub(super) fn heaviest(texels: &[TexelShare; 4]) -> TexelShare {
    let heavier = |a: TexelShare, b: &TexelShare| if b.weight > a.weight { *b } else { a };
    texels.iter().fold(texels[0], heavier)
}

/// Distances with a larger relative difference belong to different surfaces.
pub(super) const APART: f64 = 0.02;

/// A tangent plane is not used for distances beyond this factor of its own point's.
const FARTHEST: f64 = 1.25;

/// End of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Reached<P> {
    /// Visible, on the surface: the point, and the position on the map that shows it.
    Seen(DVec3, P),
    /// Unseen, on the extended plane of the surface shown at this position.
    Beyond(DVec3, P),
}

/// Maximum extension of a plane, as a multiple of the distance over which it was seen.
const GOES_ON: f64 = 4.0;

/// The tangent plane of the surface in a texel.
#[derive(Debug, Clone, Copy)]
pub(super) struct TangentPlane {
    normal: [f32; 3],
    /// The plane's distance from the origin along the normal.
    offset: f32,
    /// Distance of the texel's own point along its line; 0 without a surface.
    own: f32,
}

impl TangentPlane {
    /// No surface.
    pub(super) const NONE: Self = Self {
        normal: [0.0; 3],
        offset: 0.0,
        own: 0.0,
    };

    /// The plane through a `point`, which is `own` along its line.
    pub(super) fn new(point: DVec3, normal: DVec3, own: f64) -> Self {
        Self {
            normal: normal.as_vec3().to_array(),
            offset: normal.dot(point) as f32,
            own: own as f32,
        }
    }

    /// The least and the largest distance that [`Self::along`] gives for any line; `None` without a surface.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        let own = f64::from(self.own);
        (own > 0.0).then_some([own / FARTHEST, own * FARTHEST])
    }

    /// How far along a `line` from `start` the extended plane is; not finite without a surface or if both are parallel.
    #[inline(always)]
    pub(super) fn crossed(&self, start: DVec3, line: DVec3) -> f64 {
        let normal = Vec3::from(self.normal).as_dvec3();
        (f64::from(self.offset) - normal.dot(start)) / normal.dot(line)
    }

    /// Where a ray hits the extended plane, no nearer than `seen` and within its maximum extension; `None` without a
    /// surface.
    pub(super) fn continued(&self, ray: &Ray, seen: DVec3) -> Option<DVec3> {
        let along = self.crossed(ray.start, ray.direction);
        let point = ray.start + along * ray.direction;
        let (way, so_far) = (point.distance(ray.start), seen.distance(ray.start));
        let goes_on = self.own > 0.0 && along > 0.0 && way >= so_far;
        (goes_on && way < GOES_ON * so_far.max(f64::from(self.own))).then_some(point)
    }

    /// The distance along a `line` from `start` to the plane; the texel's own distance if the line is too nearly
    /// parallel to the plane. `None` without a surface.
    #[inline(always)]
    pub(super) fn along(&self, start: DVec3, line: DVec3) -> Option<f64> {
        let (met, own) = (self.crossed(start, line), f64::from(self.own));
        let is_near = FARTHEST * met > own && met < FARTHEST * own;
        (own > 0.0).then_some(if is_near { met } else { own })
    }
}

/// One distance from those of the texels around a position: their mean if they agree, else that of the nearest texel.
/// `None` if none has one.
#[inline]
pub(super) fn agreed(distances: [Option<f64>; 4], texels: &[TexelShare; 4]) -> Option<f64> {
    let (mut sum, mut weights, mut heaviest) = (0.0, 0.0, (0.0, 0.0));
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for (distance, texel) in distances.into_iter().zip(texels) {
        let Some(distance) = distance else { continue };
        (least, most) = (least.min(distance), most.max(distance));
        sum += texel.weight * distance;
        weights += texel.weight;
        if texel.weight > heaviest.0 {
            heaviest = (texel.weight, distance);
        }
    }
    if weights <= 0.0 {
        return None;
    }
    let agree = most <= least * (1.0 + APART);
    Some(if agree { sum / weights } else { heaviest.1 })
}

/// The mean over texels whose planes lie at `distance`; the value of the heaviest texel if none does. `None` without
/// values.
#[inline]
pub(super) fn mean_at(
    distance: f64,
    distances: [Option<f64>; 4],
    texels: &[TexelShare; 4],
    value: impl Fn(&TexelShare) -> DVec3,
) -> Option<DVec3> {
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    let mut heaviest: Option<&TexelShare> = None;
    for (own, texel) in distances.into_iter().zip(texels) {
        let Some(own) = own else { continue };
        if heaviest.is_none_or(|other| texel.weight > other.weight) {
            heaviest = Some(texel);
        }
        if (own / distance - 1.0).abs() < APART && texel.weight > 0.0 {
            sum += texel.weight * value(texel);
            weights += texel.weight;
        }
    }
    match weights > 0.0 {
        true => Some(sum / weights),
        false => heaviest.map(value),
    }
}
