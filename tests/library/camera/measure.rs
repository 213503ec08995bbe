//! Difference between a camera and the true one.

use crate::prelude::*;
use std::fmt::Debug;

/// Angle, in degrees, from one rotation to another. Read off its sine: the cosine rounds below 1e-6.
pub(crate) fn turn_deg(a: DMat3, b: DMat3) -> f64 {
    let m = a * b.transpose();
    let twice_sine = DVec3::new(
        m.y_axis.z - m.z_axis.y,
        m.z_axis.x - m.x_axis.z,
        m.x_axis.y - m.y_axis.x,
    );
    let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    twice_sine.length().atan2(trace - 1.0).to_degrees()
}

/// Angle, in degrees, between the rotations of two cameras.
pub(crate) fn turn_between(a: &Camera, b: &Camera) -> f64 {
    turn_deg(a.view_from_world.matrix3, b.view_from_world.matrix3)
}

/// The camera's matrix must be a rotation, less than `limit` degrees from `truth`.
pub(crate) fn expect_rotation(camera: &Camera, truth: DMat3, limit: f64, found: &impl Debug) {
    let m = camera.view_from_world.matrix3;
    let turn = turn_deg(m, truth);
    assert!(turn < limit, "off by {turn} degrees: {found:?}");
    let off = m * m.transpose() - DMat3::IDENTITY;
    assert!(off.to_cols_array().iter().all(|e| e.abs() < 1e-12));
    assert!(m.determinant() > 0.0);
}

/// The share by which a focal length, or the pixels per unit of parallel sight lines, is another than the true one; without end
/// for a projection of the other kind.
pub(crate) fn focal_error(found: &Camera, truth: &Camera) -> f64 {
    use Projection::{Orthographic, Perspective};
    let [found, truth] = match (found.projection, truth.projection) {
        (Perspective { fx: a, .. }, Perspective { fx: b, .. }) => [a, b],
        (Orthographic { sx: a, .. }, Orthographic { sx: b, .. }) => [a, b],
        _ => return f64::INFINITY,
    };
    (found / truth - 1.0).abs()
}
