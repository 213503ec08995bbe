//! View-centred curvature of a known surface, for renderers without a picture yet.

use crate::params::ShapeParams;
use glam::{Mat3, Vec3};

/// The Hessian [xx, xy, yy] in the view, convex **negative**, of a surface with the unit normal `normal` and the shape
/// operator `turn`, both in a frame whose z points to the eye.
///
/// `turn` times a tangent step is the change of the unit normal along it: I/R on a ball of radius R with outward
/// normals. From the symmetric world-space matrix, `turn` in the view frame is `V turn V^T`. The result is per unit
/// length of `turn`, where the kernels of a picture use pixels: the gain or the warping strength used with it is a
/// length.
///
/// A step along x of the picture is the tangent `(1, 0, g_x)`, `g = -n_xy / n_z`, and changes the normal by `dn = turn
/// (1, 0, g_x)`. So the gradient `-n_xy / n_z^f` of [RS] section 4, with f = `params.foreshortening`, has the
/// derivative `-(dn_xy - f n_xy dn_z / n_z) / n_z^f`; the same for y, and symmetrised. At f = 1 that is the second
/// derivative of the height, at f = 0 its trace is the sum of both curvatures of the surface itself. `n_z` is floored
/// at `params.min_nz`, as in [`super::gradient::depth_gradient`].
#[inline]
pub fn view_hessian(turn: Mat3, normal: Vec3, params: &ShapeParams) -> [f32; 3] {
    let facing = normal.z.max(params.min_nz);
    let slope = -normal.truncate() / facing;
    let f = params.foreshortening;
    let steepness = if f == 0.0 { 1.0 } else { facing.powf(-f) };
    let derivative = |step: Vec3| {
        let dn = turn * step;
        -steepness * (dn.truncate() + f * slope * dn.z)
    };
    let along_x = derivative(Vec3::new(1.0, 0.0, slope.x));
    let along_y = derivative(Vec3::new(0.0, 1.0, slope.y));
    [along_x.x, 0.5 * (along_x.y + along_y.x), along_y.y]
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

    /// The projection onto tangents, divided by the radius.
    fn ball(normal: Vec3, radius: f32) -> Mat3 {
        let outer = Mat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        (Mat3::IDENTITY - outer) * (1.0 / radius)
    }

    #[test]
    fn a_ball_has_the_trace_of_the_closed_form() {
        // The gradient is (x, y) z^-f / R^(1-f) with opposite sign, z^2 = R^2 - x^2 - y^2; its divergence is -[2 n_z^-f
        // + f (1 - n_z^2) n_z^-(f + 2)] / R. That is -2/R everywhere at f = 0.
        let radius = 3.0;
        for n_z in [1.0_f32, 0.5, 0.2, 0.1] {
            for f in [0.0_f32, 0.4, 1.0] {
                let across = (1.0 - n_z * n_z).sqrt();
                let normal = Vec3::new(0.6 * across, -0.8 * across, n_z);
                let [xx, _, yy] = view_hessian(ball(normal, radius), normal, &params(f));
                let expected = 2.0 * n_z.powf(-f) + f * (1.0 - n_z * n_z) * n_z.powf(-f - 2.0);
                let found = -(xx + yy) * radius;
                assert!(
                    (found / expected - 1.0).abs() < 2e-5,
                    "{found}, not {expected}"
                );
            }
        }
    }

    /// Gradient of the height `0.3 x^2 - 0.5 x y + 0.2 y^2 + 0.4 x - 0.7 y` at (x, y).
    fn slope(x: f64, y: f64) -> [f64; 2] {
        [0.6 * x - 0.5 * y + 0.4, -0.5 * x + 0.4 * y - 0.7]
    }

    #[test]
    fn at_full_foreshortening_it_is_the_second_derivative_of_the_height() {
        // The shape operator of a height field: minus the derivative of the unit normal for tangent steps. With N =
        // (-z_x, -z_y, 1)/W and tangents t_x, t_y it is B G^-1, B_ij = -z_ij / W, in the basis of tangents; as a 3x3
        // matrix, sum over i, j of t_i (G^-1 B G^-1)_ij t_j^T, which is the meaning of `turn`.
        let [gx, gy] = slope(0.0, 0.0).map(|v| v as f32);
        let normal = Vec3::new(-gx, -gy, 1.0).normalize();
        let (tx, ty) = (Vec3::new(1.0, 0.0, gx), Vec3::new(0.0, 1.0, gy));
        let second = [0.6_f32, -0.5, 0.4];
        let metric = glam::Mat2::from_cols_array(&[tx.dot(tx), tx.dot(ty), tx.dot(ty), ty.dot(ty)]);
        let height = glam::Mat2::from_cols_array(&[second[0], second[1], second[1], second[2]]);
        let inner = metric.inverse() * (height * -normal.z) * metric.inverse();
        let outer = |a: Vec3, b: Vec3| Mat3::from_cols(a * b.x, a * b.y, a * b.z);
        let turn = outer(tx, tx) * inner.col(0).x
            + (outer(tx, ty) + outer(ty, tx)) * inner.col(0).y
            + outer(ty, ty) * inner.col(1).y;
        let found = view_hessian(turn, normal, &params(1.0));
        for (found, expected) in found.into_iter().zip(second) {
            assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
        }
        // Without foreshortening the gradient is -n_xy: its derivative by finite differences, in f64.
        let unfolded = |x: f64, y: f64| {
            let [a, b] = slope(x, y);
            let length = (a * a + b * b + 1.0).sqrt();
            [a / length, b / length]
        };
        let h = 1e-5;
        let difference =
            |i: usize, x: f64, y: f64| (unfolded(x, y)[i] - unfolded(-x, -y)[i]) / (2.0 * h);
        let expected = [
            difference(0, h, 0.0),
            0.5 * (difference(1, h, 0.0) + difference(0, 0.0, h)),
            difference(1, 0.0, h),
        ];
        let found = view_hessian(turn, normal, &params(0.0));
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (f64::from(found) - expected).abs() < 1e-5,
                "{found}, not {expected}"
            );
        }
    }

    #[test]
    fn grazing_surfaces_stay_finite() {
        for normal in [Vec3::X, Vec3::new(0.6, 0.0, -0.8), Vec3::NEG_Z] {
            for f in [0.0, 0.5, 1.0] {
                let hessian = view_hessian(ball(normal, 1.0), normal, &params(f));
                assert!(hessian.iter().all(|h| h.is_finite()), "{hessian:?}");
            }
        }
    }
}
