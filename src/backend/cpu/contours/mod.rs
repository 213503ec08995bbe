//! Lines along silhouettes and creases: found, joined, and drawn.

mod coverage;
mod creases;
mod ground;
mod silhouettes;

pub(super) use coverage::coverage;

use crate::frame::{Frame, Plane};
use crate::line::contours::{Contour, ContourKind, DepthRange, contour, strength_of_jump};
use crate::line::network::{End, Line, Spot};
use crate::line::polyline::Smoothing;
use crate::params::{ContourParams, ShapeParams};
use ground::Ground;
use rayon::prelude::*;

/// Where edges are.
pub(super) struct Weights<'a> {
    pub(super) silhouette: &'a Plane,
    pub(super) crease: &'a Plane,
}

/// Creases have to be this many times as long as silhouettes to be drawn: a hollow that is darker than its
/// surroundings is seen without a line, and a rough surface is full of short ones.
const CREASE_LENGTHS: f32 = 3.0;

/// The weight that a crease must have somewhere.
const PLAIN_CREASE: f32 = 0.5;

/// Branches of a line with fewer spots than this are remains of thinning, or of noise.
const SHORTEST_BRANCH: usize = 4;

/// The contours of a frame with these edges, silhouettes first. The same for any number of threads.
pub(super) fn contours(
    weights: &Weights,
    frame: &Frame,
    shape: &ShapeParams,
    params: &ContourParams,
) -> Vec<Contour> {
    let mut silhouettes = silhouettes::lines(weights.silhouette, frame, shape, params);
    let plain = strength_of_jump(shape.silhouette.hi);
    drop_short(&mut silhouettes, params.shortest_px, plain);
    let ground = Ground::new(&silhouettes, frame, params);
    ground.join_ends(&mut silhouettes, true);
    let mut creases = Vec::new();
    if params.crease_share > 0.0 {
        creases = creases::lines(weights.crease, &ground, frame, params);
        drop_short(
            &mut creases,
            CREASE_LENGTHS * params.shortest_px,
            PLAIN_CREASE,
        );
        ground.join_ends(&mut creases, false);
    }
    for line in silhouettes.iter_mut().chain(&mut creases) {
        run_off(line, params.width_px);
    }
    let depths = DepthRange::of(silhouettes.iter().chain(&creases));
    let drawn = |lines: &[Line], kind| -> Vec<Contour> {
        lines
            .par_iter()
            .map(|line| contour(line, kind, depths, params))
            .collect()
    };
    let mut contours = drawn(&silhouettes, ContourKind::Silhouette);
    contours.extend(drawn(&creases, ContourKind::Crease));
    contours
}

/// Leads a line that ends at the border of the picture on beyond it, so far that its end is not seen.
fn run_off(line: &mut Line, by_px: f32) {
    for end in (0..2).filter(|&end| !line.closed && line.ends[end] == End::Border) {
        let ahead = line.direction_out(end);
        let index = end * (line.spots.len() - 1);
        let last = line.spots[index];
        let beyond = Spot {
            at: last.at + (by_px + 1.0) * ahead,
            ..last
        };
        line.spots.insert(index + end, beyond);
    }
}

/// How lines are evened out that may lie so far beside the edge.
fn smoothing(params: &ContourParams, tolerance_px: f32) -> Smoothing {
    Smoothing {
        tolerance_px,
        reach: params.smoothing_px as usize,
    }
}

/// Leaves out networks that are shorter in all than `shortest_px`, or nowhere as strong as `plain`: noise.
fn drop_short(lines: &mut Vec<Line>, shortest_px: f32, plain: f32) {
    let mut parts = vec![(0.0, 0.0_f32); lines.len()];
    for line in lines.iter() {
        let (length, plainest) = &mut parts[line.part];
        *length += line.length();
        *plainest = line
            .spots
            .iter()
            .fold(*plainest, |most, spot| most.max(spot.strength));
    }
    lines.retain(|line| {
        let (length, plainest) = parts[line.part];
        length >= shortest_px && plainest >= plain
    });
}
