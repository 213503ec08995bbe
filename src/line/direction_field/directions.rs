//! Curvature of patches, and their directions by it.

use crate::frame::{SightLines, direction_seen, step_by_normals};
use crate::line::direction_field::patches::Patch;
use crate::line::direction_field::setting::{FACING, FALLBACK, FREE};
use crate::line::direction_field::{CurvatureTensor, Weighted, doubled};
use crate::line::normal_rays::{Local, NormalRay, RaySlopes, Sides, upright};
use glam::{DVec2, DVec3, Vec2};

/// A patch as it is seen.
#[derive(Clone, Copy)]
pub(crate) struct SeenPatch<'a> {
    sight: &'a SightLines,
    normal: DVec3,
    /// Its sight line.
    line: (DVec3, DVec3),
}

impl<'a> SeenPatch<'a> {
    #[inline]
    pub(crate) fn new(patch: &Patch, sight: &'a SightLines) -> Self {
        Self {
            sight,
            normal: patch.normal,
            line: sight.line(patch.at.x, patch.at.y),
        }
    }

    /// The ray of another patch.
    #[inline]
    fn ray(&self, there: SeenPatch) -> NormalRay {
        let (lines, normals) = ([self.line, there.line], self.normal + there.normal);
        let (is_there, offset) = step_by_normals(self.sight.is_perspective(), lines, normals);
        NormalRay {
            is_there,
            offset,
            normal: there.normal,
        }
    }

    /// The tensor of curvature, per unit of length, from the patches left, right, below and above, by number, each
    /// `step_px` away: in the frame that coincides with the picture's when the normal is rotated to the viewer by the
    /// shortest way, so that those of neighbours can be averaged.
    ///
    /// Not known where an axis has no usable ray, the surface is seen edge-on, or the normal points straight away from the
    /// viewer.
    #[inline]
    pub(crate) fn slopes<'b>(
        &self,
        beside: impl Fn(usize) -> Option<SeenPatch<'b>>,
        step_px: f64,
    ) -> Option<RaySlopes> {
        let (faces, tangents) = upright(self.normal);
        let local = Local {
            tangents,
            normal: self.normal,
        };
        let along = |before: usize, after: usize| {
            let ray = |number: usize| Some(self.ray(beside(number)?));
            local.difference(&Sides::of([ray(before), ray(after)], step_px))
        };
        let slopes = RaySlopes::of(&along(0, 1), &along(2, 3));
        (faces && slopes.is_there).then_some(slopes)
    }

    /// The directions of the larger curvature, family 0, and of the lesser, 1, as twice their angles and as long as they
    /// are sure, with their confidence; on flat patches those of the `fallback`. `doubt` is the turn of normals, per pixel,
    /// that counts half.
    #[inline]
    pub(crate) fn directions<const N: usize>(
        &self,
        form: &CurvatureTensor,
        doubt: f64,
        families: [usize; N],
        fallback: [Vec2; N],
    ) -> [Weighted; N] {
        let (_, line) = self.line;
        let (is_turned, larger) = form.larger();
        let (faces, [a, b]) = upright(self.normal);
        let facing = (-self.normal.dot(line) / line.length() / FACING).clamp(0.0, 1.0);
        let sure = form.confidence(doubt) * (facing * facing);
        let flat = form.flatness(doubt) as f32;
        std::array::from_fn(|n| {
            let axis = match families[n] {
                0 => larger,
                _ => larger.perp(),
            };
            let tangent = axis.x * a + axis.y * b;
            let (is_seen, seen) = direction_seen(line, self.sight.pixel_shape(), tangent);
            let own = match is_turned && faces && is_seen {
                true => sure as f32 * doubled(seen.as_vec2()),
                false => Vec2::ZERO,
            };
            let led = own + flat * fallback[n];
            [led.x, led.y, own.length() + flat, 1.0]
        })
    }
}

impl CurvatureTensor {
    /// As it is averaged.
    pub(crate) fn of(&[x, y, mean, _]: &Weighted) -> Self {
        Self {
            deviator: DVec2::new(x.into(), y.into()),
            mean: mean.into(),
        }
    }
}

/// A direction with the fallback where it is unsure, made unit; all as twice angles.
pub(crate) fn settled(own: Vec2, fallback: Vec2) -> Vec2 {
    let share = 1.0 - own.length() / FREE;
    let led = match share > 0.0 {
        true => own + FALLBACK * share * fallback,
        false => own,
    };
    led.try_normalize().unwrap_or(fallback)
}
