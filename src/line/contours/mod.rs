//! Contours: silhouettes, creases and borders between objects as lines whose width shows depth.
//!
//! Theory: [LA] section 6 draws silhouettes and creases last, over the hatching, by an enhancement of edges per pixel.
//! Changes: they are lines with a position, a length and a width, as a draughtsman's are: one to an edge, heavier
//! around near objects and before a distant background. Where one line meets the side of another it ends there; one that
//! passes behind something ends at its outline on both sides, and counts as one line. Practice: `crack` and `ridge`
//! locate edges, `network` makes lines of them, `gaps`, `ground` and `behind` join these, and `round_stroke` computes a
//! line's coverage.

pub(crate) mod behind;
pub(crate) mod coverage;
pub(crate) mod cpu;
pub(crate) mod cracks;
pub(crate) mod creases;
pub(crate) mod ground;
pub(crate) mod medium;
pub(crate) mod objects;
pub(crate) mod silhouettes;
pub(crate) mod stage;

pub(crate) mod crack;
pub(crate) mod gaps;
pub(crate) mod lattice;
pub(crate) mod network;
pub(crate) mod polyline;
pub(crate) mod ridge;
pub(crate) mod round_stroke;
pub(crate) mod smoothing;
mod straight;

use crate::frame::Frame;
use crate::kernel::fast_math::ln;
use crate::line::contours::network::{End, Line};
use crate::line::contours::polyline::{evened, lengths};
use crate::params::ContourParams;
pub use crate::plan::drawing::{Contour, ContourKind};
use glam::Vec2;

/// Range of the depths of lines, to tell near from far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DepthRange {
    /// Logarithm of the smallest depth.
    pub near: f32,
    /// Logarithm of the largest depth.
    pub far: f32,
}

/// Logarithm of the ratio of depths over which lines lose as much width as they may: over less they lose less,
/// so that a flat thing has lines of one width.
const DEEP: f32 = 0.4;

impl DepthRange {
    /// The range of all lines.
    pub(crate) fn of<'a>(lines: impl IntoIterator<Item = &'a Line>) -> Self {
        let depths = lines
            .into_iter()
            .flat_map(|line| &line.spots)
            .map(|spot| spot.log_depth);
        let range = depths.fold([f32::INFINITY, f32::NEG_INFINITY], |[near, far], depth| {
            [near.min(depth), far.max(depth)]
        });
        Self {
            near: range[0],
            far: range[1],
        }
    }

    /// Relative distance, 0 for the nearest to 1 for the farthest.
    pub(crate) fn farness(&self, log_depth: f32) -> f32 {
        ((log_depth - self.near) / (self.far - self.near).max(DEEP)).clamp(0.0, 1.0)
    }
}

/// Logarithm of the depth of a covered point of the picture, if it is known.
pub(crate) fn log_depth(frame: &Frame, at: Vec2) -> Option<f32> {
    let [x, y] = frame.mask.plane().pixel_at(at);
    let known = frame.mask.at(x, y).then_some(y * frame.mask.width() + x);
    log_depth_of(frame, known?)
}

/// Logarithm of the depth of a pixel, named by its number, if it is known.
fn log_depth_of(frame: &Frame, pixel: usize) -> Option<f32> {
    let depth = frame.depth.as_ref()?.samples()[pixel];
    Some(ln(depth)).filter(|log| log.is_finite())
}

/// Spots to either side over which widths change.
const WIDTH_REACH: usize = 8;

/// Share of its width that an open end runs down to.
const TIP: f32 = 0.25;

/// The contour along a line.
pub(crate) fn contour(
    line: &Line,
    kind: ContourKind,
    depths: DepthRange,
    params: &ContourParams,
) -> Contour {
    let share = match kind {
        ContourKind::Crease => params.crease_share,
        _ => 1.0,
    };
    let widths = line.spots.iter().map(|spot| {
        let near = 1.0 - params.depth_emphasis * depths.farness(spot.log_depth);
        let plain = 1.0 - params.jump_emphasis * (1.0 - spot.strength);
        params.width_px * share * near * plain
    });
    tapered(
        line,
        kind,
        widths.collect(),
        WIDTH_REACH,
        |from_end, whole| {
            // A short line has two thin ends and a full middle.
            let over = params.taper_px.min(0.5 * whole);
            match over > 0.0 {
                true => TIP + (1.0 - TIP) * (from_end / over).min(1.0),
                false => 1.0,
            }
        },
    )
}

