//! What the gaps of a frame are measured by: its lens, the unit and the rounding of its depth, and thresholds in pixels.

use crate::frame::gap::pair::GapUnit;
use crate::frame::{DepthKind, Frame, Projection};
use crate::params::SoftThreshold;

/// Smallest thresholds, in pixels, however small the picture: a pixel's own extent is no gap.
const LEAST_PX: SoftThreshold = SoftThreshold { lo: 1.5, hi: 2.5 };

/// Depths between which products fit single precision, with all focal lengths that are accepted.
pub(crate) const NEAREST: f32 = 1e-12;
pub(crate) const FARTHEST: f32 = 1e12;

/// What the gaps of a frame are measured by. Depth is along the view axis here.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapScale {
    pub(crate) is_perspective: bool,
    /// Pixels per unit of length along rows and along columns; in perspective at depth 1.
    pub(crate) pitch: [f32; 2],
    /// The step to the next column in x, and to the next row in y, of points at depth 1.
    pub(crate) step: [f32; 2],
    /// Twice the rounding error of depth: as a share of it, and in its own unit.
    pub(crate) rounding: [f32; 2],
    /// The longer side of the picture, in pixels.
    pub(crate) side: f32,
    /// Gaps that make a silhouette, in pixels.
    pub(crate) threshold: SoftThreshold,
    /// Whether depth is measured along sight lines.
    pub(crate) along_lines: bool,
    pub(crate) projection: Projection,
}

impl GapScale {
    /// The scale of a frame. `threshold` is in longer sides of its display window.
    pub(crate) fn of(frame: &Frame, threshold: SoftThreshold) -> Self {
        let window = frame.display_window;
        let side = window.width().max(window.height()) as f64;
        let projection = frame.likely_projection();
        let (is_perspective, [x, y]) = match projection {
            Projection::Perspective { fx, fy, .. } => (true, [fx, fy]),
            Projection::Orthographic { sx, sy, .. } => (false, [sx, sy]),
        };
        let pixels = |share: f32, least: f32| (side as f32 * share).max(least);
        Self {
            is_perspective,
            pitch: [x, y].map(|scale| scale.abs() as f32),
            step: [1.0 / x as f32, -1.0 / y as f32],
            rounding: frame.source.depth_rounding.map(|error| 2.0 * error),
            side: side as f32,
            threshold: SoftThreshold {
                lo: pixels(threshold.lo, LEAST_PX.lo),
                hi: pixels(threshold.hi, LEAST_PX.hi),
            },
            along_lines: frame.source.depth_kind == DepthKind::Ray,
            projection,
        }
    }

    /// Depth of a pixel along the view axis.
    #[inline(always)]
    pub(crate) fn planar(&self, depth: f32, [x, y]: [f32; 2]) -> f32 {
        let depth = match self.along_lines {
            true => depth / (1.0 + (x * x + y * y)).sqrt(),
            false => depth,
        };
        let nearest = if self.is_perspective {
            NEAREST
        } else {
            -FARTHEST
        };
        depth.clamp(nearest, FARTHEST)
    }

    /// Its unit along an axis, 0 to the right and 1 downward.
    #[inline(always)]
    pub(crate) fn unit(&self, axis: usize) -> GapUnit {
        GapUnit {
            is_perspective: self.is_perspective,
            pitch: self.pitch[axis],
            rounding: self.rounding,
        }
    }

    /// The jump between two depths along an axis, in pixels at the nearer one.
    pub(crate) fn jump_px(&self, depths: [f32; 2], axis: usize) -> f32 {
        let jump = (depths[1] - depths[0]).abs() * self.pitch[axis];
        match self.is_perspective {
            true => jump / depths[0].min(depths[1]),
            false => jump,
        }
    }

    /// What is nearer than a depth by a gap that makes a silhouette: than a share of it, less a length.
    pub(crate) fn before(&self) -> [f32; 2] {
        let gap = self.threshold.lo / self.pitch[0];
        match self.is_perspective {
            true => [1.0 / (1.0 + gap), 0.0],
            false => [1.0, gap],
        }
    }

    /// What is linear along a plane in the picture: one over depth in perspective, depth elsewhere.
    #[inline(always)]
    pub(crate) fn linear(&self, depth: f32) -> f32 {
        if self.is_perspective {
            1.0 / depth
        } else {
            depth
        }
    }
}
