//! The depth gradient: slope of the surface toward the viewer, from its normal.

use crate::frame::facing;
use crate::kernel::fast_math::{exp, ln};
use crate::params::ShapeParams;
use glam::{Vec2, Vec3};

/// Depth gradient (slope, dimensionless, y up) of a surface with view-space unit normal `n`, seen
/// from an eye in the direction (`to_eye`, 1).
///
/// `g = -n_xy / (n . v)^f`: the gradient of the height toward the viewer. Source: [RS] section 4. Departs from it:
/// n_z is replaced by `n . v` with v scaled to v_z = 1, so that slopes diverge at perspective silhouettes rather than
/// at the plane n_z = 0; and it is floored at `min_nz` before the power, so a grazing surface gives a steep finite
/// slope.
#[inline(always)]
pub fn depth_gradient(n: Vec3, to_eye: Vec2, params: &ShapeParams) -> Vec2 {
    let facing = facing(n, to_eye).max(params.min_nz);
    let f = params.foreshortening;
    let steepness = if f == 0.0 {
        1.0
    } else if f == 1.0 {
        facing.recip()
    } else {
        exp(-f * ln(facing))
    };
    -n.truncate() * steepness
}

/// [`depth_gradient`] of the pixels of a row, 0 where uncovered. The direction to the eye is given by its x per column
/// and its y for the row.
#[inline(always)]
pub(crate) fn depth_gradient_row(
    out: [&mut [f32]; 2],
    normal: [&[f32]; 3],
    covered: &[bool],
    to_eye: (&[f32], f32),
    params: &ShapeParams,
) {
    let [out_x, out_y] = out;
    let n = out_x.len();
    let (out_y, covered) = (&mut out_y[..n], &covered[..n]);
    let [nx, ny, nz] = normal.map(|row| &row[..n]);
    let (to_eye_x, to_eye_y) = (&to_eye.0[..n], to_eye.1);
    for x in 0..n {
        let n = Vec3::new(nx[x], ny[x], nz[x]);
        let g = depth_gradient(n, Vec2::new(to_eye_x[x], to_eye_y), params);
        out_x[x] = if covered[x] { g.x } else { 0.0 };
        out_y[x] = if covered[x] { g.y } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params(foreshortening: f32) -> ShapeParams {
        ShapeParams {
            foreshortening,
            ..ShapeParams::default()
        }
    }

    #[test]
    fn a_slope_up_to_the_right_has_a_positive_x_gradient() {
        // Height x/2 rises to the right; its normal leans left: (-1, 0, 2)/sqrt(5).
        let n = Vec3::new(-1.0, 0.0, 2.0).normalize();
        assert!(
            (depth_gradient(n, Vec2::ZERO, &params(1.0)) - Vec2::new(0.5, 0.0)).length() < 1e-6
        );
        // Without foreshortening the slope is -n_x.
        assert!((depth_gradient(n, Vec2::ZERO, &params(0.0)).x + n.x).abs() < 1e-7);
    }

    #[test]
    fn grazing_and_backward_normals_give_a_bounded_slope() {
        for n in [Vec3::X, Vec3::new(0.8, 0.0, -0.6), Vec3::NEG_Z] {
            let g = depth_gradient(n, Vec2::ZERO, &params(1.0));
            assert!(g.is_finite() && g.length() <= 1.0 / ShapeParams::default().min_nz);
        }
    }

    #[test]
    fn the_floor_lies_at_the_perspective_silhouette() {
        // Seen 45 degrees off the axis, a surface facing the eye has n . v = |v| although n_z < 1.
        let to_eye = Vec2::new(-1.0, 0.0);
        let n = Vec3::new(-1.0, 0.0, 1.0).normalize();
        let g = depth_gradient(n, to_eye, &params(1.0));
        // -n_x / (n . v) = 0.7071 / 1.4142.
        assert!((g.x - 0.5).abs() < 1e-6);
    }
}
