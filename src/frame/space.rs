//! Spaces and the camera that joins them.
//!
//! View space has x right, y up and z toward the viewer; picture coordinates have x right and y
//! down, pixel edges at integers, so the centre of the first pixel is (0.5, 0.5).

use glam::{DAffine3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// The space a normal map was written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NormalSpace {
    /// x right, y up, z toward the viewer.
    View,
    /// The scene's own axes; a camera is needed to turn them to the view.
    World,
}

/// What the depth of a frame measures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DepthKind {
    /// Distance along the view axis.
    #[default]
    Planar,
    /// Distance along the sight line, from the eye.
    Ray,
    /// Something that changes with distance, or distance too coarse for more: it shows where depth
    /// jumps, not where the surface is.
    Relative,
}

impl std::fmt::Display for DepthKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Planar => "depth along the view axis",
            Self::Ray => "depth along the sight line",
            Self::Relative => "relative depth",
        })
    }
}

/// How view space falls onto the picture, in pixels of the display window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", tag = "type")]
pub enum Projection {
    /// All sight lines meet in the eye.
    Perspective {
        /// Focal length in pixel widths.
        fx: f64,
        /// Focal length in pixel heights.
        fy: f64,
        /// Column of the principal point.
        cx: f64,
        /// Row of the principal point.
        cy: f64,
    },
    /// All sight lines are parallel.
    Orthographic {
        /// Pixel widths per unit of length.
        sx: f64,
        /// Pixel heights per unit of length.
        sy: f64,
        /// Column of the view axis.
        cx: f64,
        /// Row of the view axis.
        cy: f64,
    },
}

/// Where the viewer stood and how the picture was projected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// World to view space: a rotation and a translation, no scale; mirrored where the world is left-handed.
    pub view_from_world: DAffine3,
    /// View space to pixels.
    pub projection: Projection,
}

impl Camera {
    /// Where a world-space point falls on the picture; `None` at or behind the eye.
    pub fn pixel_of(&self, world: DVec3) -> Option<DVec2> {
        self.projection
            .pixel_of(self.view_from_world.transform_point3(world))
    }
}

impl Projection {
    /// Where a view-space point falls on the picture; `None` at or behind the eye.
    pub fn pixel_of(&self, view: DVec3) -> Option<DVec2> {
        match *self {
            Self::Perspective { fx, fy, cx, cy } => (view.z < 0.0)
                .then(|| DVec2::new(cx - fx * view.x / view.z, cy + fy * view.y / view.z)),
            Self::Orthographic { sx, sy, cx, cy } => {
                Some(DVec2::new(cx + sx * view.x, cy - sy * view.y))
            }
        }
    }

    /// The direction to the eye from the surface seen at picture position (`x`, `y`), scaled so that
    /// its z is 1; only its x and y are returned. Zero for an orthographic camera.
    pub fn to_eye(&self, x: f64, y: f64) -> DVec2 {
        match *self {
            // A view ray is (X, Y, -1) with X = (x - cx)/fx and Y = (cy - y)/fy; the eye lies against it.
            Self::Perspective { fx, fy, cx, cy } => DVec2::new((cx - x) / fx, (y - cy) / fy),
            Self::Orthographic { .. } => DVec2::ZERO,
        }
    }
}
