//! One function per pass over the frame: rows in parallel, columns that hold no surface skipped.

use super::memory::Memory;
use super::simd::Simd;
use super::{CurvaturePlanes, ROWS_PER_TASK};
use crate::frame::{Mask, Plane, SymmetricPlanes, Vector2Planes};
use crate::shape::Rows;
use crate::shape::curvature::{
    mapped_curvature as kappa, principal_curvatures, principal_direction,
};
use rayon::prelude::*;

/// Trace of the Hessian.
pub(super) fn trace(
    gradient: &Vector2Planes,
    conductance: &Plane,
    mask: &Mask,
    memory: &Memory,
) -> Plane {
    let simd = Simd::widest();
    let [trace] = map_rows(mask, memory, |y, [out]| {
        let [gx, gy, c] = [&gradient.x, &gradient.y, conductance].map(|p| Rows::around(p, y));
        simd.trace_row(out, &gx, &gy, &c, mask.span(y));
    });
    trace
}

/// The whole Hessian.
pub(super) fn hessian(
    gradient: &Vector2Planes,
    conductance: &Plane,
    mask: &Mask,
    memory: &Memory,
) -> SymmetricPlanes {
    let simd = Simd::widest();
    let [xx, xy, yy] = map_rows(mask, memory, |y, out| {
        let [gx, gy, c] = [&gradient.x, &gradient.y, conductance].map(|p| Rows::around(p, y));
        simd.hessian_row(out, &gx, &gy, &c, mask.span(y));
    });
    SymmetricPlanes { xx, xy, yy }
}

/// Trace of a Hessian that is there.
pub(super) fn trace_of(hessian: &SymmetricPlanes, mask: &Mask, memory: &Memory) -> Plane {
    let [trace] = map_covered(mask, memory, |y| {
        let entries = entries(hessian, y);
        move |x| {
            let [xx, _, yy] = entries(x);
            [xx + yy]
        }
    });
    trace
}

/// Principal and mean curvatures.
pub(super) fn curvatures(
    hessian: &SymmetricPlanes,
    mask: &Mask,
    memory: &Memory,
) -> CurvaturePlanes {
    let [u, v, mean] = map_covered(mask, memory, |y| {
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
pub(super) fn directions(hessian: &SymmetricPlanes, mask: &Mask, memory: &Memory) -> Vector2Planes {
    let [x, y] = map_covered(mask, memory, |y| {
        let entries = entries(hessian, y);
        move |x| principal_direction(entries(x))
    });
    Vector2Planes { x, y }
}

/// Mapped curvature.
pub(super) fn mapped_curvature(trace: &Plane, gain: f32, mask: &Mask, memory: &Memory) -> Plane {
    let [mapped] = map_covered(mask, memory, |y| {
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
    memory: &Memory,
    row: impl Fn(usize) -> Sample + Sync,
) -> [Plane; N] {
    map_rows(mask, memory, |y, mut rows| {
        let (covered, sample) = (mask.row(y), row(y));
        for x in mask.span(y).filter(|&x| covered[x]) {
            for (row, value) in rows.iter_mut().zip(sample(x)) {
                row[x] = value;
            }
        }
    })
}

/// Planes whose rows are filled by `fill(y, rows)`, which has to write all that is covered; 0 elsewhere.
pub(super) fn map_rows<const N: usize>(
    mask: &Mask,
    memory: &Memory,
    fill: impl Fn(usize, [&mut [f32]; N]) + Sync,
) -> [Plane; N] {
    let mut planes = [(); N].map(|()| memory.plane(mask));
    rows_of(&mut planes)
        .into_par_iter()
        .enumerate()
        .with_min_len(ROWS_PER_TASK)
        .filter(|(y, _)| !mask.span(*y).is_empty())
        .for_each(|(y, rows)| fill(y, rows));
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
