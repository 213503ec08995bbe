//! Directions in the picture, each equal to its opposite: their mean, and one for want of any.

use crate::frame::SightLines;
use glam::{DVec3, Vec2};

/// The mean of weighted directions that are the same as their opposites: the main axis of the sum of
/// w t t^T. `None` where they cancel.
#[inline]
pub fn mean_direction(directions: impl IntoIterator<Item = (f32, Vec2)>) -> Option<Vec2> {
    // Twice the angle has no sign: (x^2 - y^2, 2 x y) is t turned to it.
    let (mut doubled, mut weights) = (Vec2::ZERO, 0.0);
    for (weight, t) in directions {
        doubled += weight * Vec2::new(t.x * t.x - t.y * t.y, 2.0 * t.x * t.y);
        weights += weight;
    }
    let length = doubled.length();
    let axis = if doubled.x >= 0.0 {
        Vec2::new(doubled.x + length, doubled.y)
    } else {
        Vec2::new(doubled.y, length - doubled.x)
    };
    let is_clear = length > CANCELLED * weights;
    is_clear.then(|| axis.try_normalize())?
}

/// What is left of a sum, as a share of its weights, below which nothing but rounding is.
const CANCELLED: f32 = 1e-3;

/// The direction of a surface that has none of its own and no neighbour with one: the first of the axes
/// x, y, z crossed with the normal that is seen in the picture ([LA] section 4.2). It is the same all
/// over a plane, and turns smoothly over a ball.
#[inline]
pub fn fixed_direction(normal: DVec3, sight: &SightLines, x: f64, y: f64) -> Vec2 {
    [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .filter_map(|axis| axis.cross(normal).try_normalize())
        .find_map(|tangent| sight.picture_direction(x, y, tangent))
        .map_or(Vec2::X, |direction| direction.as_vec2())
}
