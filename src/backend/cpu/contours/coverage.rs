//! How much of every pixel contours cover.

use crate::backend::cpu::memory::Memory;
use crate::frame::{Mask, Plane};
use crate::line::contours::Contour;
use crate::line::contours::polyline::thinned;
use crate::line::contours::round_stroke::RoundStroke;
use rayon::prelude::*;

/// Rows that one task draws.
const ROWS: usize = 16;

/// How far a drawn line may leave out a bend, in pixels.
const BEND_PX: f32 = 0.03;

/// The share of every pixel that is covered, 0..1, also outside the mask.
pub(in crate::backend::cpu) fn coverage(
    contours: &[Contour],
    mask: &Mask,
    memory: &Memory,
) -> Plane {
    let strokes: Vec<Vec<RoundStroke>> = contours.par_iter().map(strokes).collect();
    let mut bands = vec![Vec::new(); mask.height().div_ceil(ROWS)];
    for stroke in strokes.iter().flatten() {
        let [first, last] = stroke.rows();
        // Casts of what lies outside saturate.
        let first = first.floor() as usize / ROWS;
        let last = last.floor().max(-1.0) + 1.0;
        for band in bands
            .iter_mut()
            .take((last as usize).div_ceil(ROWS))
            .skip(first)
        {
            band.push(*stroke);
        }
    }
    let mut covered = memory.unwritten(mask);
    let samples = covered.samples_mut().par_chunks_mut(ROWS * mask.width());
    samples
        .zip(&bands)
        .enumerate()
        .for_each(|(i, (rows, strokes))| {
            rows.fill(0.0);
            for stroke in strokes {
                let [first, last] = stroke.rows();
                let top = (ROWS * i) as f32;
                let first = (first - top).floor() as usize;
                for (y, row) in rows.chunks_mut(mask.width()).enumerate().skip(first) {
                    let middle = top + y as f32 + 0.5;
                    if middle > last + 0.5 {
                        break;
                    }
                    stroke.cover(row, middle);
                }
            }
        });
    covered
}

/// The pieces that a contour is drawn in: as few as its bends allow, and for wide lines fewer still, so that
/// the time it takes grows with the pixels covered alone.
fn strokes(contour: &Contour) -> Vec<RoundStroke> {
    let widest = contour.widths.iter().fold(0.0_f32, |a, &b| a.max(b));
    let kept = thinned(
        &contour.points,
        BEND_PX.max(0.01 * widest),
        8 + widest as usize,
    );
    let piece = |from: usize, to: usize| {
        let radius = |i: usize| 0.5 * contour.widths[i];
        RoundStroke::new(
            [contour.points[from], contour.points[to]],
            [radius(from), radius(to)],
        )
    };
    match kept[..] {
        [only] => vec![piece(only, only)],
        _ => kept
            .windows(2)
            .map(|pair| piece(pair[0], pair[1]))
            .collect(),
    }
}
