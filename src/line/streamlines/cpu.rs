//! Strokes as lines over the frame, family by family.

use crate::frame::Plane;
use crate::frame::memory::Memory;
use crate::frame::{Frame, Vector2Planes};
use crate::line::contours::coverage::{DrawnLine, Overlap, coverage};
use crate::line::density::{coverage_at, keep_inside};
use crate::line::direction_field::setting::OPEN;
use crate::line::drawing::Drawn;
use crate::line::hatching::{CROSSED_FROM, share_from};
use crate::line::streamlines::carried::carried_lines;
use crate::line::streamlines::{LaidLine, Streamline, Tool, Wanted, streamlines};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::tone::Densities;
use crate::params::{AtEdges, StrokeParams, Style};
use rayon::prelude::*;

/// Density from which engraved lines are crossed by others: below it the first swell to half of the paper.
const ENGRAVING_CROSSED_FROM: f32 = 0.7;

/// The lines of a family along each field in turn, those of the previous frame of a `sequence` before all others; by
/// family as they are carried on.
pub(crate) fn lines(
    densities: &Densities,
    fields: &[Vector2Planes],
    sequence: Option<SequenceInputs>,
    drawn: &Drawn,
    params: &StrokeParams,
    resolution_factor: f32,
    memory: &Memory,
) -> (Vec<Streamline>, Vec<Vec<LaidLine>>) {
    let frame = drawn.frame;
    let conductance = drawn.conductance.expect("strokes stop at edges");
    let stroke = params.stroke(resolution_factor);
    let tool = Tool::of(&stroke, params.style);
    let carried = carried_lines(sequence, frame, &tool);
    let count = fields.len();
    let onto_edges = params.at_edges == AtEdges::Meet;
    let crossed_from = match params.style {
        Style::Engraving => ENGRAVING_CROSSED_FROM,
        _ => CROSSED_FROM,
    };
    let of_family = |(number, field): (usize, &Vector2Planes)| {
        let wanted = |density| coverage_at(share_from(crossed_from, density, number, count));
        let closed = (!onto_edges).then_some(conductance);
        let ink = inks(densities, closed, wanted, frame, memory);
        let wanted = Wanted {
            ink: &ink,
            conductance: onto_edges.then_some(conductance),
            cancel: memory.cancel(),
        };
        let first = carried.get(number).map_or(&[][..], Vec::as_slice);
        let (mut lines, seeds) = streamlines(field, wanted, &tool, first);
        lines.iter_mut().for_each(|line| line.crosses = number > 0);
        let laid = |(line, seed): (&Streamline, i32)| LaidLine {
            points: line.points.clone(),
            seed,
        };
        let laid = sequence.map(|_| lines.iter().zip(seeds).map(laid).collect());
        (lines, laid.unwrap_or_default())
    };
    let numbered = fields.par_iter().enumerate();
    let (found, laid): (Vec<_>, Vec<_>) = numbered.map(of_family).unzip();
    (found.concat(), laid)
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

/// Coverage of the paper by lines.
pub(crate) fn inked(lines: &[Streamline], frame: &Frame, memory: &Memory) -> Plane {
    let of = |crosses: bool| {
        let drawn = lines.iter().filter(|line| line.crosses == crosses);
        let drawn: Vec<DrawnLine> = drawn
            .map(|line| (&line.points[..], &line.widths[..]))
            .collect();
        coverage(&drawn, Overlap::Beside, &frame.mask, memory)
    };
    let mut covered = of(false);
    if lines.iter().any(|line| line.crosses) {
        let crossing = of(true);
        covered.each_with(&crossing, |ink, crossing| *ink += (1.0 - *ink) * crossing);
        memory.recycle([crossing]);
    }
    keep_inside(&mut covered, &frame.mask);
    covered
}
