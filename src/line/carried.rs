//! Continuation of the previous frame's lines and dots in this one.

use crate::frame::memory::Memory;
use crate::frame::rows::map_covered;
use crate::frame::{Frame, Mask, Vector2Planes};
use crate::line::texture_coordinates::cpu::{SequenceInputs, TextureCoordinates};
use glam::{Mat2, Vec2};

/// Iterations to find the new position of a surface point: they converge where motion changes by less than a pixel per
/// pixel.
const STEPS: usize = 8;

/// Largest distance, in pixels, of a position from its surface's origin.
const FARTHEST: f32 = 0.5;

/// Distance over which the turn of a surface is measured, in pixels, and the most that its motion changes per pixel.
const TURN_PX: f32 = 3.0;
const MOST_CHANGE: f32 = 0.5;

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

    /// The directions of the frame before, x right, y up, turned as the surface has turned since; 0 where it was not seen.
    pub(super) fn directions(&self, before: &Vector2Planes, memory: &Memory) -> Vector2Planes {
        let [x, y] = map_covered(self.mask, memory, |y| {
            move |x| {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                self.turned(before, at).unwrap_or_default().to_array()
            }
        });
        Vector2Planes { x, y }
    }

    /// Leaves the `carried` directions of what stands still as they are.
    pub(super) fn keep_still(&self, found: &mut Vector2Planes, carried: &Vector2Planes) {
        for (y, x) in (0..self.mask.height()).flat_map(|y| self.mask.span(y).map(move |x| (y, x))) {
            let was = Vec2::new(carried.x.at(x, y), carried.y.at(x, y));
            if was != Vec2::ZERO && self.came([x, y]) == Vec2::ZERO {
                found.x.row_mut(y)[x] = was.x;
                found.y.row_mut(y)[x] = was.y;
            }
        }
    }

    /// The direction that the surface at a position had, where it is now.
    fn turned(&self, before: &Vector2Planes, at: Vec2) -> Option<Vec2> {
        let from = at - self.come(at)? - self.shift;
        let was = Vec2::new(before.x.within(from)?, -before.y.within(from)?);
        // The way back leads from a step e to e minus the change of motion over it.
        let back = [Vec2::X, Vec2::Y].map(|axis| axis - self.change(at, axis));
        let now = Mat2::from_cols(back[0], back[1]).inverse() * was;
        let now = now.try_normalize()?;
        Some(Vec2::new(now.x, -now.y))
    }

    /// The change of motion per pixel along an axis, on one surface.
    fn change(&self, at: Vec2, axis: Vec2) -> Vec2 {
        let beside = [-1.0, 1.0].map(|way| self.come(at + way * TURN_PX * axis));
        let change = |[before, after]: [Vec2; 2]| (after - before) / (2.0 * TURN_PX);
        let both = beside[0]
            .zip(beside[1])
            .map(|(before, after)| change([before, after]));
        let one_surface = both.filter(|change| change.length() < MOST_CHANGE);
        one_surface.unwrap_or_default()
    }

    /// The way that the surface at a position came, rows down, interpolated within the surface.
    fn come(&self, at: Vec2) -> Option<Vec2> {
        let is_covered = self.mask.plane().within(at)?;
        let here = is_covered.then(|| self.came(self.motion.x.pixel_at(at)))?;
        let corner = (at - 0.5).floor();
        let share = at - 0.5 - corner;
        let mut sum = Vec2::ZERO;
        for step in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE] {
            let [x, y] = self.motion.x.pixel_at(corner + step);
            let there = Some(self.came([x, y]))
                .filter(|there| self.mask.at(x, y) && there.distance(here) < MOST_CHANGE);
            let weights = 1.0 - (step - share).abs();
            sum += weights.element_product() * there.unwrap_or(here);
        }
        Some(sum)
    }

    fn came(&self, [x, y]: [usize; 2]) -> Vec2 {
        Vec2::new(self.motion.x.at(x, y), -self.motion.y.at(x, y))
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
        // The second has left the picture. Motion is linear, and so is what lies between pixels.
        assert_eq!(now[1], None);
        for i in [0, 2] {
            let expected = middle + (before[i] - middle) * 1.05;
            assert!(
                now[i].is_some_and(|now| now.distance(expected) < 1e-3),
                "{now:?}"
            );
        }
        // Nothing turns as it grows.
        let upright = Vector2Planes {
            x: Plane::filled(200, 200, 0.0),
            y: Plane::filled(200, 200, 1.0),
        };
        let carried = carrier(&mask).directions(&upright, &Memory::default());
        assert!((carried.y.at(90, 130) - 1.0).abs() < 1e-5);
        // A surface that is gone carries no line along.
        let gone = Mask::new(Plane::filled(200, 200, false));
        assert_eq!(carrier(&gone).carried(before[0]), None);
    }
}
