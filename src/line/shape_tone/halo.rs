//! Halos: paper left bare behind the rim of an object in front, so that it stands out.

use crate::frame::gap::scale::GapScale;
use crate::frame::{DepthKind, Frame, Plane};
use crate::line::background::Backdrop;
use crate::params::SoftThreshold;
use rayon::prelude::*;

/// The width of a halo of factor 1, as a share of the picture's size, the root of its area.
const WIDTH: f32 = 1.0 / 350.0;

/// How many times steeper than at a pixel its own surface may get within the reach of a halo.
const STEEPER: f32 = 1.5;

/// The weight from which a pixel is the rim of an object.
const RIM: f32 = 0.5;

/// Sets densities to 0 within a halo of this `factor` of the rim of an object in front of them: nearer by the gap that
/// makes a silhouette. Where a subject stands on its `background` there is none.
pub(super) fn leave_bare(
    densities: &mut Plane,
    frame: &Frame,
    silhouette: &Plane,
    (threshold, factor): (SoftThreshold, f32),
    background: Option<&Backdrop>,
) {
    let size = frame.display_window.size_px();
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
            for (x, least) in span.zip(&*column) {
                // NaN depth is behind nothing.
                let behind = share * depth.at(x, y) - less;
                let stands = || background.is_some_and(|planes| planes.is_contact([x, y]));
                if *least < behind
                    && is_behind_rim(frame, depth, silhouette, [x, y], (reach, behind))
                    && !stands()
                {
                    row[x] = 0.0;
                }
            }
        },
    );
}

/// Whether a rim within `reach` of a pixel is nearer than `behind`, and than the pixel's own surface goes on to be: where that
/// is steep, as on the rim of a ball, parts of it in front are no other surface.
fn is_behind_rim(
    frame: &Frame,
    depth: &Plane,
    silhouette: &Plane,
    [x, y]: [usize; 2],
    (reach, behind): (usize, f32),
) -> bool {
    let slope = own_slope(frame, depth, [x, y]).map(|slope| STEEPER * slope);
    let rows = y.saturating_sub(reach)..(y + reach + 1).min(depth.height());
    let columns = x.saturating_sub(reach)..(x + reach + 1).min(depth.width());
    rows.flat_map(|v| columns.clone().map(move |u| [u, v]))
        .any(|[u, v]| {
            let [across, down] = [u.abs_diff(x), v.abs_diff(y)];
            let goes_on = slope[0] * across as f32 + slope[1] * down as f32;
            // A disc to half a pixel: halos are as wide along diagonals.
            across * across + down * down <= reach * (reach + 1)
                && silhouette.at(u, v) >= RIM
                && depth.at(u, v) < behind - goes_on
        })
}

/// How steeply the depth of a pixel's own surface changes per column and per row: the lesser of the differences on both
/// sides, of which that across a gap is the greater one; 0 at a crest, and where there are none.
fn own_slope(frame: &Frame, depth: &Plane, [x, y]: [usize; 2]) -> [f32; 2] {
    let here = depth.at(x, y);
    let beside = |u: Option<usize>, v: Option<usize>| {
        let (u, v) = (
            u.filter(|&u| u < depth.width())?,
            v.filter(|&v| v < depth.height())?,
        );
        let there = depth.at(u, v);
        (frame.mask.at(u, v) && there.is_finite()).then_some(there)
    };
    let lesser = |before: Option<f32>, after: Option<f32>| {
        let [before, after] = [before.map(|d| here - d), after.map(|d| d - here)];
        let (a, b) = (
            before.or(after).unwrap_or(0.0),
            after.or(before).unwrap_or(0.0),
        );
        if a * b > 0.0 {
            a.abs().min(b.abs())
        } else {
            0.0
        }
    };
    let (left, above) = (x.checked_sub(1), y.checked_sub(1));
    [
        lesser(beside(left, Some(y)), beside(Some(x + 1), Some(y))),
        lesser(beside(Some(x), above), beside(Some(x), Some(y + 1))),
    ]
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
