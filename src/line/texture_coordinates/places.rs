//! Maps of places: what lies next to what in them.

use crate::frame::{Frame, Plane, Vector2Planes};
use crate::line::texture_coordinates::{Jacobian, calmed, jacobian};

/// Largest step of depth, as a share of it, between pixels of one surface, and between frames, once the
/// median of all is taken out. A surface that comes nearer by more in a frame is laid anew; behind an edge
/// that is nearer than this to its background the background keeps strokes of what covered it.
pub(crate) const DEPTH_STEP: f32 = 0.08;

/// Without depth: largest difference of their motions, in pixels and as a share of the lesser.
pub(crate) const MOTION_STEP: [f32; 2] = [1.5, 0.5];

/// The place that a map gives the pixel of an index.
#[inline(always)]
pub(crate) fn place_at(map: &Vector2Planes, at: usize) -> [f32; 2] {
    [map.x.samples()[at], map.y.samples()[at]]
}

/// Which pixels belong together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surface<'a> {
    /// The pixels that have a place.
    pub(crate) covered: &'a Plane<bool>,
    pub(crate) depth: Option<&'a Plane>,
    /// How it has moved; looked at where there is no depth.
    pub(crate) motion: Option<&'a Vector2Planes>,
}

impl<'a> Surface<'a> {
    /// That of a frame, and how it has moved where that is known.
    pub(crate) fn of(frame: &'a Frame, motion: Option<&'a Vector2Planes>) -> Self {
        Self {
            covered: frame.mask.plane(),
            depth: frame.depth.as_ref(),
            motion,
        }
    }

    /// Whether the pixel `next` to that at `at` shows the same surface, by index.
    #[inline(always)]
    pub(crate) fn joins(&self, at: usize, next: usize) -> bool {
        if !self.covered.samples()[next] {
            return false;
        }
        match (self.depth, self.motion) {
            (Some(depth), _) => is_one_depth(depth.samples()[at], depth.samples()[next]),
            (None, Some(motion)) => is_one_motion(place_at(motion, at), place_at(motion, next)),
            (None, None) => true,
        }
    }
}

/// The Jacobian of a map at a pixel of a surface.
#[inline(always)]
pub(crate) fn jacobian_at(map: &Vector2Planes, surface: &Surface, x: usize, y: usize) -> Jacobian {
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
pub(crate) fn calmed_at(map: &Vector2Planes, surface: &Surface, x: usize, y: usize) -> [f32; 2] {
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
pub(crate) fn is_one_depth(a: f32, b: f32) -> bool {
    // Depths that are no numbers part nothing.
    let parted = (a - b).abs() > DEPTH_STEP * a.abs().min(b.abs());
    !parted
}

/// Whether two motions, of neighbours or of one pixel in two frames, can be of one surface.
#[inline(always)]
pub(crate) fn is_one_motion(a: [f32; 2], b: [f32; 2]) -> bool {
    let length = |x: f32, y: f32| (x * x + y * y).sqrt();
    let change = length(a[0] - b[0], a[1] - b[1]);
    change <= MOTION_STEP[0] + MOTION_STEP[1] * length(a[0], a[1]).min(length(b[0], b[1]))
}
