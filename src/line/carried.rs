//! Continuation of the previous frame's lines and dots in this one.

use crate::frame::{Frame, Mask, Vector2Planes};
use crate::line::texture_coordinates::cpu::{SequenceInputs, TextureCoordinates};
use glam::Vec2;

/// Iterations to find the new position of a surface point: they converge where motion changes by less than a pixel per
/// pixel.
const STEPS: usize = 8;

/// Largest distance, in pixels, of a position from its surface's origin.
const FARTHEST: f32 = 0.5;

/// The way of a surface from the previous frame to this one.
pub(super) struct Carrier<'a> {
    pub(super) motion: &'a Vector2Planes,
    mask: &'a Mask,
    /// The corner of the previous window, from that of this one.
    shift: Vec2,
}

impl<'a> Carrier<'a> {
    /// That of a sequence, and what the previous frame left; `None` for the first frame.
    pub(super) fn of(
        sequence: Option<SequenceInputs<'a>>,
        frame: &'a Frame,
    ) -> Option<(&'a TextureCoordinates, Self)> {
        let (before, motion) = sequence.and_then(|inputs| inputs.before.zip(inputs.motion))?;
        let [was, is] =
            [before.window, frame.data_window].map(|w| Vec2::new(w.x0 as f32, w.y0 as f32));
        let carrier = Self {
            motion,
            mask: &frame.mask,
            shift: was - is,
        };
        Some((before, carrier))
    }

    /// The new position of the surface at a position in the previous frame, both in pixels of their windows; `None` if
    /// it is hidden now.
    pub(super) fn carried(&self, before: Vec2) -> Option<Vec2> {
        let before = before + self.shift;
        let mut at = before;
        for _ in 0..STEPS {
            at = before + self.come(at).unwrap_or_default();
        }
        let off = at - self.come(at)? - before;
        (off.length() <= FARTHEST).then_some(at)
    }

    /// The way that the surface at a position came, rows down.
    fn come(&self, at: Vec2) -> Option<Vec2> {
        let is_covered = self.mask.plane().within(at)?;
        let motion = self.motion;
        is_covered.then(|| Vec2::new(motion.x.nearest(at), -motion.y.nearest(at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    #[test]
    fn places_go_where_their_surface_went() {
        // Everything approaches by a twentieth, about the middle: a pixel at p came by (p - middle)/21 since.
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
        let carrier = |mask| Carrier {
            motion: &motion,
            mask,
            shift: Vec2::ZERO,
        };
        let now = before.map(|place| carrier(&mask).carried(place));
        // The second has left the picture. Motion is that of the nearest pixel: at most 0.71/21 off.
        assert_eq!(now[1], None);
        for i in [0, 2] {
            let expected = middle + (before[i] - middle) * 1.05;
            assert!(
                now[i].is_some_and(|now| now.distance(expected) < 0.04),
                "{now:?}"
            );
        }
        // A surface that is gone carries no line along.
        let gone = Mask::new(Plane::filled(200, 200, false));
        assert_eq!(carrier(&gone).carried(before[0]), None);
    }
}
