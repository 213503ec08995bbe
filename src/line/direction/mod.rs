//! Directions in the picture, each equal to its opposite: their mean, and the fallback without any.

pub(crate) mod fill;

use crate::frame::SightLines;
use glam::{DVec3, Vec2};

/// The mean of weighted directions that equal their opposites: the main axis of the sum of w t t^T. `None` if they
/// cancel.
#[inline]
pub(crate) fn mean_direction(directions: impl IntoIterator<Item = (f32, Vec2)>) -> Option<Vec2> {
    // Twice the angle has no sign: (x^2 - y^2, 2 x y) is t rotated by its own angle.
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

/// Length of a sum, relative to its weights, below which only rounding is left after cancellation.
const CANCELLED: f32 = 1e-3;

/// Pixels over which the direction of a plane turns from its neighbours' to the fixed one.
pub(crate) const PLANE_MARGIN_PX: usize = 16;

/// The same for pixels of a curved surface that have no direction of their own.
pub(crate) const SURFACE_MARGIN_PX: usize = 64;

/// The same for pixels on edges.
pub(crate) const EDGE_MARGIN_PX: usize = 16;

/// Longest distance that filled directions spread, in pixels.
pub(crate) const FILL_REACH_PX: usize = PLANE_MARGIN_PX + SURFACE_MARGIN_PX + EDGE_MARGIN_PX;

/// The direction of a surface with none of its own and no neighbour with one: the first of the axes x, y, z crossed
/// with the normal that is visible in the picture ([LA] section 4.2). It is constant over a plane, and turns smoothly
/// over a ball.
#[inline]
pub(crate) fn fixed_direction(normal: DVec3, sight: &SightLines, x: f64, y: f64) -> Vec2 {
    fixed_tangents(normal)
        .find_map(|tangent| sight.picture_direction(x, y, tangent))
        .map_or(Vec2::X, |direction| direction.as_vec2())
}

/// The axes x, y, z in turn, except those along the unit `normal`, crossed with it: unit tangents.
#[inline]
pub(crate) fn fixed_tangents(normal: DVec3) -> impl Iterator<Item = DVec3> {
    [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .map(move |axis| axis.cross(normal))
        .filter(|tangent| tangent.length_squared() > ALONG * ALONG)
        .filter_map(DVec3::try_normalize)
}

/// Sine of the angle to a normal, about a degree, below which an axis counts as parallel: the rest is noise.
const ALONG: f64 = 0.02;

/// The direction at right angles, on the surface, to [`fixed_direction`].
#[inline]
pub(crate) fn fixed_second_direction(normal: DVec3, sight: &SightLines, x: f64, y: f64) -> Vec2 {
    fixed_tangents(normal)
        .find(|&tangent| sight.picture_direction(x, y, tangent).is_some())
        .and_then(|tangent| sight.picture_direction(x, y, normal.cross(tangent).try_normalize()?))
        .map_or(Vec2::X, |direction| direction.as_vec2())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn opposites_are_the_same_and_squares_cancel() {
        let t = Vec2::from_angle(0.3);
        let mean = mean_direction([(1.0, t), (1.0, -t)]).unwrap();
        assert!(mean.perp_dot(t).abs() < 1e-6);
        assert_eq!(mean_direction([(1.0, t), (1.0, t.perp())]), None);
        assert_eq!(mean_direction([]), None);
        // 170 and 10 degrees: 0, not 90.
        let [a, b] = [170.0_f32, 10.0].map(|angle| Vec2::from_angle(angle.to_radians()));
        assert!(mean_direction([(1.0, a), (1.0, b)]).unwrap().y.abs() < 1e-6);
    }

    #[test]
    fn the_fixed_direction_is_upright_unless_that_points_at_the_eye() {
        let sight = SightLines::parallel(1.0);
        let fixed = |n: DVec3| fixed_direction(n.normalize(), &sight, 0.5, 0.5).as_dvec2();
        assert!(fixed(DVec3::new(0.3, -0.5, 0.7)).perp_dot(DVec2::Y).abs() < 1e-6);
        // Seen from the side: x crossed with y is z, so y crossed with it serves, or z.
        for normal in [DVec3::X, DVec3::Y, DVec3::new(0.6, 0.8, 0.0)] {
            assert!((fixed(normal).length() - 1.0).abs() < 1e-6, "{normal}");
        }
    }
}
