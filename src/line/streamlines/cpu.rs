//! Strokes as lines over the frame, family by family.

use crate::frame::Plane;
use crate::frame::{Frame, Vector2Planes};
use crate::kernel::memory::Memory;
use crate::line::carried::Carrier;
use crate::line::contours::coverage::{DrawnLine, Overlap, coverage};
use crate::line::density::coverage_at;
use crate::line::direction_field::setting::OPEN;
use crate::line::hatching::{CROSSED_FROM, share_from};
use crate::line::streamlines::{Seed, Streamline, Streamlines, Tool, Wanted, streamlines};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::tone::Densities;
use crate::params::{AtEdges, StrokeParams, Style};
use rayon::prelude::*;

/// Density from which engraved lines are crossed by others: below it the first swell to half of the paper.
const ENGRAVING_CROSSED_FROM: f32 = 0.7;

/// A family of lines: the field they follow, and the seeds placed before all others.
pub(crate) struct Family<'a> {
    pub(crate) field: &'a Vector2Planes,
    pub(crate) first: &'a [Seed],
}

impl<'a> Family<'a> {
    /// The families along these fields, with the first seeds of each, if any.
    pub(crate) fn all(fields: &'a [Vector2Planes], first: &'a [Vec<Seed>]) -> Vec<Self> {
        let first = first
            .iter()
            .map(Vec::as_slice)
            .chain(std::iter::repeat(&[][..]));
        let families = fields.iter().zip(first);
        families
            .map(|(field, first)| Self { field, first })
            .collect()
    }
}

/// The lines of every family in turn, and their seeds by family.
pub(crate) fn lines(
    densities: &Densities,
    families: &[Family],
    conductance: &Plane,
    params: &StrokeParams,
    resolution_factor: f32,
    frame: &Frame,
    memory: &Memory,
) -> (Vec<Streamline>, Vec<Vec<Seed>>) {
    let stroke = params.stroke(resolution_factor);
    let tool = Tool::of(&stroke, params.style);
    let count = families.len();
    let onto_edges = params.at_edges == AtEdges::Meet;
    let crossed_from = match params.style {
        Style::Engraving => ENGRAVING_CROSSED_FROM,
        _ => CROSSED_FROM,
    };
    let of_family = |(number, family): (usize, &Family)| {
        let wanted = |density| coverage_at(share_from(crossed_from, density, number, count));
        let closed = (!onto_edges).then_some(conductance);
        let ink = inks(densities, closed, wanted, frame, memory);
        let wanted = Wanted {
            ink: &ink,
            conductance: onto_edges.then_some(conductance),
            cancel: memory.cancel(),
        };
        let Family { field, first } = *family;
        let Streamlines { mut lines, seeds } = streamlines(field, wanted, &tool, first);
        lines.iter_mut().for_each(|line| line.crosses = number > 0);
        (lines, seeds)
    };
    let numbered = families.par_iter().enumerate();
    let (found, seeds): (Vec<_>, Vec<_>) = numbered.map(of_family).unzip();
    (found.concat(), seeds)
}

/// Seeds of the previous frame's lines, by family, where they are visible in this one.
pub(crate) fn carried_seeds(sequence: Option<SequenceInputs>, frame: &Frame) -> Vec<Vec<Seed>> {
    let Some((before, carrier)) = Carrier::of(sequence, frame) else {
        return Vec::new();
    };
    let of_family = |seeds: &Vec<Seed>| {
        let here = |seed: &Seed| {
            let at = carrier.carried(seed.at)?;
            Some(Seed { at, ..*seed })
        };
        seeds.iter().filter_map(here).collect()
    };
    before.seeds.iter().map(of_family).collect()
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
        lay_over(&mut covered, &crossing);
        memory.recycle([crossing]);
    }
    // Ink beyond a silhouette is under its line.
    covered.each_row(|y, row| {
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

/// Lays ink over ink: each covers its share of the white left by the other.
fn lay_over(covered: &mut Plane, crossing: &Plane) {
    let samples = covered.samples_mut().par_iter_mut();
    samples
        .zip(crossing.samples())
        .for_each(|(ink, crossing)| *ink += (1.0 - *ink) * crossing);
}
