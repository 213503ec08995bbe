//! Passes from the gradient to curvature and its directions.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::rows::{map_covered, map_rows};
use crate::engine::cpu::simd::{Simd, widened};
use crate::fast_math::select;
use crate::frame::CurvaturePlanes;
use crate::frame::{Mask, Plane, SymmetricPlanes, Vector2Planes};
use crate::shape::Rows;
use crate::shape::curvature::{
    mapped_curvature as kappa, principal_curvatures, principal_direction,
};
use std::ops::Range;

/// Trace of the Hessian.
pub(crate) fn trace(
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
pub(crate) fn hessian(
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

/// Trace of an existing Hessian.
pub(crate) fn trace_of(hessian: &SymmetricPlanes, mask: &Mask, memory: &Memory) -> Plane {
    let [trace] = map_covered(mask, memory, |y| {
        let [xx, _, yy] = rows(hessian, y);
        move |x| [xx[x] + yy[x]]
    });
    trace
}

/// Principal and mean curvatures.
pub(crate) fn curvatures(
    hessian: &SymmetricPlanes,
    mask: &Mask,
    memory: &Memory,
) -> CurvaturePlanes {
    let simd = Simd::widest();
    let [u, v, mean] = map_rows(mask, memory, |y, out| {
        simd.curvatures_row(out, rows(hessian, y), mask.row(y), mask.span(y));
    });
    CurvaturePlanes { u, v, mean }
}

/// Directions of the larger principal curvature by magnitude.
pub(crate) fn directions(hessian: &SymmetricPlanes, mask: &Mask, memory: &Memory) -> Vector2Planes {
    let simd = Simd::widest();
    let [x, y] = map_rows(mask, memory, |y, out| {
        simd.directions_row(out, rows(hessian, y), mask.row(y), mask.span(y));
    });
    Vector2Planes { x, y }
}

/// Mapped curvature.
pub(crate) fn mapped_curvature(trace: &Plane, gain: f32, mask: &Mask, memory: &Memory) -> Plane {
    let simd = Simd::widest();
    let [mapped] = map_rows(mask, memory, |y, out| {
        simd.mapped_row(out, [trace.row(y)], gain, mask.row(y), mask.span(y));
    });
    mapped
}

/// Row `y` of the entries xx, xy, yy.
fn rows(hessian: &SymmetricPlanes, y: usize) -> [&[f32]; 3] {
    [&hessian.xx, &hessian.xy, &hessian.yy].map(|plane| plane.row(y))
}

#[inline(always)]
fn curvatures_row(
    out: [&mut [f32]; 3],
    hessian: [&[f32]; 3],
    covered: &[bool],
    columns: Range<usize>,
) {
    map_row(out, hessian, covered, columns, |h| {
        let [u, v] = principal_curvatures(h);
        [u, v, 0.5 * (h[0] + h[2])]
    });
}

#[inline(always)]
fn directions_row(
    out: [&mut [f32]; 2],
    hessian: [&[f32]; 3],
    covered: &[bool],
    columns: Range<usize>,
) {
    map_row(out, hessian, covered, columns, principal_direction);
}

#[inline(always)]
fn mapped_row(
    out: [&mut [f32]; 1],
    trace: [&[f32]; 1],
    gain: f32,
    covered: &[bool],
    columns: Range<usize>,
) {
    map_row(out, trace, covered, columns, |[trace]| [kappa(trace, gain)]);
}

widened! {
    fn curvatures_row(
        out: [&mut [f32]; 3],
        hessian: [&[f32]; 3],
        covered: &[bool],
        columns: Range<usize>,
    );
    fn directions_row(
        out: [&mut [f32]; 2],
        hessian: [&[f32]; 3],
        covered: &[bool],
        columns: Range<usize>,
    );
    fn mapped_row(
        out: [&mut [f32]; 1],
        trace: [&[f32]; 1],
        gain: f32,
        covered: &[bool],
        columns: Range<usize>,
    );
}

/// `of` the samples of the pixels of a row in `columns`; 0 where these are not covered.
#[inline(always)]
fn map_row<const N: usize, const M: usize>(
    out: [&mut [f32]; N],
    samples: [&[f32]; M],
    covered: &[bool],
    columns: Range<usize>,
    of: impl Fn([f32; M]) -> [f32; N],
) {
    let count = columns.len();
    let mut out = out.map(|row| &mut row[columns.clone()][..count]);
    let samples = samples.map(|row| &row[columns.clone()][..count]);
    let covered = &covered[columns][..count];
    for i in 0..count {
        let found = of(samples.map(|row| row[i]));
        for (row, value) in out.iter_mut().zip(found) {
            row[i] = select(covered[i], value, 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_their_pixels_where_covered_and_0_elsewhere() {
        let samples = [
            0.3,
            -0.2,
            0.0,
            f32::NAN,
            f32::INFINITY,
            1e-30,
            7.0,
            -0.5,
            2.0,
        ];
        let entry = |shift: usize| (0..40).map(|x| samples[(x * x + shift) % 9]).collect();
        let [xx, xy, yy]: [Vec<f32>; 3] = [0, 3, 7].map(entry);
        let hessian = [&xx[..], &xy, &yy];
        let covered: Vec<bool> = (0..40).map(|x| x % 5 != 2).collect();
        let columns = 3..37;
        let mut found = [(); 6].map(|()| vec![9.0; 40]);
        let [u, v, mean, x, y, mapped] = &mut found;
        let simd = Simd::widest();
        simd.curvatures_row([u, v, mean], hessian, &covered, columns.clone());
        simd.directions_row([x, y], hessian, &covered, columns.clone());
        simd.mapped_row([mapped], [&xy], 2.0, &covered, columns.clone());
        for i in 0..40 {
            let h = [xx[i], xy[i], yy[i]];
            let ([u, v], [x, y]) = (principal_curvatures(h), principal_direction(h));
            let of_pixel = [u, v, 0.5 * (h[0] + h[2]), x, y, kappa(xy[i], 2.0)];
            let expected = match (columns.contains(&i), covered[i]) {
                (true, true) => of_pixel,
                (true, false) => [0.0; 6],
                (false, _) => [9.0; 6],
            };
            for (found, expected) in found.iter().zip(expected) {
                let same = found[i] == expected || found[i].is_nan() && expected.is_nan();
                assert!(same, "{i}: {} and {expected} of {h:?}", found[i]);
            }
        }
    }
}
