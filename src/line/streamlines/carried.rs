//! Where lines of the frame before go on in this one.

use crate::frame::{Mask, Vector2Planes};
use glam::Vec2;

/// Steps in which a place is looked for that the surface has come to: it closes in where motion changes by less than a pixel
/// per pixel.
const STEPS: usize = 8;

/// How far, in pixels, a place may lie from where its surface came from.
const FARTHEST: f32 = 0.5;

/// The place to which the surface at a place of the frame before has come by `motion` (pixels, x right, y up); `None` if it is
/// hidden now.
pub(super) fn carried(before: Vec2, motion: &Vector2Planes, mask: &Mask) -> Option<Vec2> {
    let come = |at: Vec2| {
        let is_inside = at.x >= 0.0 && at.y >= 0.0;
        let (x, y) = (at.x as usize, at.y as usize);
        let is_covered = is_inside && x < mask.width() && y < mask.height() && mask.at(x, y);
        is_covered.then(|| Vec2::new(motion.x.at(x, y), -motion.y.at(x, y)))
    };
    let mut at = before;
    for _ in 0..STEPS {
        at = before + come(at).unwrap_or_default();
    }
    let off = at - come(at)? - before;
    (off.length() <= FARTHEST).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    #[test]
    fn places_go_where_their_surface_went() {
        // All comes nearer by a twentieth, about the middle: a pixel at p came by (p - middle)/21 since.
        let middle = Vec2::splat(100.0);
        let come = |x: usize, y: usize| (Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - middle) / 21.0;
        let motion = Vector2Planes {
            x: Plane::from_fn(200, 200, |x, y| come(x, y).x),
            y: Plane::from_fn(200, 200, |x, y| -come(x, y).y),
        };
        let mask = Mask::new(Plane::filled(200, 200, true));
        let before = [
            Vec2::new(60.3, 110.2),
            Vec2::new(2.0, 100.0),
            Vec2::new(150.0, 20.0),
        ];
        let now = before.map(|place| carried(place, &motion, &mask));
        // The second has left the picture. Motion is that of the nearest pixel: at most 0.71/21 off.
        assert_eq!(now[1], None);
        for i in [0, 2] {
            let expected = middle + (before[i] - middle) * 1.05;
            assert!(
                now[i].is_some_and(|now| now.distance(expected) < 0.04),
                "{now:?}"
            );
        }
        // What is not there any more takes no line along.
        let gone = Mask::new(Plane::filled(200, 200, false));
        assert_eq!(carried(before[0], &motion, &gone), None);
    }
}
