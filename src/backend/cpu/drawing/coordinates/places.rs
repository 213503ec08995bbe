//! Maps of places: what lies next to what in them.

use crate::frame::{Frame, Mask, Plane, Vector2Planes};
use crate::line::texture_coordinates::{Jacobian, calmed, jacobian};

/// Largest step of depth, as a share of it, between pixels of one surface, and between frames, once the
/// median of all is taken out. A surface that comes nearer by more in a frame is laid anew; behind an edge
/// that is nearer than this to its background the background keeps strokes of what covered it.
const DEPTH_STEP: f32 = 0.08;

/// The place that a map gives the pixel of an index.
#[inline(always)]
pub(super) fn place_at(map: &Vector2Planes, at: usize) -> [f32; 2] {
    [map.x.samples()[at], map.y.samples()[at]]
}

/// Which pixels belong together.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Surface<'a> {
    /// The pixels that have a place.
    pub(super) covered: &'a Plane<bool>,
    pub(super) depth: Option<&'a Plane>,
}

impl<'a> Surface<'a> {
    /// That of a frame.
    pub(super) fn of(frame: &'a Frame) -> Self {
        Self::new(&frame.mask, frame.depth.as_ref())
    }

    pub(super) fn new(mask: &'a Mask, depth: Option<&'a Plane>) -> Self {
        Self {
            covered: mask.plane(),
            depth,
        }
    }

    /// Whether the pixel `next` to that at `at` shows the same surface, by index.
    #[inline(always)]
    pub(super) fn joins(&self, at: usize, next: usize) -> bool {
        let is_one = |depth: &Plane| is_one_depth(depth.samples()[at], depth.samples()[next]);
        self.covered.samples()[next] && self.depth.is_none_or(is_one)
    }
}

/// The Jacobian of a map at a pixel of a surface.
#[inline(always)]
pub(in super::super) fn jacobian_at(
    map: &Vector2Planes,
    surface: &Surface,
    x: usize,
    y: usize,
) -> Jacobian {
    let (width, height) = (map.x.width(), map.x.height());
    let at = y * width + x;
    let place = |inside: bool, next: usize| {
        (inside && surface.joins(at, next)).then(|| place_at(map, next))
    };
    jacobian(
        place_at(map, at),
        [
            place(x > 0, at.wrapping_sub(1)),
            place(x + 1 < width, at + 1),
        ],
        [
            place(y > 0, at.wrapping_sub(width)),
            place(y + 1 < height, at + width),
        ],
    )
}

/// The places of a map without the roughness that motion brings in.
#[inline(always)]
pub(super) fn calmed_at(map: &Vector2Planes, surface: &Surface, x: usize, y: usize) -> [f32; 2] {
    let (width, height) = (map.x.width(), map.x.height());
    let at = y * width + x;
    let inside = |by: usize| x >= by && y >= by && x + by < width && y + by < height;
    let here = place_at(map, at);
    if !inside(1) {
        return here;
    }
    let pairs = |by: usize| {
        [by, by * width, by * (width + 1), by * (width - 1)].map(|step| {
            let (before, after) = (at - step, at + step);
            let joins = surface.joins(at, before) && surface.joins(at, after);
            joins.then(|| [before, after].map(|at| place_at(map, at)))
        })
    };
    calmed(here, pairs(1), || match inside(2) {
        true => pairs(2),
        false => [None; 4],
    })
}

/// Whether two depths, of neighbours or of one pixel in two frames, can be of one surface.
#[inline(always)]
pub(super) fn is_one_depth(a: f32, b: f32) -> bool {
    // Depths that are no numbers part nothing.
    let parted = (a - b).abs() > DEPTH_STEP * a.abs().min(b.abs());
    !parted
}
