//! What a run gives: planes of the descriptor, a picture, a drawing.

use crate::frame::{ColorPlanes, Plane, SymmetricPlanes, Vector2Planes};
use crate::line::contours::Contour;
use crate::line::streamlines::Streamline;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use std::time::Duration;

/// The planes of the shape descriptor that a plan asked for, and those it needed on the way.
///
/// Curvature is per pixel; where a [reference height](crate::params::ShapeParams::reference_height) is
/// given it is per pixel of the reference.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// Silhouette weight, 0..1.
    pub silhouette: Option<Plane>,
    /// Crease weight, 0..1.
    pub crease: Option<Plane>,
    /// Conductance, 0..1; 0 outside the mask.
    pub conductance: Option<Plane>,
    /// Depth gradient at the scale asked for, y up.
    pub gradient: Option<Vector2Planes>,
    /// Trace of the Hessian, per pixel; convex is negative.
    pub trace: Option<Plane>,
    /// Hessian of the height, per pixel, y up; convex is negative.
    pub hessian: Option<SymmetricPlanes>,
    /// Principal and mean curvature, per pixel.
    pub curvatures: Option<CurvaturePlanes>,
    /// Mapped curvature, -1..1; **convex is positive**.
    pub kappa: Option<Plane>,
    /// Curvature at further scales.
    pub more_scales: Vec<ScaleShape>,
    /// Direction, in the picture, of the curvature of the surface itself that is larger in size: unit,
    /// x right, y up, equal to its opposite; 0 outside the mask. Where the surface has none it turns from that
    /// of its neighbours to a fixed one, within [`crate::line::direction::FILL_REACH_PX`].
    pub direction: Option<Vector2Planes>,
    /// Direction of the view-centred curvature (of the Hessian) larger in size, likewise; 0 where there
    /// is none.
    pub direction_view: Option<Vector2Planes>,
}

/// Curvature at one of several scales.
#[derive(Debug, Clone)]
pub struct ScaleShape {
    /// Sigma of the scale in pixels of the reference.
    pub sigma_px: f32,
    /// Principal and mean curvatures.
    pub curvatures: CurvaturePlanes,
    /// Mapped curvature, by the gain of the first scale.
    pub kappa: Plane,
}

/// Principal curvatures `u >= v` and their mean, per pixel; convex is negative.
#[derive(Debug, Clone)]
pub struct CurvaturePlanes {
    /// The larger principal curvature.
    pub u: Plane,
    /// The smaller principal curvature.
    pub v: Plane,
    /// Their mean.
    pub mean: Plane,
}

impl CurvaturePlanes {
    /// The trace of the Hessian, twice the mean.
    pub(crate) fn trace(&self) -> Plane {
        self.mean.map(|mean| 2.0 * mean)
    }
}

/// A drawing in layers: how much of the paper each covers, 0..1; 0 outside the mask.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// Strokes along the curvature.
    pub hatching: Plane,
    /// The same as lines, for [`crate::params::Style::Lines`].
    pub lines: Vec<Streamline>,
    /// Lines along silhouettes and creases, where they were asked for; also outside the mask.
    pub contours: Option<Plane>,
    /// The same as lines, silhouettes first.
    pub contour_lines: Vec<Contour>,
    /// Luminance of paper white that was used.
    pub white_point: f32,
    /// Where the texture of strokes lies, for the next frame of a sequence.
    pub coordinates: Option<TextureCoordinates>,
}

/// What a run gave.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// The descriptor.
    pub shape: Shape,
    /// The picture with its shape brought out, in new light, or the curvature display; where it is drawn,
    /// the tone of the drawing.
    pub color: Option<ColorPlanes>,
    /// The drawing.
    pub drawing: Option<Drawing>,
    /// The gain of the curvature mapping that was used.
    pub gain: Option<f32>,
    /// The white level that was used.
    pub white_level: Option<f32>,
    /// The factor of the environment's radiance that was used.
    pub environment_gain: Option<f32>,
    /// The white levels that were used where each term of the light has its own, with the terms' names.
    pub term_white_levels: Vec<(&'static str, f32)>,
    /// How long each pass took, in order.
    pub timings: Vec<(&'static str, Duration)>,
}
