//! Strokes as lines over the frame, family by family.

use crate::engine::cpu::memory::Memory;
use crate::frame::Plane;
use crate::frame::{Frame, Vector2Planes};
use crate::line::contours::coverage::{DrawnLine, Overlap, coverage};
use crate::line::density::coverage_at;
use crate::line::direction_field::setting::OPEN;
use crate::line::hatching::{CROSSED_FROM, share_from};
use crate::line::streamlines::{Streamline, Tool, Wanted, streamlines};
use crate::line::tone::Densities;
use crate::params::{StrokeParams, Style};
use rayon::prelude::*;

/// Density from which on engraved lines are crossed by others: the first swell to half of the paper before.
const ENGRAVING_CROSSED_FROM: f32 = 0.7;

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
    let tool = Tool::of(&stroke, params.style);
    let families = directions.len();
    let onto_edges = params.style == Style::Engraving;
    let crossed_from = match onto_edges {
        true => ENGRAVING_CROSSED_FROM,
        false => CROSSED_FROM,
    };
    let of_family = |(family, field): (usize, &Vector2Planes)| {
        let wanted = |density| coverage_at(share_from(crossed_from, density, family, families));
        let closed = (!onto_edges).then_some(conductance);
        let ink = inks(densities, closed, wanted, frame, memory);
        let wanted = Wanted {
            ink: &ink,
            conductance: onto_edges.then_some(conductance),
        };
        let mut lines = streamlines(field, wanted, &tool);
        lines.iter_mut().for_each(|line| line.crosses = family > 0);
        lines
    };
    let found: Vec<_> = directions.par_iter().enumerate().map(of_family).collect();
    found.concat()
}

/// The ink that lines are to cover; 0 on edges that are `closed` to them, by their conductance.
fn inks(
    densities: &Densities,
    closed: Option<&Plane>,
    wanted: impl Fn(f32) -> f32 + Sync,
    frame: &Frame,
    memory: &Memory,
) -> Plane {
    let wanted = &wanted;
    densities.mapped(frame, memory, |y| {
        let closed = closed.map(|conductance| conductance.row(y));
        move |x, density| match closed {
            Some(row) if row[x] > OPEN => wanted(density),
            Some(_) => 0.0,
            None => wanted(density),
        }
    })
}

/// How much of the paper lines of this style cover.
pub(crate) fn inked(lines: &[Streamline], style: Style, frame: &Frame, memory: &Memory) -> Plane {
    let of = |wanted: &dyn Fn(&Streamline) -> bool| {
        let drawn = lines.iter().filter(|line| wanted(line));
        let drawn: Vec<DrawnLine> = drawn.map(DrawnLine::from).collect();
        coverage(&drawn, Overlap::Beside, &frame.mask, memory)
    };
    let mut covered = match style {
        Style::Engraving => {
            let mut covered = of(&|line| !line.crosses);
            let crossing = of(&|line| line.crosses);
            lay_over(&mut covered, &crossing);
            memory.recycle([crossing]);
            covered
        }
        _ => of(&|_| true),
    };
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

/// Lays ink over ink: each covers its share of what the other leaves white.
fn lay_over(covered: &mut Plane, crossing: &Plane) {
    let samples = covered.samples_mut().par_iter_mut();
    samples
        .zip(crossing.samples())
        .for_each(|(ink, crossing)| *ink += (1.0 - *ink) * crossing);
}
