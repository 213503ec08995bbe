//! Halos: paper left bare behind the rim of an object in front, so that it stands out.

use crate::frame::{DepthKind, Frame, Plane};
use crate::params::SoftThreshold;
use crate::shape::gap::scale::GapScale;
use rayon::prelude::*;

/// The width of a halo of factor 1, as a share of the picture's size, the root of its area.
const WIDTH: f32 = 1.0 / 350.0;

/// The weight from which a pixel is the rim of an object.
const RIM: f32 = 0.5;

/// Sets densities to 0 within a halo of this `factor` of the rim of an object in front of them: nearer by the gap that
/// makes a silhouette.
pub(super) fn leave_bare(
    densities: &mut Plane,
    frame: &Frame,
    silhouette: &Plane,
    (threshold, factor): (SoftThreshold, f32),
) {
    let window = frame.display_window;
    let size = ((window.width() * window.height()) as f32).sqrt();
    let reach = (factor * WIDTH * size).round() as usize;
    let measured = frame.depth.as_ref();
    let measured = measured.filter(|_| frame.source.depth_kind != DepthKind::Relative);
    let Some(depth) = measured.filter(|_| reach > 0) else {
        return;
    };
    let nearest = nearest_across(silhouette, depth, reach);
    let [share, less] = GapScale::of(frame, threshold).before();
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
                if *least < share * depth - less {
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

/// The least depth of rims within this reach along rows; infinite where there is none.
fn nearest_across(silhouette: &Plane, depth: &Plane, reach: usize) -> Plane {
    let (width, height) = (depth.width(), depth.height());
    let mut nearest = Plane::filled(width, height, f32::INFINITY);
    let rows = nearest.samples_mut().par_chunks_mut(width).enumerate();
    rows.for_each_init(
        || vec![0.0; width + 2 * reach],
        |beyond, (y, row)| {
            let rims = silhouette.row(y).iter().map(|&weight| weight >= RIM);
            if !rims.clone().any(|is_rim| is_rim) {
                return;
            }
            // The row with all else, and samples beyond its ends, at infinity.
            beyond.fill(f32::INFINITY);
            let samples = beyond[reach..].iter_mut().zip(depth.row(y)).zip(rims);
            for ((sample, &depth), _) in samples.filter(|(_, is_rim)| *is_rim) {
                *sample = depth;
            }
            for shift in 0..=2 * reach {
                keep_least(row, &beyond[shift..][..width]);
            }
        },
    );
    nearest
}
