//! Passes from the gradient to curvature and its directions.

use crate::frame::memory::Memory;
use crate::frame::rows::{map_covered, map_rows};
use crate::frame::{Mask, Plane, SymmetricPlanes, Vector2Planes};
use crate::kernel::fast_math::select;
use crate::kernel::simd::wide;
use crate::shape::Rows;
use crate::shape::curvature::{
    mapped_curvature as kappa, principal_curvatures, principal_direction,
};
use crate::shape::hessian;
use std::ops::Range;

/// Trace of the Hessian.
pub(crate) fn trace(
    gradient: &Vector2Planes,
    conductance: &Plane,
    mask: &Mask,
    memory: &Memory,
) -> Plane {
    let [trace] = map_rows(mask, memory, |y, [out]| {
        let [gx, gy, c] = [&gradient.x, &gradient.y, conductance].map(|p| Rows::around(p, y));
        wide!(hessian::trace_row(out, &gx, &gy, &c, mask.span(y)));
    });
    trace
}

/// The Hessian, times `factor`; with six planes also the curvatures u, v and mean, and with eight the direction of the larger
/// one by magnitude too.
pub(crate) fn described<const N: usize>(
    gradient: &Vector2Planes,
    conductance: &Plane,
    factor: f32,
    mask: &Mask,
    memory: &Memory,
) -> [Plane; N] {
    map_rows(mask, memory, |y, mut out| {
        let [gx, gy, c] = [&gradient.x, &gradient.y, conductance].map(|p| Rows::around(p, y));
        let (part, covered) = (mask.span(y), mask.row(y));
        let mut rows = out.iter_mut();
        let mut next = || &mut **rows.next().expect("a plane for each");
        let hessian = [next(), next(), next()];
        wide!(hessian::hessian_row(hessian, &gx, &gy, &c, part.clone()));
        let mut rows = out.iter_mut().map(|row| &mut row[part.clone()]);
        let mut next = || rows.next().expect("a plane for each");
        let mut hessian = [next(), next(), next()];
        if factor != 1.0 {
            wide!(scale_rows(&mut hessian, factor));
        }
        let hessian = hessian.map(|row| &*row);
        let covered = &covered[part.clone()];
        if N > 3 {
            let curvatures = [next(), next(), next()];
            wide!(curvatures_row(curvatures, hessian, covered));
        }
        if N > 6 {
            wide!(directions_row([next(), next()], hessian, covered));
        }
    })
}

/// Trace of an existing Hessian.
pub(crate) fn trace_of(hessian: &SymmetricPlanes, mask: &Mask, memory: &Memory) -> Plane {
    let [trace] = map_covered(mask, memory, |y| {
        let [xx, yy] = [&hessian.xx, &hessian.yy].map(|plane| plane.row(y));
        move |x| [xx[x] + yy[x]]
    });
    trace
}

/// Mapped curvature.
pub(crate) fn mapped_curvature(trace: &Plane, gain: f32, mask: &Mask, memory: &Memory) -> Plane {
    let [mapped] = map_rows(mask, memory, |y, out| {
        let part = mask.span(y);
        let trace = &trace.row(y)[part.clone()];
        wide!(mapped_row(cut(out, &part), trace, gain, &mask.row(y)[part]));
    });
    mapped
}

/// Derivatives per pixel of the reference.
#[inline(always)]
fn scale_rows(rows: &mut [&mut [f32]; 3], factor: f32) {
    for row in rows {
        row.iter_mut().for_each(|v| *v *= factor);
    }
}

/// That part of rows.
fn cut<'a, const N: usize>(rows: [&'a mut [f32]; N], part: &Range<usize>) -> [&'a mut [f32]; N] {
    rows.map(|row| &mut row[part.clone()])
}

#[inline(always)]
pub(crate) fn curvatures_row(out: [&mut [f32]; 3], hessian: [&[f32]; 3], covered: &[bool]) {
    map_row(out, hessian, covered, |h| {
        let [u, v] = principal_curvatures(h);
        [u, v, 0.5 * (h[0] + h[2])]
    });
}

#[inline(always)]
pub(crate) fn directions_row(out: [&mut [f32]; 2], hessian: [&[f32]; 3], covered: &[bool]) {
    map_row(out, hessian, covered, principal_direction);
}

#[inline(always)]
pub(crate) fn mapped_row(out: [&mut [f32]; 1], trace: &[f32], gain: f32, covered: &[bool]) {
    map_row(out, [trace], covered, |[trace]| [kappa(trace, gain)]);
}

/// `of` the samples of each covered pixel of a row; 0 for the others.
#[inline(always)]
fn map_row<const N: usize, const M: usize>(
    out: [&mut [f32]; N],
    samples: [&[f32]; M],
    covered: &[bool],
    of: impl Fn([f32; M]) -> [f32; N],
) {
    let count = covered.len();
    let mut out = out.map(|row| &mut row[..count]);
    let samples = samples.map(|row| &row[..count]);
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
        let mut found = [(); 6].map(|()| vec![9.0; 40]);
        let [u, v, mean, x, y, mapped] = &mut found;
        wide!(curvatures_row([u, v, mean], hessian, &covered));
        wide!(directions_row([x, y], hessian, &covered));
        wide!(mapped_row([mapped], &xy, 2.0, &covered));
        for i in 0..40 {
            let h = [xx[i], xy[i], yy[i]];
            let ([u, v], [x, y]) = (principal_curvatures(h), principal_direction(h));
            let of_pixel = [u, v, 0.5 * (h[0] + h[2]), x, y, kappa(xy[i], 2.0)];
            let expected = if covered[i] { of_pixel } else { [0.0; 6] };
            for (found, expected) in found.iter().zip(expected) {
                let same = found[i] == expected || found[i].is_nan() && expected.is_nan();
                assert!(same, "{i}: {} and {expected} of {h:?}", found[i]);
            }
        }
    }
}
