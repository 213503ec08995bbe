//! One function per pass over the frame: rows in parallel, columns that hold no surface skipped.

use super::{CurvaturePlanes, ROWS_PER_TASK};
use crate::frame::{Frame, Mask, Plane, SymmetricPlanes, Vector2Planes};
use crate::params::ShapeParams;
use crate::shape::conductance::face_conductance_row;
use crate::shape::curvature::{
    mapped_curvature as kappa, principal_curvatures, principal_direction,
};
use crate::shape::diffusion::{Faces, diffuse_row};
use crate::shape::gradient::depth_gradient;
use crate::shape::{Rows, hessian as hessian_kernel};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Depth gradient where covered, 0 elsewhere.
pub(super) fn gradient(frame: &Frame, params: &ShapeParams) -> Vector2Planes {
    let normal = &frame.normal;
    let projection = frame.camera.map(|camera| camera.projection);
    let [x, y] = map_covered(&frame.mask, |x, y| {
        let n = Vec3::new(normal.x.at(x, y), normal.y.at(x, y), normal.z.at(x, y));
        let to_eye = projection.map_or(Vec2::ZERO, |projection| {
            let column = f64::from(frame.data_window.x0) + x as f64 + 0.5;
            let row = f64::from(frame.data_window.y0) + y as f64 + 0.5;
            projection.to_eye(column, row).as_vec2()
        });
        depth_gradient(n, to_eye, params).to_array()
    });
    Vector2Planes { x, y }
}

/// The gradient after all explicit steps.
pub(super) fn diffusion(
    gradient: Vector2Planes,
    conductance: &Plane,
    mask: &Mask,
    params: &ShapeParams,
) -> Vector2Planes {
    let faces = FacePlanes::between(conductance);
    let mut now = gradient;
    let mut next = now.clone();
    for _ in 0..params.iterations {
        for (now, next) in [(&now.x, &mut next.x), (&now.y, &mut next.y)] {
            diffuse_step(now, next, &faces, mask, params.time_step);
        }
        std::mem::swap(&mut now, &mut next);
    }
    now
}

fn diffuse_step(now: &Plane, next: &mut Plane, faces: &FacePlanes, mask: &Mask, time_step: f32) {
    next.samples_mut()
        .par_chunks_mut(now.width())
        .enumerate()
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(y, out)| {
            let row = Rows::around(now, y);
            diffuse_row(out, &row, &faces.around(y), time_step, mask.span(y));
        });
}

/// Conductances of all faces between pixels: `left` has a column more than the picture, `above` a
/// row more; the faces around the picture are closed.
struct FacePlanes {
    left: Plane,
    above: Plane,
}

impl FacePlanes {
    fn between(conductance: &Plane) -> Self {
        let (width, height) = (conductance.width(), conductance.height());
        let mut left = Plane::filled(width + 1, height, 0.0);
        let mut above = Plane::filled(width, height + 1, 0.0);
        left.samples_mut()
            .par_chunks_mut(width + 1)
            .enumerate()
            .for_each(|(y, out)| {
                let row = conductance.row(y);
                face_conductance_row(&mut out[1..width], row, &row[1..]);
            });
        above.samples_mut()[width..width * height]
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, out)| {
                face_conductance_row(out, conductance.row(y), conductance.row(y + 1))
            });
        Self { left, above }
    }

    fn around(&self, y: usize) -> Faces<'_> {
        Faces {
            left: self.left.row(y),
            above: self.above.row(y),
            below: self.above.row(y + 1),
        }
    }
}

/// Trace of the Hessian.
pub(super) fn trace(gradient: &Vector2Planes, conductance: &Plane, mask: &Mask) -> Plane {
    let [trace] = map_covered(mask, |x, y| {
        let [gx, gy, c] = [&gradient.x, &gradient.y, conductance].map(|p| Rows::around(p, y));
        [hessian_kernel::trace(&gx, &gy, &c, x)]
    });
    trace
}

/// The whole Hessian.
pub(super) fn hessian(
    gradient: &Vector2Planes,
    conductance: &Plane,
    mask: &Mask,
) -> SymmetricPlanes {
    let [xx, xy, yy] = map_covered(mask, |x, y| {
        let [gx, gy, c] = [&gradient.x, &gradient.y, conductance].map(|p| Rows::around(p, y));
        hessian_kernel::hessian(&gx, &gy, &c, x)
    });
    SymmetricPlanes { xx, xy, yy }
}

/// Principal and mean curvatures.
pub(super) fn curvatures(h: &SymmetricPlanes, mask: &Mask) -> CurvaturePlanes {
    let [u, v, mean] = map_covered(mask, |x, y| {
        let [u, v] = principal_curvatures(entries(h, x, y));
        [u, v, 0.5 * (h.xx.at(x, y) + h.yy.at(x, y))]
    });
    CurvaturePlanes { u, v, mean }
}

/// Directions of the curvature larger in size.
pub(super) fn directions(h: &SymmetricPlanes, mask: &Mask) -> Vector2Planes {
    let [x, y] = map_covered(mask, |x, y| principal_direction(entries(h, x, y)));
    Vector2Planes { x, y }
}

/// Mapped curvature.
pub(super) fn mapped_curvature(trace: &Plane, gain: f32, mask: &Mask) -> Plane {
    let [mapped] = map_covered(mask, |x, y| [kappa(trace.at(x, y), gain)]);
    mapped
}

fn entries(h: &SymmetricPlanes, x: usize, y: usize) -> [f32; 3] {
    [h.xx.at(x, y), h.xy.at(x, y), h.yy.at(x, y)]
}

/// Planes of `sample(x, y)` where covered, 0 elsewhere.
pub(super) fn map_covered<const N: usize>(
    mask: &Mask,
    sample: impl Fn(usize, usize) -> [f32; N] + Sync,
) -> [Plane; N] {
    let (width, height) = (mask.width(), mask.height());
    let mut planes = [(); N].map(|()| Plane::filled(width, height, 0.0));
    rows_of(&mut planes)
        .into_par_iter()
        .enumerate()
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(y, mut rows)| {
            let covered = mask.row(y);
            for x in mask.span(y).filter(|&x| covered[x]) {
                for (row, value) in rows.iter_mut().zip(sample(x, y)) {
                    row[x] = value;
                }
            }
        });
    planes
}

/// The rows of several planes of one size, gathered by row.
fn rows_of<const N: usize>(planes: &mut [Plane; N]) -> Vec<[&mut [f32]; N]> {
    let width = planes[0].width();
    let mut rows = planes
        .each_mut()
        .map(|plane| plane.samples_mut().chunks_mut(width));
    let height = rows[0].len();
    (0..height)
        .map(|_| {
            rows.each_mut()
                .map(|r| r.next().expect("planes of one size"))
        })
        .collect()
}
