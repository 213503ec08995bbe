//! Halos: paper left bare behind the rim of an object in front, so that it stands out.

use crate::frame::{DepthKind, Frame, Plane};
use rayon::prelude::*;

/// The width of a halo of factor 1, as a share of the picture's size, the root of its area.
const WIDTH: f32 = 1.0 / 350.0;

/// An occluder is nearer than this share of a pixel's depth.
const BEFORE: f32 = 0.965;

/// Sets densities to 0 within a halo of this `factor` of an object in front of them.
pub(super) fn leave_bare(densities: &mut Plane, frame: &Frame, factor: f32) {
    let window = frame.display_window;
    let size = ((window.width() * window.height()) as f32).sqrt();
    let reach = (factor * WIDTH * size).round() as usize;
    let measured = frame.depth.as_ref();
    let measured = measured.filter(|_| frame.source.depth_kind != DepthKind::Relative);
    let Some(depth) = measured.filter(|_| reach > 0) else {
        return;
    };
    let nearest = nearest_across(frame, depth, reach);
    let width = depth.width();
    let rows = densities.samples_mut().par_chunks_mut(width).enumerate();
    rows.for_each_init(
        || vec![0.0; width],
        |column, (y, row)| {
            let span = frame.mask.span(y);
            let column = &mut column[span.clone()];
            column.copy_from_slice(&nearest.row(y)[span.clone()]);
            for other in y.saturating_sub(reach)..(y + reach + 1).min(depth.height()) {
                keep_least(column, &nearest.row(other)[span.clone()]);
            }
            let depths = &depth.row(y)[span.clone()];
            for ((density, least), depth) in row[span].iter_mut().zip(&*column).zip(depths) {
                // NaN depth is behind nothing.
                if *least < BEFORE * depth {
                    *density = 0.0;
                }
            }
        },
    );
}

/// Replaces samples by others that are less; NaN is not.
fn keep_least(samples: &mut [f32], others: &[f32]) {
    for (least, &other) in samples.iter_mut().zip(others) {
        // Unlike `f32::min` one instruction, as only `other` may be NaN.
        *least = if other < *least { other } else { *least };
    }
}

/// The least depth within this reach along rows; infinite where nothing is covered.
fn nearest_across(frame: &Frame, depth: &Plane, reach: usize) -> Plane {
    let (width, height) = (depth.width(), depth.height());
    let mut nearest = Plane::filled(width, height, f32::INFINITY);
    let rows = nearest.samples_mut().par_chunks_mut(width).enumerate();
    rows.for_each_init(
        || vec![0.0; width + 2 * reach],
        |beyond, (y, row)| {
            // The row with its uncovered samples and those beyond its ends at infinity.
            beyond.fill(f32::INFINITY);
            for run in frame.mask.runs(y) {
                beyond[reach..][run.clone()].copy_from_slice(&depth.row(y)[run]);
            }
            let span = frame.mask.span(y);
            let near = span.start.saturating_sub(reach)..(span.end + reach).min(width);
            for shift in 0..=2 * reach {
                keep_least(&mut row[near.clone()], &beyond[shift..][near.clone()]);
            }
        },
    );
    nearest
}
