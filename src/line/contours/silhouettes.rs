//! Silhouettes: lines along their cracks.

use crate::frame::{Frame, Plane};
use crate::line::contours::cracks::{Crack, DOWN, Finder, RIGHT};
use crate::line::contours::lattice::{Lattice, NodePath};
use crate::line::contours::network;
use crate::line::contours::network::Line;
use crate::line::contours::smoothing::Smoothing;
use crate::params::{ContourParams, ShapeParams};
use glam::Vec2;

/// Deviation from the edge of a line through the centres of cracks: half a pixel, and a little more where the edge
/// bends.
const STEP: f32 = 0.6;

/// The lines along all silhouettes of this weight.
pub(crate) fn lines(
    weight: &Plane,
    frame: &Frame,
    shape: &ShapeParams,
    params: &ContourParams,
) -> Vec<Line> {
    let finder = Finder::new(frame, shape);
    let mut cracks = finder.cracks(weight);
    if cracks.is_empty() {
        return Vec::new();
    }
    let risers = finder.risers(&lattice(&cracks, frame));
    if !risers.is_empty() {
        cracks.extend(risers);
        cracks.sort_unstable_by_key(|c| (c.corner, c.step));
    }
    along(&cracks, frame, params)
}

/// The lattice of pixel corners with these cracks for links.
fn lattice(cracks: &[Crack], frame: &Frame) -> Lattice {
    let (width, height) = (frame.mask.width() + 1, frame.mask.height() + 1);
    Lattice::new(width, height, cracks.iter().map(|c| (c.corner, c.step)))
}

/// The lines along cracks, which are in order.
pub(crate) fn along(cracks: &[Crack], frame: &Frame, params: &ContourParams) -> Vec<Line> {
    let lattice = lattice(cracks, frame);
    let place = |corner: u32| {
        let [x, y] = lattice.place(corner);
        Vec2::new(x as f32, y as f32)
    };
    let spot_between = |a: u32, b: u32| {
        let (corner, step) = (a.min(b), if a.abs_diff(b) == 1 { RIGHT } else { DOWN });
        let found = cracks.binary_search_by_key(&(corner, step), |c| (c.corner, c.step));
        cracks[found.expect("links are cracks")].spot
    };
    let spots = |path: &NodePath| {
        let pairs = path
            .nodes
            .windows(2)
            .map(|pair| spot_between(pair[0], pair[1]));
        let (first, last) = (path.nodes[0], path.nodes[path.nodes.len() - 1]);
        let closing = path.closed.then(|| spot_between(last, first));
        pairs.chain(closing).collect()
    };
    network::lines(&lattice, place, spots, 0, Smoothing::of(params, STEP))
}
