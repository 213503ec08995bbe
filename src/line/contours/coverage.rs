//! Coverage of every pixel by contours.

use crate::frame::memory::Memory;
use crate::frame::{Mask, Plane};
use crate::line::contours::Contour;
use crate::line::contours::polyline::{thinned, with_radii};
use crate::line::contours::round_stroke::RoundStroke;
use glam::Vec2;
use rayon::prelude::*;

/// Rows that one task draws.
const ROWS: usize = 16;

/// Largest deviation of a simplified line, in pixels.
const BEND_PX: f32 = 0.03;

/// A line by its points, in pixels, and its width at each.
pub(crate) type DrawnLine<'a> = (&'a [Vec2], &'a [f32]);

/// Combines lines that cover a pixel in part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Overlap {
    /// As the larger one: lines that meet are one.
    Joined,
    /// As their sum: they lie side by side.
    Beside,
}

/// A piece of a line, with the number of the line.
type Piece = (u32, RoundStroke);

/// The coverage of lines along edges or inside surfaces; lines that meet count once.
pub(crate) fn covered(lines: &[Contour], mask: &Mask, memory: &Memory) -> Plane {
    let lines: Vec<DrawnLine> = lines
        .iter()
        .map(|line| (&line.points[..], &line.widths[..]))
        .collect();
    coverage(&lines, Overlap::Joined, mask, memory)
}

/// The share of every pixel that is covered, 0..1, also outside the mask.
pub(crate) fn coverage(
    lines: &[DrawnLine],
    overlap: Overlap,
    mask: &Mask,
    memory: &Memory,
) -> Plane {
    let strokes: Vec<Vec<RoundStroke>> = lines.par_iter().map(strokes).collect();
    let mut bands: Vec<Vec<Piece>> = vec![Vec::new(); mask.height().div_ceil(ROWS)];
    for (line, strokes) in (0..).zip(&strokes) {
        for stroke in strokes {
            let [first, last] = stroke.rows();
            // Casts saturate outside the picture.
            let first = first.floor() as usize / ROWS;
            let last = last.floor().max(-1.0) + 1.0;
            for band in bands
                .iter_mut()
                .take((last as usize).div_ceil(ROWS))
                .skip(first)
            {
                band.push((line, *stroke));
            }
        }
    }
    let width = mask.width();
    let mut covered = memory.unwritten(mask);
    let samples = covered.samples_mut().par_chunks_mut(ROWS * width);
    samples
        .zip(&bands)
        .enumerate()
        .for_each(|(i, (rows, pieces))| {
            rows.fill(0.0);
            let top = (ROWS * i) as f32;
            match overlap {
                Overlap::Joined => cover(rows, width, top, pieces),
                Overlap::Beside => {
                    let mut own = vec![0.0; rows.len()];
                    for line in pieces.chunk_by(|a, b| a.0 == b.0) {
                        cover(&mut own, width, top, line);
                        add(rows, &mut own, width, line);
                    }
                }
            }
        });
    covered
}

/// Covers rows from `top` on by pieces.
fn cover(rows: &mut [f32], width: usize, top: f32, pieces: &[Piece]) {
    for (_, stroke) in pieces {
        let [first, last] = stroke.rows();
        let first = (first - top).floor() as usize;
        for (y, row) in rows.chunks_mut(width).enumerate().skip(first) {
            let middle = top + y as f32 + 0.5;
            if middle > last + 0.5 {
                break;
            }
            stroke.cover(row, middle);
        }
    }
}

/// Adds the coverage of a line, up to the whole pixel, and clears `own`.
fn add(rows: &mut [f32], own: &mut [f32], width: usize, line: &[Piece]) {
    let reach = line.iter().map(|(_, stroke)| stroke.across());
    let all = [f32::INFINITY, f32::NEG_INFINITY];
    let [first, last] = reach.fold(all, |[a, b], [from, to]| [a.min(from), b.max(to)]);
    let columns = first.floor() as usize..((last.ceil().max(0.0)) as usize + 1).min(width);
    for (row, own) in rows.chunks_mut(width).zip(own.chunks_mut(width)) {
        let columns = columns.start.min(width)..columns.end.max(columns.start.min(width));
        for (covered, own) in row[columns.clone()].iter_mut().zip(&mut own[columns]) {
            *covered = (*covered + *own).min(1.0);
            *own = 0.0;
        }
    }
}

/// The pieces for drawing a line: as few as its bends allow, and fewer still for wide lines, so that the time grows
/// only with the covered pixels.
fn strokes(&(points, widths): &DrawnLine) -> Vec<RoundStroke> {
    let widest = widths.iter().fold(0.0_f32, |a, &b| a.max(b));
    let line = with_radii(points, widths);
    let kept = thinned(&line, BEND_PX.max(0.01 * widest), 8 + widest as usize);
    let piece = |from: usize, to: usize| {
        let radius = |i: usize| 0.5 * widths[i];
        RoundStroke::new([points[from], points[to]], [radius(from), radius(to)])
    };
    match kept[..] {
        [only] => vec![piece(only, only)],
        _ => kept
            .windows(2)
            .map(|pair| piece(pair[0], pair[1]))
            .collect(),
    }
}
