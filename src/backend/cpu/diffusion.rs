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
        sweep(&mut next, &now, faces, mask, |_, g, lg| g + time_step * lg);
        std::mem::swap(&mut now, &mut next);
    }
    now
}

/// The sum of a_k T_k(X) g with X = -L/4 - 1, by the recurrence T_k+1 = 2 X T_k - T_k-1.
fn expanded(g: Plane, faces: &FacePlanes, mask: &Mask, coefficients: &[f32]) -> Plane {
    let mut sum = g.map(|v| coefficients[0] * v);
    let Some(&first) = coefficients.get(1) else {
        return sum;
    };
    let mut before = g;
    let mut now = before.clone();
    sweep(&mut now, &before, faces, mask, |_, g, lg| -0.25 * lg - g);
    add_scaled(&mut sum, &now, first, mask);
    for &coefficient in &coefficients[2..] {
        sweep(&mut before, &now, faces, mask, |before, g, lg| {
            -0.5 * lg - 2.0 * g - before
        });
        std::mem::swap(&mut now, &mut before);
        add_scaled(&mut sum, &now, coefficient, mask);
    }
    sum
}

/// One sweep of the operator over the covered columns of every row.
fn sweep(
    out: &mut Plane,
    g: &Plane,
    faces: &FacePlanes,
    mask: &Mask,
    combine: impl Fn(f32, f32, f32) -> f32 + Sync,
) {
    let width = g.width();
    let rows = out.samples_mut().par_chunks_mut(width).enumerate();
    rows.with_min_len(ROWS_PER_TASK).for_each(|(y, out)| {
        sweep_row(
            out,
            &Rows::around(g, y),
            &faces.around(y),
            mask.span(y),
            &combine,
        );
    });
}

fn add_scaled(sum: &mut Plane, plane: &Plane, factor: f32, mask: &Mask) {
    let width = plane.width();
    let rows = sum.samples_mut().par_chunks_mut(width).enumerate();
    rows.with_min_len(ROWS_PER_TASK).for_each(|(y, sum)| {
        let span = mask.span(y);
        for (sum, value) in sum[span.clone()].iter_mut().zip(&plane.row(y)[span]) {
            *sum += factor * value;
        }
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
