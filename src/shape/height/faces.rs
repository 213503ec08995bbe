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
        let [mut x, mut y] = [(); 2].map(|()| Plane::filled(width, height, 0.0));
        x.each_row(|row, faces| {
            for (column, face) in faces.iter_mut().enumerate() {
                let next = (column + 1) % width;
                let is_there = next > column || wraps[0] && width > 1;
                if is_there {
                    *face = face_conductance(open(column, row), open(next, row));
                }
            }
        });
        y.each_row(|row, faces| {
            let next = (row + 1) % height;
            if next > row || wraps[1] && height > 1 {
                for (column, face) in faces.iter_mut().enumerate() {
                    *face = face_conductance(open(column, row), open(column, next));
                }
            }
        });
        Self { x, y }
    }

    /// The faces of pixels twice as wide and high: the mean of the two that each consists of.
    pub(super) fn halved(&self) -> Self {
        let (width, height) = (self.x.width(), self.x.height());
        let [w, h] = [width, height].map(|length| length.div_ceil(2));
        let [mut x, mut y] = [(); 2].map(|()| Plane::filled(w, h, 0.0));
        let last = |from: usize, length: usize| (2 * from + 1).min(length - 1);
        // A face from a pixel to itself stands for nothing.
        let (has_x, has_y) = (w > 1, h > 1);
        x.each_row(|row, faces| {
            for (column, face) in faces.iter_mut().enumerate().filter(|_| has_x) {
                let at = last(column, width);
                let below = match 2 * row + 1 < height {
                    true => self.x.at(at, 2 * row + 1),
                    false => 0.0,
                };
                *face = 0.5 * (self.x.at(at, 2 * row) + below);
            }
        });
        y.each_row(|row, faces| {
            for (column, face) in faces.iter_mut().enumerate().filter(|_| has_y) {
                let at = last(row, height);
                let beside = match 2 * column + 1 < width {
                    true => self.y.at(2 * column + 1, at),
                    false => 0.0,
                };
                *face = 0.5 * (self.y.at(2 * column, at) + beside);
            }
        });
        Self { x, y }
    }
}
