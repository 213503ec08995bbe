//! Motion: how far, in pixels, the surface seen at a pixel has moved since the previous frame, x right, y up.

use super::{Camera, DepthKind, Frame, Plane, SightLines, Vector2Planes};

/// The motion in a static world with a moving camera: from the position where the camera `before` saw the point that is
/// seen now. [`Vector2Planes::AWAY`] if it was behind the eye, and outside the mask. `None` without a camera, or without
/// depth that is a distance.
pub fn static_world_motion(frame: &Frame, before: &Camera) -> Option<Vector2Planes> {
    let (depth, camera) = (frame.depth.as_ref()?, frame.camera?);
    let kind = frame.source.depth_kind;
    if kind == DepthKind::Relative {
        return None;
    }
    let sight = SightLines::new(camera.projection);
    let before_from_view = before.view_from_world * camera.view_from_world.inverse();
    let motion = |x: usize, y: usize| {
        let at = frame.data_window.middle(x, y);
        let point = sight.point(at.x, at.y, depth.at(x, y).into(), kind);
        let came_from = before
            .projection
            .pixel_of(before_from_view.transform_point3(point));
        let moved = came_from
            .filter(|_| frame.mask.at(x, y))
            .map(|from| at - from);
        match moved {
            Some(moved) if moved.is_finite() => [moved.x as f32, -moved.y as f32],
            _ => [Vector2Planes::AWAY; 2],
        }
    };
    let both = Plane::from_fn(depth.width(), depth.height(), motion);
    Some(Vector2Planes {
        x: both.map(|m| m[0]),
        y: both.map(|m| m[1]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Projection, Vector3Planes};
    use glam::{DAffine3, DVec3};

    fn wall_at(distance: f32, camera: Camera) -> Frame {
        let flat = |value| Plane::filled(8, 6, value);
        let normals = Vector3Planes {
            x: flat(0.0),
            y: flat(0.0),
            z: flat(1.0),
        };
        Frame {
            depth: Some(flat(distance)),
            camera: Some(camera),
            ..Frame::of_normals(normals, Mask::full(8, 6))
        }
    }

    #[test]
    fn a_camera_that_moves_moves_the_picture_the_other_way() {
        let at = |eye: DVec3| Camera {
            view_from_world: DAffine3::from_translation(-eye),
            projection: Projection::Perspective {
                fx: 100.0,
                fy: 100.0,
                cx: 4.0,
                cy: 3.0,
            },
        };
        // Eye 0.1 to the right and 0.2 up, wall 5 away: 100 * 0.1 / 5 = 2 px to the left, 4 px down.
        let frame = wall_at(5.0, at(DVec3::new(0.1, 0.2, 0.0)));
        let motion = static_world_motion(&frame, &at(DVec3::ZERO)).unwrap();
        assert!(motion.x.samples().iter().all(|x| (x + 2.0).abs() < 1e-4));
        assert!(motion.y.samples().iter().all(|y| (y + 4.0).abs() < 1e-4));
        // A camera beyond the wall saw nothing of it.
        let beyond = at(DVec3::new(0.0, 0.0, -6.0));
        let motion = static_world_motion(&frame, &beyond).unwrap();
        assert!(motion.x.samples().iter().all(|x| *x == Vector2Planes::AWAY));
    }
}
