//! Sight lines as uniforms and in WGSL.

use crate::frame::{Frame, MIN_SEEN, Projection, SightLines};
use crate::gpu::wgsl::Number::F32;
use crate::gpu::wgsl::{Wgsl, wgsl};
use glam::{DVec2, DVec3};

/// Sight lines, and the projection of tangents along them.
pub(crate) const SIGHT_LINES: Wgsl = wgsl!(
    "../frame/sight_lines.wgsl",
    [("MIN_SEEN", F32(MIN_SEEN as f32))]
);

/// A vector linear in column and row that equals `vector` everywhere in the picture: x and y at the origin of both, and their
/// increments along columns and along rows.
pub(crate) fn linear(frame: &Frame, vector: impl Fn(f64, f64) -> DVec2) -> [f32; 4] {
    let window = frame.data_window;
    let at = |column: i32, row: i32| {
        let [x, y] = [window.x0 + column, window.y0 + row].map(|at| f64::from(at) + 0.5);
        vector(x, y)
    };
    let first = at(0, 0);
    let step = (at(1, 1) - first).as_vec2();
    let first = first.as_vec2();
    [first.x, first.y, step.x, step.y]
}

/// The direction to the eye, scaled to z = 1.
pub(crate) fn to_eye(frame: &Frame) -> [f32; 4] {
    let camera = frame.camera;
    linear(frame, |x, y| {
        camera.map_or(DVec2::ZERO, |camera| camera.projection.to_eye(x, y))
    })
}

/// Origins of sight lines, x and y of view space.
pub(crate) fn starts(frame: &Frame) -> [f32; 4] {
    linear(frame, |x, y| {
        let lines = frame
            .camera
            .map(|camera| SightLines::new(camera.projection));
        lines.map_or(DVec2::ZERO, |lines| lines.line(x, y).0.truncate())
    })
}

/// The direction of sight lines, scaled to z = -1.
pub(crate) fn lines(frame: &Frame, sight: &SightLines) -> [f32; 4] {
    linear(frame, |x, y| sight.line(x, y).1.truncate())
}

/// The step between points at depth 1, from one column, and from one row, to the next.
pub(crate) fn step_at_unit_depth(frame: &Frame, sight: &SightLines) -> [f32; 2] {
    let point = |x, y| {
        let (start, line): (DVec3, DVec3) = sight.line(x, y);
        (start + line).truncate()
    };
    linear(frame, point)[2..].try_into().expect("two of four")
}

/// Whether the eye is at infinity along z, for every pixel.
pub(crate) fn is_eye_far(frame: &Frame) -> bool {
    let projection = frame.camera.map(|camera| camera.projection);
    !matches!(projection, Some(Projection::Perspective { .. }))
}
