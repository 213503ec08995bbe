//! The planes of an outcome, by name.

use relievo::engine::Outcome;
use relievo::frame::Plane;

/// All planes; those of the picture last.
pub fn planes(outcome: &Outcome) -> Vec<(&'static str, &Plane)> {
    let shape = &outcome.shape;
    let (gradient, hessian) = (shape.gradient.as_ref(), shape.hessian.as_ref());
    let (direction, direction_view) = (shape.direction.as_ref(), shape.direction_view.as_ref());
    let curvatures = shape.curvatures.as_ref();
    let color = outcome.color.as_ref();
    let drawing = outcome.drawing.as_ref();
    let all = [
        ("silhouette", shape.silhouette.as_ref()),
        ("crease", shape.crease.as_ref()),
        ("conductance", shape.conductance.as_ref()),
        ("gradient.x", gradient.map(|g| &g.x)),
        ("gradient.y", gradient.map(|g| &g.y)),
        ("trace", shape.trace.as_ref()),
        ("hessian.xx", hessian.map(|h| &h.xx)),
        ("hessian.xy", hessian.map(|h| &h.xy)),
        ("hessian.yy", hessian.map(|h| &h.yy)),
        ("curvature.u", curvatures.map(|c| &c.u)),
        ("curvature.v", curvatures.map(|c| &c.v)),
        ("curvature.mean", curvatures.map(|c| &c.mean)),
        ("kappa", shape.kappa.as_ref()),
        ("direction.x", direction.map(|d| &d.x)),
        ("direction.y", direction.map(|d| &d.y)),
        ("direction_view.x", direction_view.map(|d| &d.x)),
        ("direction_view.y", direction_view.map(|d| &d.y)),
        ("hatching", drawing.map(|d| &d.hatching)),
        ("contours", drawing.and_then(|d| d.contours.as_ref())),
        ("red", color.map(|c| &c.r)),
        ("green", color.map(|c| &c.g)),
        ("blue", color.map(|c| &c.b)),
    ];
    all.into_iter()
        .filter_map(|(name, plane)| Some((name, plane?)))
        .collect()
}
