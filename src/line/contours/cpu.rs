//! Lines along silhouettes and creases and between objects: found, joined, and drawn.

use crate::frame::Frame;
use crate::line::background::Backdrop;
use crate::line::contours::behind::Occluders;
use crate::line::contours::gaps::close_gaps;
use crate::line::contours::ground::{Ground, Onward};
use crate::line::contours::network::{End, Line, Spot};
use crate::line::contours::{Contour, ContourKind, DepthRange, contour, strength_of_gap};
use crate::line::contours::{creases, objects, silhouettes};
use crate::line::drawing::Drawn;
use crate::params::{ContourParams, ObjectLines, ShapeParams};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Widest gap in a line that is closed, in pixels, and in those of the frame before it was enlarged.
const GAP_PX: f32 = 8.0;
const GAP_STEPS: f32 = 3.0;

/// Distance at which a silhouette ends at one that is not straight ahead, in pixels.
const ASIDE_PX: f32 = 3.0;

/// Smallest cosine of the angle between a line's direction and a silhouette that it is led to.
const AHEAD: f32 = 0.4;

/// Length of the shortest line for each pixel that one of the frame grew by as it was enlarged: shorter ones are remains of
/// pixels.
const SHORTEST: f32 = 3.0;

/// Silhouettes this many times as long as the shortest are drawn however faint: noise makes short ones.
const LONG: f32 = 4.0;

/// Borders between objects are drawn from this many times the length of other lines on.
const OBJECT_LENGTHS: f32 = 2.0;

/// The weight that a crease must have somewhere.
const PLAIN_CREASE: f32 = 0.5;

/// The contours of a frame with these edges: silhouettes, then creases, then borders between objects. Independent of the number of threads.
pub(crate) fn contours(
    drawn: &Drawn,
    background: Option<&Backdrop>,
    shape: &ShapeParams,
    params: &ContourParams,
) -> Vec<Contour> {
    let frame = drawn.frame;
    let shortest_px = params.shortest_px.max(SHORTEST * (params.step_px - 1.0));
    let gap_px = GAP_PX.max(GAP_STEPS * params.step_px);
    let there = "contours are planned with their weights";
    let [silhouette, crease] = [drawn.silhouette, drawn.crease].map(|w| w.expect(there));
    let mut silhouettes = silhouettes::lines(silhouette, frame, shape, params);
    close_gaps(&mut silhouettes, gap_px, None);
    let least = Least {
        length_px: shortest_px,
        strength: strength_of_gap(shape.silhouette.hi),
        long_px: LONG * shortest_px,
        by_strength: false,
    };
    drop_short(&mut silhouettes, least);
    let ground = Ground::new(&silhouettes, frame, params);
    let onward = Onward {
        ahead: gap_px,
        aside: ASIDE_PX,
        straight: AHEAD,
        are_own: true,
    };
    ground.join_ends(&mut silhouettes, onward);
    let mut creases = Vec::new();
    if params.has_creases() {
        creases = creases::lines([crease, silhouette], &ground, frame, params);
        close_gaps(&mut creases, gap_px, Some(&ground));
        let occluders = Occluders {
            outlines: &ground,
            frame,
            factor: 1.0,
            unit_px: 1.0,
        };
        occluders.unite(&mut creases);
        let least = Least {
            length_px: shortest_px,
            strength: PLAIN_CREASE,
            long_px: f32::INFINITY,
            by_strength: true,
        };
        drop_short(&mut creases, least);
        if let Some(background) = background {
            background.leave_blank(&mut creases, |line: &Line| line, 1.0);
        }
        // Joins silhouettes that fade into creases.
        let count = silhouettes.len();
        silhouettes.append(&mut creases);
        for (i, line) in silhouettes.iter_mut().enumerate() {
            line.part = i;
        }
        close_gaps(&mut silhouettes, gap_px, Some(&ground));
        creases = silhouettes.split_off(count);
        let onto_silhouettes = Onward {
            aside: ground.beside_px(),
            are_own: false,
            ..onward
        };
        ground.join_ends(&mut creases, onto_silhouettes);
        let onto_creases = Onward {
            aside: 0.0,
            ..onward
        };
        Ground::new(&creases, frame, params).join_ends(&mut creases, onto_creases);
    }
    let mut borders = between_objects(silhouettes.iter().chain(&creases), frame, params);
    for line in silhouettes
        .iter_mut()
        .chain(&mut creases)
        .chain(&mut borders)
    {
        run_off(line, params.width_px);
    }
    let depths = DepthRange::of(silhouettes.iter().chain(&creases).chain(&borders));
    let drawn = |lines: &[Line], kind| -> Vec<Contour> {
        lines
            .par_iter()
            .map(|line| contour(line, kind, depths, params))
            .collect()
    };
    let mut contours = drawn(&silhouettes, ContourKind::Silhouette);
    contours.extend(drawn(&creases, ContourKind::Crease));
    contours.extend(drawn(&borders, ContourKind::Object));
    contours
}

