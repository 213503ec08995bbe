//! Directions of curvature on the surroundings, texel by texel.

use crate::frame::{Plane, Surroundings, Vector3Planes, parallel_rows};
use crate::kernel::simd::wide;
use crate::line::normal_rays::{LocalShape, Noise, NormalRay, Sides, principal_curvatures};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// The directions on the surroundings of the last run, since a sequence has the same ones throughout.
#[derive(Debug, Default)]
pub(crate) struct DirectionCache(Mutex<Option<(Arc<Surroundings>, Arc<Vector3Planes>)>>);

impl DirectionCache {
    /// The directions on these surroundings, computed unless cached.
    pub(crate) fn of(&self, surroundings: &Arc<Surroundings>) -> Arc<Vector3Planes> {
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of, directions)) = kept().as_ref()
            && Arc::ptr_eq(of, surroundings)
        {
            return directions.clone();
        }
        // Not under the lock: while it waits for others, this thread may take up another run that asks for it too.
        let directions = Arc::new(directions(surroundings));
        *kept() = Some((surroundings.clone(), directions.clone()));
        directions
    }
}

/// Largest sine of the angle between the step from one texel to another and the tangent plane, by the mean of their
/// normals, for both to lie on one surface.
const OFF_SURFACE: f64 = 0.2;

/// Cosine of the angle between the normals of two texels on one surface.
const ALIKE: f64 = 0.5;

/// Rounding of an f32 of size 1, as a deviation.
const ROUNDING: f64 = 0.577 * f32::EPSILON as f64 / 2.0;

/// Texels that are looked at together.
pub(crate) const LANES: usize = 32;

/// Unit tangents of the curvature larger in size; 0 on planes, on balls and where nothing is.
fn directions(surroundings: &Surroundings) -> Vector3Planes {
    let (width, height) = (surroundings.width(), surroundings.height());
    let normal_noise = f64::from(surroundings.normal_rounding).max(ROUNDING);
    let [mut x, mut y, mut z] = [(); 3].map(|()| Plane::filled(width, height, 0.0));
    parallel_rows([&mut x, &mut y, &mut z]).for_each(|(row, [x, y, z])| {
        let [above, own, below] = [row.checked_sub(1), Some(row), Some(row + 1)]
            .map(|row| RowOfMap::new(surroundings, row));
        let mut found = LargerTangents::default();
        for from in (0..width).step_by(LANES) {
            let bundle = Bundle {
                here: own.lanes(from, 0),
                beside: [
                    [own.lanes(from, -1), own.lanes(from, 1)],
                    [below.lanes(from, 0), above.lanes(from, 0)],
                ],
            };
            wide!(larger_curvature_tangents(&mut found, &bundle, normal_noise));
            let to = (from + LANES).min(width);
            for (row, found) in [&mut *x, &mut *y, &mut *z]
                .into_iter()
                .zip(&found.components)
            {
                row[from..to].copy_from_slice(&found[..to - from]);
            }
        }
    });
    Vector3Planes { x, y, z }
}

/// A row of the map. Beyond both ends it goes on around the map, and then there is nothing.
struct RowOfMap {
    /// The components of points, from the centre, and of normals.
    components: [Vec<f32>; 6],
    is_there: Vec<u8>,
}

impl RowOfMap {
    /// The row, or one of nothing.
    fn new(map: &Surroundings, row: Option<usize>) -> Self {
        let width = map.width();
        let row = row.filter(|&row| row < map.height());
        let (p, n) = (&map.points, &map.normal);
        let components = [&p.x, &p.y, &p.z, &n.x, &n.y, &n.z].map(|plane| {
            let mut around = vec![0.0; width.next_multiple_of(LANES) + 2];
            if let Some(row) = row {
                let own = plane.row(row);
                around[1..=width].copy_from_slice(own);
                (around[0], around[width + 1]) = (own[width - 1], own[0]);
            }
            around
        });
        let is_some =
            |x: usize, vector: Range<usize>| components[vector].iter().any(|c| c[x] != 0.0);
        let is_there = |x| u8::from(is_some(x, 0..3) && is_some(x, 3..6));
        Self {
            is_there: (0..components[0].len()).map(is_there).collect(),
            components,
        }
    }

    /// The texels from one on, moved aside by -1 to 1.
    fn lanes(&self, from: usize, aside: isize) -> Lanes {
        let first = (from + 1).wrapping_add_signed(aside);
        let mut lanes = Lanes {
            components: [[0.0; LANES]; 6],
            is_there: [0; LANES],
        };
        for (lanes, row) in lanes.components.iter_mut().zip(&self.components) {
            lanes.copy_from_slice(&row[first..][..LANES]);
        }
        lanes
            .is_there
            .copy_from_slice(&self.is_there[first..][..LANES]);
        lanes
    }
}

