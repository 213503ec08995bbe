//! Strokes as lines over the frame, family by family.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::rows::map_rows;
use crate::engine::cpu::simd::Simd;
use crate::frame::Plane;
use crate::frame::{Frame, Vector2Planes};
use crate::line::contours::coverage::{DrawnLine, Overlap, coverage};
use crate::line::direction_field::setting::OPEN;
use crate::line::hatching::{BATCH, share};
use crate::line::streamlines::{Nib, Streamline, streamlines};
use crate::line::tone::Densities;
use crate::params::StrokeParams;
use rayon::prelude::*;

/// The lines of every family in turn.
pub(crate) fn lines(
    densities: &Densities,
    directions: &[Vector2Planes],
    conductance: &Plane,
    params: &StrokeParams,
    resolution_factor: f32,
    frame: &Frame,
    memory: &Memory,
) -> Vec<Streamline> {
    let stroke = params.stroke(resolution_factor);
    let nib = Nib::of(&stroke);
    let families = directions.len();
    let of_family = |(family, field): (usize, &Vector2Planes)| {
        let wanted = |density| 1.0 - (-share(density, family, families)).exp();
        streamlines(
            field,
            &inks(densities, conductance, wanted, frame, memory),
            &nib,
        )
    };
    let found: Vec<_> = directions.par_iter().enumerate().map(of_family).collect();
    found.concat()
}

/// The ink that lines are to cover; 0 where none may pass.
fn inks(
    densities: &Densities,
    conductance: &Plane,
    wanted: impl Fn(f32) -> f32 + Sync,
    frame: &Frame,
    memory: &Memory,
) -> Plane {
    let simd = Simd::widest();
    let [ink] = map_rows(&frame.mask, memory, |y, [out]| {
        for run in frame.mask.runs(y) {
            for from in run.clone().step_by(BATCH) {
                let columns = from..(from + BATCH).min(run.end);
                densities.row(&mut out[columns.clone()], y, columns.clone(), simd);
                let open = &conductance.row(y)[columns.clone()];
                for (ink, &open) in out[columns].iter_mut().zip(open) {
                    *ink = if open > OPEN { wanted(*ink) } else { 0.0 };
                }
            }
        }
    });
    ink
}

/// How much of the paper the lines cover.
pub(crate) fn inked(lines: &[Streamline], frame: &Frame, memory: &Memory) -> Plane {
    let drawn: Vec<DrawnLine> = lines.iter().map(DrawnLine::from).collect();
    let mut covered = coverage(&drawn, Overlap::Beside, &frame.mask, memory);
    // Ink beyond a silhouette lies under its line.
    let width = covered.width();
    let rows = covered.samples_mut().par_chunks_mut(width);
    rows.enumerate().for_each(|(y, row)| {
        let covered = frame.mask.plane().row(y);
        for (ink, _) in row
            .iter_mut()
            .zip(covered)
            .filter(|(_, covered)| !**covered)
        {
            *ink = 0.0;
        }
    });
    covered
}
