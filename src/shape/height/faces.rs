//! Weights of the faces between pixels, and sums over the four faces of each.

use crate::frame::{Mask, Plane};
use crate::shape::conductance::face_conductance;

/// Weights of the faces to the right of and below each pixel, 0..1. Those of the last column and row lead to the first
/// ones: 0 where borders do not continue each other.
#[derive(Debug, Clone)]
pub(super) struct Faces {
    pub(super) x: Plane,
    pub(super) y: Plane,
}

impl Faces {
    /// The faces between covered pixels, by their conductance.
    pub(super) fn new(conductance: &Plane, mask: &Mask, wraps: [bool; 2]) -> Self {
        let (width, height) = (mask.width(), mask.height());
        let open = |x: usize, y: usize| match mask.at(x, y) {
            true => conductance.at(x, y),
            false => 0.0,
        };
        let is_there = |at: usize, next: usize, wraps: bool| next > at || wraps && next < at;
        let x = Plane::of_pixels(width, height, |x, y| {
            let next = (x + 1) % width;
            match is_there(x, next, wraps[0]) {
                true => face_conductance(open(x, y), open(next, y)),
                false => 0.0,
            }
        });
        let y = Plane::of_pixels(width, height, |x, y| {
            let next = (y + 1) % height;
            match is_there(y, next, wraps[1]) {
                true => face_conductance(open(x, y), open(x, next)),
                false => 0.0,
            }
        });
        Self { x, y }
    }

    /// The faces of pixels twice as wide and high: the mean of the two that each consists of.
    pub(super) fn halved(&self) -> Self {
        let (width, height) = (self.x.width(), self.x.height());
        let [w, h] = [width, height].map(|length| length.div_ceil(2));
        let last = |from: usize, length: usize| (2 * from + 1).min(length - 1);
        let open = |faces: &Plane, x, y| faces.get(x, y).unwrap_or(0.0);
        // A face from a pixel to itself stands for nothing.
        let x = Plane::of_pixels(w, h, |x, y| {
            let at = if w > 1 { last(x, width) } else { width };
            0.5 * (open(&self.x, at, 2 * y) + open(&self.x, at, 2 * y + 1))
        });
        let y = Plane::of_pixels(w, h, |x, y| {
            let at = if h > 1 { last(y, height) } else { height };
            0.5 * (open(&self.y, 2 * x, at) + open(&self.y, 2 * x + 1, at))
        });
        Self { x, y }
    }
}
