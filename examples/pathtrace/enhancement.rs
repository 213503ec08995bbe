//! Light warping and radiance scaling at one point of a path: the part that another renderer would take over.
//!
//! A renderer needs a frame whose z points back along the incoming ray, and the surface's curvature; the rest is a call
//! or two of `relievo`.

use super::material::PerLobe;
use glam::{Mat3, Vec3};
use relievo::light::light_warping::{Warp, half_vector, warped};
use relievo::light::radiance_scaling::ScalingCurve;
use relievo::params::{Magnitude, RelightParams, ScalingParams, ShapeParams};
use relievo::shape::curvature::mapped_curvature;
use relievo::shape::view_hessian::view_hessian;

/// Bounces at which light is altered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Bounces {
    /// None.
    None,
    /// At the first surface seen.
    First,
    /// Everywhere, so that mirrored things are enhanced as well ([RS] figure 10).
    All,
}

impl Bounces {
    /// Whether the bounce after `before` others is included.
    pub(crate) fn include(self, before: usize) -> bool {
        match self {
            Self::None => false,
            Self::First => before == 0,
            Self::All => true,
        }
    }
}

/// Settings and strengths of the alterations.
#[derive(Debug, Clone)]
pub(crate) struct Enhancement {
    pub(crate) warp: Bounces,
    pub(crate) scale: Bounces,
    /// Scale of sharp features: a ball of this radius has the curvature that is mapped to tanh(2).
    pub(crate) feature: f32,
    /// Warping strength, to be multiplied by that length ([LW] section 5).
    pub(crate) warping: f32,
    /// Magnitudes gamma per lobe ([RS] section 5.2).
    pub(crate) scaling: PerLobe<Magnitude>,
    /// The intensity that stays.
    pub(crate) invariant_point: f32,
    pub(crate) shape: ShapeParams,
}

impl Default for Enhancement {
    fn default() -> Self {
        let (relight, scaling) = (RelightParams::default(), ScalingParams::default());
        let magnitudes = scaling.magnitudes();
        Self {
            warp: Bounces::None,
            scale: Bounces::None,
            feature: 0.03,
            warping: relight.warping.warp,
            scaling: [magnitudes.diffuse, magnitudes.specular],
            invariant_point: scaling.invariant_point,
            shape: ShapeParams::default(),
        }
    }
}

/// Alteration of light at one point, seen from one side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Altered {
    pub(crate) warp: Option<ViewWarp>,
    pub(crate) scale: Option<Scale>,
}

impl Altered {
    /// No alteration.
    pub(crate) const NOT: Self = Self {
        warp: None,
        scale: None,
    };
}

/// A warp of the directions around a line of sight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ViewWarp {
    /// Rotation to the frame whose z points to the eye; its roll about z does not matter.
    view_from_world: Mat3,
    warp: Warp,
    unwarp: Warp,
}

/// Scaling by curvature, per lobe.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    curves: PerLobe<ScalingCurve>,
    invariant_point: f32,
}

impl Enhancement {
    /// The alteration of light after `before` other bounces, at a surface with this normal and this turn of the normal,
    /// seen along `to_eye`.
    #[inline]
    pub(crate) fn at(&self, before: usize, to_eye: Vec3, normal: Vec3, turn: Mat3) -> Altered {
        let (warps, scales) = (self.warp.include(before), self.scale.include(before));
        if !(warps || scales) {
            return Altered::NOT;
        }
        let (x, y) = to_eye.any_orthonormal_pair();
        let world_from_view = Mat3::from_cols(x, y, to_eye);
        let view_from_world = world_from_view.transpose();
        let seen_turn = view_from_world * turn * world_from_view;
        let hessian = view_hessian(seen_turn, view_from_world * normal, &self.shape);
        Altered {
            warp: warps
                .then(|| ViewWarp::new(view_from_world, hessian, self.warping * self.feature)),
            scale: scales.then(|| self.scale_of(hessian)),
        }
    }

    fn scale_of(&self, [xx, _, yy]: [f32; 3]) -> Scale {
        let kappa = mapped_curvature(xx + yy, self.feature);
        Scale {
            curves: self
                .scaling
                .map(|gamma| ScalingCurve::of(gamma.exponent(kappa))),
            invariant_point: self.invariant_point,
        }
    }
}

impl ViewWarp {
    /// The warp of strength `alpha`, a length, where the Hessian is seen.
    pub(crate) fn new(view_from_world: Mat3, hessian: [f32; 3], alpha: f32) -> Self {
        let warp = Warp::of(hessian, alpha);
        Self {
            view_from_world,
            warp,
            unwarp: warp.inverse(),
        }
    }

    /// Direction in which the light assigned to `direction` is looked up: W of [LW] equation 1.
    #[inline]
    pub(crate) fn warped(&self, direction: Vec3) -> Vec3 {
        let seen = self.view_from_world * direction;
        self.world(warped(seen.to_array(), self.warp))
    }

    /// Direction assigned to the light from `to_light`: the inverse of W, with its Jacobian, for [LW] equation 2.
    #[inline]
    pub(crate) fn unwarped(&self, to_light: Vec3) -> (Vec3, f32) {
        let half = half_vector((self.view_from_world * to_light).to_array());
        let direction = self.world(self.unwarp.direction(half));
        (direction, self.unwarp.jacobian(half))
    }

    fn world(&self, seen: [f32; 3]) -> Vec3 {
        self.view_from_world.transpose() * Vec3::from(seen)
    }
}

impl Scale {
    /// sigma of [RS] equation 1 for these intensities.
    #[inline]
    pub(crate) fn factors(&self, intensities: PerLobe<f32>) -> PerLobe<f32> {
        let of = |lobe: usize| self.curves[lobe].at(intensities[lobe], self.invariant_point);
        [of(0), of(1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pathtrace::mesh::outer;

    #[test]
    fn a_ball_is_convex_however_it_is_seen() {
        // Radius of the feature itself: both curvatures together map to tanh(2), and the bright end of a lobe is
        // scaled by e to the power of that.
        let radius = Enhancement::default().feature;
        let style = Enhancement {
            warp: Bounces::All,
            scale: Bounces::First,
            ..Enhancement::default()
        };
        for normal in [
            Vec3::X,
            Vec3::new(0.6, 0.0, 0.8),
            Vec3::new(-0.48, 0.6, 0.64),
        ] {
            let turn = (Mat3::IDENTITY - outer(normal, normal)) * (1.0 / radius);
            for to_eye in [normal, (normal + 0.7 * Vec3::Y).normalize()] {
                let altered = style.at(0, to_eye, normal, turn);
                let factors = altered.scale.unwrap().factors([1.0, 1.0]);
                let expected = 2.0_f32.tanh().exp();
                assert!((factors[0] - expected).abs() < 1e-4, "{factors:?}");
                // A convexity gathers the surroundings of the viewer: light assigned to a sideways direction comes from
                // nearer to the eye.
                let aside = to_eye.any_orthonormal_vector();
                let warp = altered.warp.unwrap();
                assert!(warp.warped(aside).dot(to_eye) > 0.3);
                let (back, jacobian) = warp.unwarped(warp.warped(aside));
                assert!((back - aside).length() < 1e-5 && jacobian > 0.0);
                assert!((warp.warped(to_eye) - to_eye).length() < 1e-5);
                let next = style.at(1, to_eye, normal, turn);
                assert!(next.scale.is_none() && next.warp.is_some());
            }
        }
    }
}
