//! Diffusion of the gradient, by steps or by expansion.

use super::ROWS_PER_TASK;
use crate::frame::{Mask, Plane, Vector2Planes};
use crate::plan::Sweeps;
use crate::shape::Rows;
use crate::shape::conductance::face_conductance_row;
use crate::shape::diffusion::{Faces, sweep_row};
use rayon::prelude::*;

/// The gradient after all sweeps.
pub(super) fn diffusion(
    gradient: Vector2Planes,
    conductance: &Plane,
    mask: &Mask,
    sweeps: &Sweeps,
) -> Vector2Planes {
    let faces = FacePlanes::between(conductance);
    let diffused = |component| match sweeps {
        Sweeps::Explicit { count, time_step } => {
            stepped(component, &faces, mask, *count, *time_step)
        }
        Sweeps::Chebyshev(coefficients) => expanded(component, &faces, mask, coefficients),
    };
    Vector2Planes {
        x: diffused(gradient.x),
        y: diffused(gradient.y),
    }
}

/// Explicit steps: `g + dt Lg`, over and over.
fn stepped(g: Plane, faces: &FacePlanes, mask: &Mask, count: u32, time_step: f32) -> Plane {
    let mut now = g;
    let mut next = now.clone();
    for _ in 0..count {
        sweep(&mut next, &now, faces, mask, None, move |_, g, lg| {
            g + time_step * lg
        });
        std::mem::swap(&mut now, &mut next);
    }
    now
}

/// The sum of a_k T_k(X) g with X = -L/4 - 1, by the recurrence T_k+1 = 2 X T_k - T_k-1.
fn expanded(g: Plane, faces: &FacePlanes, mask: &Mask, coefficients: &[f32]) -> Plane {
    let mut sum = g.map(|v| coefficients[0] * v);
    let mut before = g;
    let mut now = before.clone();
    for (k, &coefficient) in coefficients.iter().enumerate().skip(1) {
        let sum = Some((&mut sum, coefficient));
        if k == 1 {
            sweep(&mut now, &before, faces, mask, sum, |_, g, lg| {
                -0.25 * lg - g
            });
        } else {
            let next = |before, g, lg| -0.5 * lg - 2.0 * g - before;
            sweep(&mut before, &now, faces, mask, sum, next);
            std::mem::swap(&mut now, &mut before);
        }
    }
    sum
}

/// One sweep of the operator over the covered columns of every row; with `sum`, each row is then added
/// to it, scaled, while it is at hand.
fn sweep(
    out: &mut Plane,
    g: &Plane,
    faces: &FacePlanes,
    mask: &Mask,
    sum: Option<(&mut Plane, f32)>,
    combine: impl Fn(f32, f32, f32) -> f32 + Sync,
) {
    let width = g.width();
    let swept = |y: usize, out: &mut [f32]| {
        sweep_row(
            out,
            &Rows::around(g, y),
            &faces.around(y),
            mask.span(y),
            &combine,
        );
    };
    let rows = out.samples_mut().par_chunks_mut(width);
    match sum {
        None => rows
            .enumerate()
            .with_min_len(ROWS_PER_TASK)
            .for_each(|(y, out)| swept(y, out)),
        Some((sum, factor)) => rows
            .zip(sum.samples_mut().par_chunks_mut(width))
            .enumerate()
            .with_min_len(ROWS_PER_TASK)
            .for_each(|(y, (out, sum))| {
                swept(y, out);
                let span = mask.span(y);
                for (sum, value) in sum[span.clone()].iter_mut().zip(&out[span]) {
                    *sum += factor * value;
                }
            }),
    }
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