/// A line with these widths, evened over `reach` spots to either side, whose open ends have the part `taper` of theirs: by
/// the length from the end, and that of the whole.
pub(crate) fn tapered(
    line: &Line,
    kind: ContourKind,
    widths: Vec<f32>,
    reach: usize,
    taper: impl Fn(f32, f32) -> f32,
) -> Contour {
    let (mut points, mut widths) = (line.points(), evened(&widths, line.closed, reach));
    if line.closed {
        points.push(points[0]);
        widths.push(widths[0]);
    } else {
        let along = lengths(&points);
        let whole = along[along.len() - 1];
        for (width, along) in widths.iter_mut().zip(along) {
            let ends = line.ends.into_iter().zip([along, whole - along]);
            for (_, from_end) in ends.filter(|(end, _)| *end == End::Free) {
                *width *= taper(from_end, whole);
            }
        }
    }
    Contour {
        kind,
        points,
        widths,
    }
}

/// The gap whose strength is a half, in longer sides of the picture.
const HALF_PLAIN_GAP: f32 = 0.16;

/// The strength of a gap of this many longer sides of the picture, 0..1.
pub(crate) fn strength_of_gap(sides: f32) -> f32 {
    sides / (sides + HALF_PLAIN_GAP)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::contours::network::Spot;

    fn straight(log_depth: f32, strength: f32, ends: [End; 2]) -> Line {
        let spot = |i| Spot {
            at: Vec2::new(i as f32, 0.0),
            strength,
            log_depth,
            is_beside: false,
        };
        Line {
            spots: (0..101).map(spot).collect(),
            closed: false,
            ends,
            part: 0,
        }
    }

    #[test]
    fn near_and_plain_lines_are_heavy() {
        let params = ContourParams {
            width_px: 3.0,
            ..ContourParams::default()
        };
        let joined = [End::Joined; 2];
        let (near, far) = (straight(0.0, 1.0, joined), straight(1.0, 1.0, joined));
        let depths = DepthRange::of([&near, &far]);
        let width = |line, kind| contour(line, kind, depths, &params).widths[50];
        let silhouette = ContourKind::Silhouette;
        assert_eq!(width(&near, silhouette), 3.0);
        assert!((width(&far, silhouette) - 3.0 * (1.0 - params.depth_emphasis)).abs() < 1e-5);
        assert!((width(&near, ContourKind::Crease) - 3.0 * params.crease_share).abs() < 1e-5);
        let faint = straight(0.0, 0.0, joined);
        assert!((width(&faint, silhouette) - 3.0 * (1.0 - params.jump_emphasis)).abs() < 1e-5);
        // Depths 4 % apart are one tenth of a deep range.
        let shallow = DepthRange {
            near: 0.0,
            far: 0.04,
        };
        let width = contour(&straight(0.04, 1.0, joined), silhouette, shallow, &params).widths[50];
        assert!((width - 3.0 * (1.0 - 0.1 * params.depth_emphasis)).abs() < 1e-4);
    }

    #[test]
    fn open_ends_run_thin_and_others_do_not() {
        let params = ContourParams::default();
        let line = straight(0.0, 1.0, [End::Free, End::Border]);
        let depths = DepthRange::of([&line]);
        let widths = contour(&line, ContourKind::Silhouette, depths, &params).widths;
        assert!((widths[0] - TIP * params.width_px).abs() < 1e-6);
        assert_eq!(
            (widths[50], widths[100]),
            (params.width_px, params.width_px)
        );
        // Half-way along the taper, half-way from the tip's share to all.
        let half = 0.5 * params.taper_px;
        let expected = params.width_px * (TIP + 0.5 * (1.0 - TIP));
        assert!((widths[half as usize] - expected).abs() < 1e-5);
    }
}
