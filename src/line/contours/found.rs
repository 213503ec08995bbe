//! Edges that a device found, as lists.

use crate::frame::{Frame, Plane};
use crate::line::contours::Contour;
use crate::line::contours::cpu::{Edges, contours_along};
use crate::line::contours::cracks;
use crate::params::{ContourParams, ShapeParams};

/// A crack that a silhouette passes. Where it is the border of coverage, only the place of the crack counts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FoundCrack {
    /// The number of the pixel behind it: below it, or right of it.
    pub(crate) pixel: u32,
    /// Whether it lies left of that pixel, else above it.
    pub(crate) is_left: bool,
    /// How far behind its middle the silhouette lies, in pixels.
    pub(crate) offset: f32,
    /// How plain the edge is, 0..1.
    pub(crate) strength: f32,
    /// Logarithm of the depth of its nearer side; 0 where depth is unknown.
    pub(crate) log_depth: f32,
    /// Whether the border of coverage runs close beside it.
    pub(crate) is_beside: bool,
}

/// The edges of a frame.
#[derive(Debug)]
pub(crate) struct FoundEdges {
    /// The cracks that silhouettes pass, by pixel, of each pixel the one above it first.
    pub(crate) cracks: Vec<FoundCrack>,
    /// The pixels that have a crease weight, in order, with their weights.
    pub(crate) creases: Vec<(u32, f32)>,
}

impl FoundEdges {
    /// The contours of a frame along them, silhouettes first.
    pub(crate) fn contours(
        &self,
        frame: &Frame,
        shape: &ShapeParams,
        params: &ContourParams,
    ) -> Vec<Contour> {
        let mut crease = Plane::filled(frame.mask.width(), frame.mask.height(), 0.0);
        for &(pixel, weight) in &self.creases {
            crease.samples_mut()[pixel as usize] = weight;
        }
        let edges = Edges {
            cracks: cracks::found(&self.cracks, frame, shape),
            crease_pixels: self.creases.iter().map(|&(pixel, _)| pixel).collect(),
            crease: &crease,
        };
        contours_along(edges, frame, shape, params)
    }
}