/// Texels of a row of the map, one in each lane.
pub(crate) struct Lanes {
    /// The components of points, from the centre, and of normals.
    pub(crate) components: [[f32; LANES]; 6],
    /// 1 for a texel with a surface, 0 for none.
    pub(crate) is_there: [u8; LANES],
}

/// Texels with those beside each: left and right, below and above.
pub(crate) struct Bundle {
    pub(crate) here: Lanes,
    pub(crate) beside: [[Lanes; 2]; 2],
}

/// A tangent in each lane, or 0.
#[derive(Default)]
pub(crate) struct LargerTangents {
    pub(crate) components: [[f32; LANES]; 3],
    pub(crate) forms: [LocalShape; LANES],
}

impl Lanes {
    /// The point and the normal of a texel.
    #[inline(always)]
    fn at(&self, lane: usize) -> (DVec3, DVec3) {
        let [px, py, pz, nx, ny, nz] = &self.components;
        let vector = |x: f32, y: f32, z: f32| DVec3::new(x.into(), y.into(), z.into());
        (
            vector(px[lane], py[lane], pz[lane]),
            vector(nx[lane], ny[lane], nz[lane]),
        )
    }

    /// The normal ray in a lane, seen from `here`, if both are on the same surface.
    #[inline(always)]
    fn ray(&self, lane: usize, here: (DVec3, DVec3)) -> NormalRay {
        let there = self.at(lane);
        let offset = there.0 - here.0;
        let both = here.1 + there.1;
        let goes_on = (both.dot(offset).abs() < OFF_SURFACE * both.length() * offset.length())
            & (here.1.dot(there.1) > ALIKE);
        NormalRay {
            is_there: goes_on & (self.is_there[lane] != 0),
            offset,
            normal: there.1,
        }
    }
}

/// Tangents of the larger curvature at all lanes. Flags are bytes and forms are kept: else the loop has branches, and stays
/// scalar.
#[inline(always)]
pub(crate) fn larger_curvature_tangents(
    out: &mut LargerTangents,
    bundle: &Bundle,
    normal_noise: f64,
) {
    for lane in 0..LANES {
        let here = bundle.here.at(lane);
        let sides = |[before, after]: &[Lanes; 2]| Sides {
            before: before.ray(lane, here),
            after: after.ray(lane, here),
            step_px: 1.0,
        };
        let [across, up] = &bundle.beside;
        let noise = Noise {
            normal: normal_noise,
            offset: ROUNDING * here.0.length(),
        };
        let found = principal_curvatures(here.1, [sides(across), sides(up)], noise);
        let is_known = found.form.has_direction() & (bundle.here.is_there[lane] != 0);
        let [x, y, z] = found.directions[0].to_array();
        out.components[0][lane] = if is_known { x as f32 } else { 0.0 };
        out.components[1][lane] = if is_known { y as f32 } else { 0.0 };
        out.components[2][lane] = if is_known { z as f32 } else { 0.0 };
        out.forms[lane] = found.form;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::map_direction;
    use glam::DMat3;

    #[test]
    fn a_tube_around_the_viewer_bends_around_its_axis() {
        // From inside a tube of radius 2 along y, with the normal toward the axis: the curvature larger in magnitude
        // runs around it, perpendicular to y.
        let (width, height) = (64, 32);
        let toward = |x, y| map_direction(x, y, width, height);
        let normal = |x, y| -DVec3::new(toward(x, y).x, 0.0, toward(x, y).z).normalize();
        // Distance 2 / cos(elevation).
        let point = |x, y| toward(x, y) * 2.0 / toward(x, y).x.hypot(toward(x, y).z);
        let planes = |at: &dyn Fn(usize, usize) -> DVec3| {
            let plane = |k: usize| Plane::from_fn(width, height, |x, y| at(x, y)[k] as f32);
            Vector3Planes {
                x: plane(0),
                y: plane(1),
                z: plane(2),
            }
        };
        let map = Surroundings {
            center: DVec3::ZERO,
            map_from_world: DMat3::IDENTITY,
            points: planes(&point),
            normal: planes(&normal),
            normal_rounding: 0.0,
            color: None,
        };
        let found = directions(&map);
        for (x, y) in [(0, 16), (63, 16), (20, 8), (40, 22)] {
            let n = normal(x, y);
            let around = DVec3::new(n.z, 0.0, -n.x);
            let t = DVec3::new(
                found.x.at(x, y).into(),
                found.y.at(x, y).into(),
                found.z.at(x, y).into(),
            );
            assert!((t.dot(around).abs() - 1.0).abs() < 1e-6, "{x} {y}: {t}");
        }
    }
}
