//! One function per pass over the frame: rows in parallel, columns that hold no surface skipped.

use super::{CurvaturePlanes, ROWS_PER_TASK};
use crate::frame::{Frame, Mask, Plane, SymmetricPlanes, Vector2Planes};
use crate::params::ShapeParams;
use crate::shape::curvature::{
    mapped_curvature as kappa, principal_curvatures, principal_direction,
};
use crate::shape::gradient::depth_gradient;
use crate::shape::{Rows, hessian as hessian_kernel};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Depth gradient where covered, 0 elsewhere.
pub(super) fn gradient(frame: &Frame, params: &ShapeParams) -> Vector2Planes {
    let normal = &frame.normal;
    let projection = frame.camera.map(|camera| camera.projection);
    let (left, top) = (
        f64::from(frame.data_window.x0),
        f64::from(frame.data_window.y0),
    );
    let [x, y] = map_covered(&frame.mask, |y| {
        let [nx, ny, nz] = [&normal.x, &normal.y, &normal.z].map(|plane| plane.row(y));
        let row = top + y as f64 + 0.5;
        move |x| {
            let to_eye = projection.map_or(Vec2::ZERO, |projection| {
                projection.to_eye(left + x as f64 + 0.5, row).as_vec2()
            });
            depth_gradient(Vec3::new(nx[x], ny[x], nz[x]), to_eye, params).to_array()
        }
    });
    Vector2Planes { x, y }
}

/// Trace of the Hessian.
pub(super) fn trace(gradient: &Vector2Planes, conductance: &Plane, mask: &Mask) -> Plane {
    let [trace] = map_covered(mask, |y| {
        let [gx, gy, c] = [&gradient.x, &gradient.y, conductance].map(|p| Rows::around(p, y));
        move |x| [hessian_kernel::trace(&gx, &gy, &c, x)]
    });
    trace
}

/// The whole Hessian.
pub(super) fn hessian(
    gradient: &Vector2Planes,
    conductance: &Plane,
    mask: &Mask,
) -> SymmetricPlanes {
    let [xx, xy, yy] = map_covered(mask, |y| {
        let [gx, gy, c] = [&gradient.x, &gradient.y, conductance].map(|p| Rows::around(p, y));
        move |x| hessian_kernel::hessian(&gx, &gy, &c, x)
    });
    SymmetricPlanes { xx, xy, yy }
}

/// Principal and mean curvatures.
pub(super) fn curvatures(hessian: &SymmetricPlanes, mask: &Mask) -> CurvaturePlanes {
    let [u, v, mean] = map_covered(mask, |y| {
        let entries = entries(hessian, y);
        move |x| {
            let h = entries(x);
            let [u, v] = principal_curvatures(h);
            [u, v, 0.5 * (h[0] + h[2])]
        }
    });
    CurvaturePlanes { u, v, mean }
}

/// Directions of the curvature larger in size.
pub(super) fn directions(hessian: &SymmetricPlanes, mask: &Mask) -> Vector2Planes {
    let [x, y] = map_covered(mask, |y| {
        let entries = entries(hessian, y);
        move |x| principal_direction(entries(x))
    });
    Vector2Planes { x, y }
}

/// Mapped curvature.
pub(super) fn mapped_curvature(trace: &Plane, gain: f32, mask: &Mask) -> Plane {
    let [mapped] = map_covered(mask, |y| {
        let trace = trace.row(y);
        move |x| [kappa(trace[x], gain)]
    });
    mapped
}

/// The entries [xx, xy, yy] of row `y` by column.
fn entries(hessian: &SymmetricPlanes, y: usize) -> impl Fn(usize) -> [f32; 3] {
    let rows = [&hessian.xx, &hessian.xy, &hessian.yy].map(|plane| plane.row(y));
    move |x| rows.map(|row| row[x])
}

/// Planes of `row(y)(x)` where covered, 0 elsewhere.
pub(super) fn map_covered<const N: usize, Sample: Fn(usize) -> [f32; N]>(
    mask: &Mask,
    row: impl Fn(usize) -> Sample + Sync,
) -> [Plane; N] {
    let (width, height) = (mask.width(), mask.height());
    let mut planes = [(); N].map(|()| Plane::filled(width, height, 0.0));
    rows_of(&mut planes)
        .into_par_iter()
        .enumerate()
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(y, mut rows)| {
            let (covered, sample) = (mask.row(y), row(y));
            for x in mask.span(y).filter(|&x| covered[x]) {
                for (row, value) in rows.iter_mut().zip(sample(x)) {
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
