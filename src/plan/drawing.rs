//! What a drawing consists of: its layers, lines and dots, and what the next frame of a sequence takes of it.

use crate::frame::{Mask, Plane, Vector2Planes, Window};
use glam::Vec2;
use serde::Serialize;

/// A drawing in layers of coverage, 0..1; 0 outside the mask.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// Strokes along the curvature.
    pub hatching: Plane,
    /// The strokes as vector lines, if [they are placed one by one](crate::params::Style::is_laid).
    pub lines: Vec<Streamline>,
    /// The strokes as dots, for stipple styles.
    pub dots: Vec<Dot>,
    /// Lines along silhouettes and creases, if requested; also outside the mask.
    pub contours: Option<Plane>,
    /// The contours as vector lines, silhouettes first.
    pub contour_lines: Vec<Contour>,
    /// Lines inside surfaces, if requested.
    pub interior: Option<Plane>,
    /// The interior lines as vector lines.
    pub interior_lines: Vec<Contour>,
    /// Target coverage of the strokes, 0..1, if tone shows the shape.
    pub asked: Option<Plane>,
    /// Luminance used as paper white.
    pub white_point: f32,
    /// Position of the stroke texture, for the next frame of a sequence.
    pub coordinates: Option<TextureCoordinates>,
}

impl Drawing {
    /// All layers, composited.
    pub fn layers(&self) -> Vec<&Plane> {
        let lines = self.contours.iter().chain(&self.interior);
        std::iter::once(&self.hatching).chain(lines).collect()
    }
}

/// A stroke as a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Streamline {
    /// The points it passes, in pixels from the upper left corner of the data window, y down.
    pub points: Vec<Vec2>,
    /// Its width at each point, in pixels.
    pub widths: Vec<f32>,
    /// Whether it crosses others, to darken them.
    pub crosses: bool,
}

/// A dot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Its middle, in pixels from the upper left corner of the data window, y down.
    pub at: Vec2,
    /// Its radius, in pixels.
    pub radius: f32,
}

/// The edge that a contour follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ContourKind {
    /// The surface ends, or one part of it hides another.
    Silhouette,
    /// The surface turns sharply.
    Crease,
    /// Another object begins, in the same plane.
    Object,
    /// The surface is folded inward: a line inside it.
    Valley,
    /// The surface is folded outward: a line inside it.
    Ridge,
    /// The surface nearly turns away from the viewer: a line inside it.
    Suggestive,
    /// A shadow cast on the surface ends: a line inside it.
    Shadow,
}

/// A line along an edge.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    /// The kind of edge it follows.
    pub kind: ContourKind,
    /// The points it passes, in pixels from the upper left corner of the data window, y down; of a closed
    /// line the first is repeated at the end.
    pub points: Vec<Vec2>,
    /// Its width at each point, in pixels.
    pub widths: Vec<f32>,
}

impl Contour {
    /// Whether it ends at its start.
    pub fn is_closed(&self) -> bool {
        self.points.len() > 2 && self.points.first() == self.points.last()
    }
}

/// State that a frame of a sequence takes from the previous one; the first has none.
#[derive(Debug, Clone, Copy, Default)]
pub struct SequenceInputs<'a> {
    /// Previous placement of the stroke texture.
    pub before: Option<&'a TextureCoordinates>,
    /// Motion of the surface seen at each pixel since then, in pixels: x right, y up.
    pub motion: Option<&'a Vector2Planes>,
}

/// Positions in the fixed stroke texture for every pixel of a frame: the state a sequence passes from one frame to the
/// next.
#[derive(Debug, Clone)]
pub struct TextureCoordinates {
    pub(crate) window: Window,
    pub(crate) mask: Mask,
    pub(crate) depth: Option<Plane>,
    /// Motion of the frame, from the second on, if there is no depth.
    pub(crate) motion: Option<Vector2Planes>,
    /// Oldest first.
    pub(crate) maps: Vec<PlaceMap>,
    /// Share of the next map, if any of it is needed.
    pub(crate) next: Option<Plane>,
    /// Number of maps born.
    pub(crate) born: u32,
    /// Strokes that are placed one by one, by family.
    pub(crate) lines: Vec<Vec<LaidLine>>,
    /// The directions of such strokes, by family, x right, y up.
    pub(crate) directions: Vec<Vector2Planes>,
    /// Dots, in pixels of the window.
    pub(crate) dots: Vec<LaidDot>,
}

/// A map of places that moves with the surface.
#[derive(Debug, Clone)]
pub(crate) struct PlaceMap {
    /// Pixel coordinates, rows down, in the texture's fixed frame.
    pub(crate) place: Vector2Planes,
    /// Share of the drawing, 0..1; `None` is 1.
    pub(crate) share: Option<Plane>,
    /// 1; falls to 0 where the map has to make room.
    pub(crate) fade: f32,
    pub(crate) generation: u32,
}

/// A line as it is carried from frame to frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LaidLine {
    /// The points it passes, in pixels of the window, rows down.
    pub(crate) points: Vec<Vec2>,
    /// The index of the point that it was begun at, which may have been cut off.
    pub(crate) seed: i32,
}

/// A dot as it is carried from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LaidDot {
    /// Its middle, in pixels of the window, y down.
    pub(crate) at: Vec2,
    /// Share of the area of a whole dot, 0..1.
    pub(crate) share: f32,
    /// Whether it is about to vanish.
    pub(crate) is_going: bool,
}
