//! Maps of places, and adjacency in them.

use crate::frame::{Frame, Plane, Vector2Planes, Window};
use crate::line::texture_coordinates::{
    Jacobian, calmed, is_one_depth, is_one_motion, jacobian, origin,
};
pub(crate) use crate::plan::drawing::PlaceMap;

/// The place that a map gives the pixel of an index.
#[inline(always)]
pub(crate) fn place_at(map: &Vector2Planes, at: usize) -> [f32; 2] {
    [map.x.samples()[at], map.y.samples()[at]]
}

impl PlaceMap {
    /// An undistorted map laid over `frame`.
    pub(crate) fn laid(generation: u32, frame: &Frame) -> Self {
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let [left, top] = origin_in(generation, frame.data_window);
        Self {
            place: Vector2Planes {
                x: Plane::from_fn(width, height, |x, _| left + x as f32),
                y: Plane::from_fn(width, height, |_, y| top + y as f32),
            },
            share: None,
            fade: 1.0,
            generation,
        }
    }
}

/// The place of the centre of the first pixel of `window`.
pub(crate) fn origin_in(generation: u32, window: Window) -> [f32; 2] {
    let [x, y] = origin(generation);
    [x + window.x0 as f32 + 0.5, y + window.y0 as f32 + 0.5]
}

/// Which pixels belong together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MovingSurface<'a> {
    /// The pixels that have a place.
    pub(crate) covered: &'a Plane<bool>,
    pub(crate) depth: Option<&'a Plane>,
    /// Motion of the surface, used if there is no depth.
    pub(crate) motion: Option<&'a Vector2Planes>,
}

impl<'a> MovingSurface<'a> {
    /// The surface of a frame, with its motion if known.
    pub(crate) fn of(frame: &'a Frame, motion: Option<&'a Vector2Planes>) -> Self {
        Self {
            covered: frame.mask.plane(),
            depth: frame.depth.as_ref(),
            motion,
        }
    }

    /// Whether the pixel `next` shows the same surface as its neighbour `at`, by index.
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
pub(crate) fn jacobian_at(
    map: &Vector2Planes,
    surface: &MovingSurface,
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
pub(crate) fn calmed_at(
    map: &Vector2Planes,
    surface: &MovingSurface,
    x: usize,
    y: usize,
) -> [f32; 2] {
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
