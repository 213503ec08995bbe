//! Passes from the gradient to curvature and its directions.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::rows::{map_covered, map_rows};
use crate::engine::cpu::simd::Simd;
use crate::frame::CurvaturePlanes;
use crate::frame::{Mask, Plane, SymmetricPlanes, Vector2Planes};
use crate::shape::Rows;
use crate::shape::curvature::{
    mapped_curvature as kappa, principal_curvatures, principal_direction,
};

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
        let entries = entries(hessian, y);
        move |x| {
            let [xx, _, yy] = entries(x);
            [xx + yy]
        }
    });
    trace
}

/// Principal and mean curvatures.
pub(crate) fn curvatures(
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

/// Directions of the larger principal curvature by magnitude.
pub(crate) fn directions(hessian: &SymmetricPlanes, mask: &Mask, memory: &Memory) -> Vector2Planes {
    let [x, y] = map_covered(mask, memory, |y| {
        let entries = entries(hessian, y);
        move |x| principal_direction(entries(x))
    });
    Vector2Planes { x, y }
}

/// Mapped curvature.
pub(crate) fn mapped_curvature(trace: &Plane, gain: f32, mask: &Mask, memory: &Memory) -> Plane {
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