/// The lines between objects where none of the `drawn` ones runs, which they end at.
fn between_objects<'a>(
    drawn: impl Iterator<Item = &'a Line>,
    frame: &Frame,
    params: &ContourParams,
) -> Vec<Line> {
    let numbers = frame.objects.as_ref();
    let Some(numbers) = numbers.filter(|_| params.object_lines == ObjectLines::Auto) else {
        return Vec::new();
    };
    let ground = Ground::new(drawn, frame, params);
    let mut lines = objects::lines(numbers, &ground, frame, params);
    close_gaps(&mut lines, GAP_PX, Some(&ground));
    let least = Least {
        length_px: OBJECT_LENGTHS * params.shortest_px,
        strength: 0.0,
        long_px: 0.0,
        by_strength: false,
    };
    drop_short(&mut lines, least);
    let onto_drawn = Onward {
        ahead: GAP_PX,
        aside: ground.beside_px(),
        straight: AHEAD,
        are_own: false,
    };
    ground.join_ends(&mut lines, onto_drawn);
    lines
}

/// Distance from the picture's border within which the end of a line counts as continuing beyond it.
const ROOM_PX: f32 = 3.0;

/// Extends a line that ends at the border of the picture beyond it, so far that its end is not visible.
fn run_off(line: &mut Line, by_px: f32) {
    for end in (0..2).filter(|&end| !line.closed && line.ends[end] == End::Border) {
        let ahead = line.direction_out(end);
        let index = end * (line.spots.len() - 1);
        let last = line.spots[index];
        let beyond = Spot {
            at: last.at + (by_px + ROOM_PX) * ahead,
            ..last
        };
        line.spots.insert(index + end, beyond);
    }
}

/// Requirements of lines that are drawn.
struct Least {
    /// Length of a network in all, and twice that of a branch that ends in the open.
    length_px: f32,
    /// Strength that a network has somewhere, unless it is long.
    strength: f32,
    /// Length from which on it may be faint.
    long_px: f32,
    /// Whether lengths are weighted by strength: a rough surface is full of blunt creases.
    by_strength: bool,
}

/// Drops noise: lines that are too short or nowhere strong.
fn drop_short(lines: &mut Vec<Line>, least: Least) {
    let is_twig = |line: &Line| {
        let twig = [[End::Free, End::Joined], [End::Joined, End::Free]];
        !line.closed && twig.contains(&line.ends) && line.length() < 0.5 * least.length_px
    };
    lines.retain(|line| !is_twig(line));
    let mut parts: BTreeMap<usize, (f32, f32)> = BTreeMap::new();
    for line in lines.iter() {
        let (length, strongest) = parts.entry(line.part).or_default();
        let strength = line.strength();
        *length += line.length() * if least.by_strength { strength } else { 1.0 };
        *strongest = line
            .spots
            .iter()
            .fold(*strongest, |most, spot| most.max(spot.strength));
    }
    lines.retain(|line| {
        let (length, strongest) = parts[&line.part];
        length >= least.length_px && (strongest >= least.strength || length >= least.long_px)
    });
}
