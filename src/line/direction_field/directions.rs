//! Directions of patches by their curvature, lane by lane.

use crate::frame::{direction_seen, line_of};
use crate::line::direction_field::forms::LANES;
use crate::line::direction_field::setting::{FACING, FALLBACK, FREE};
use crate::line::direction_field::{CurvatureTensor, calm, doubled};
use crate::line::normal_rays::upright;
use glam::{DVec2, DVec3, Vec2};

/// Patches, one in each lane, with their fallback in `N` fields.
pub(crate) struct Lanes<const N: usize> {
    pub(crate) normal: [[f64; LANES]; 3],
    /// What distinguishes their sight lines.
    pub(crate) line: [[f64; LANES]; 2],
    /// Curvature: the deviator, and the mean.
    pub(crate) form: [[f32; LANES]; 3],
    /// The fallback as twice an angle.
    pub(crate) fallback: [[[f32; LANES]; 2]; N],
}

impl<const N: usize> Default for Lanes<N> {
    fn default() -> Self {
        Self {
            normal: Default::default(),
            line: Default::default(),
            form: Default::default(),
            fallback: [Default::default(); N],
        }
    }
}

/// What is the same for all patches.
pub(crate) struct Source<const N: usize> {
    pub(crate) is_perspective: bool,
    /// Height of a pixel over its width.
    pub(crate) pixel_shape: f64,
    /// The turn of normals, per pixel, that counts half.
    pub(crate) doubt: f64,
    /// What each field follows: 0 the larger curvature, 1 the lesser.
    pub(crate) families: [usize; N],
}

/// The direction of each lane, as twice its angle, with its confidence, in `N` fields.
pub(crate) type Directions<const N: usize> = [[[f32; LANES]; 3]; N];

/// The directions of patches, each as long as it is sure, and on flat ones that of the fallback.
#[inline(always)]
pub(crate) fn patch_directions<const N: usize>(
    out: &mut Directions<N>,
    patches: &Lanes<N>,
    source: &Source<N>,
) {
    // One loop for each case, without branches.
    match source.is_perspective {
        true => directions_by::<N, true>(out, patches, source),
        false => directions_by::<N, false>(out, patches, source),
    }
}

#[inline(always)]
fn directions_by<const N: usize, const IS_PERSPECTIVE: bool>(
    out: &mut Directions<N>,
    patches: &Lanes<N>,
    source: &Source<N>,
) {
    let Lanes {
        normal,
        line: [across, up],
        form: [x, y, mean],
        fallback,
    } = patches;
    for lane in 0..LANES {
        let normal = DVec3::new(normal[0][lane], normal[1][lane], normal[2][lane]);
        let (_, line) = line_of(IS_PERSPECTIVE, across[lane], up[lane]);
        let form = CurvatureTensor {
            deviator: DVec2::new(x[lane].into(), y[lane].into()),
            mean: mean[lane].into(),
        };
        let (is_turned, larger) = form.larger();
        let (faces, [a, b]) = upright(normal);
        let facing = (-normal.dot(line) / line.length() / FACING).clamp(0.0, 1.0);
        let sure = form.confidence(source.doubt) * (facing * facing);
        let flat = form.flatness(source.doubt) as f32;
        for n in 0..N {
            let axis = match source.families[n] {
                0 => larger,
                _ => larger.perp(),
            };
            let tangent = axis.x * a + axis.y * b;
            let (is_seen, seen) = direction_seen(line, source.pixel_shape, tangent);
            let own = sure as f32 * doubled(seen.as_vec2());
            let is_known = is_turned & faces & is_seen;
            let own = Vec2::new(
                if is_known { own.x } else { 0.0 },
                if is_known { own.y } else { 0.0 },
            );
            out[n][0][lane] = own.x + flat * fallback[n][0][lane];
            out[n][1][lane] = own.y + flat * fallback[n][1][lane];
            out[n][2][lane] = own.length() + flat;
        }
    }
}

/// Directions of patches averaged near them, with their confidence, and those around; as twice angles.
#[derive(Default)]
pub(crate) struct Averaged {
    pub(crate) own: [[f32; LANES]; 3],
    pub(crate) around: [[f32; LANES]; 2],
}

/// [`calm`] of each lane.
#[inline(always)]
pub(crate) fn calm_patches(out: &mut [[f32; LANES]; 2], averaged: &Averaged) {
    let Averaged { own, around } = averaged;
    for lane in 0..LANES {
        let own = [own[0][lane], own[1][lane], own[2][lane], 1.0];
        let around = [around[0][lane], around[1][lane], 1.0, 1.0];
        [out[0][lane], out[1][lane]] = calm(own, around);
    }
}

/// Adds the fallback where a direction is unsure, and makes it unit; all as twice angles.
#[inline(always)]
pub(crate) fn settle_patches(directions: &mut [[f32; LANES]; 2], fallback: &[[f32; LANES]; 2]) {
    for lane in 0..LANES {
        let own = Vec2::new(directions[0][lane], directions[1][lane]);
        let last = Vec2::new(fallback[0][lane], fallback[1][lane]);
        let share = 1.0 - own.length() / FREE;
        let led = own + FALLBACK * share * last;
        let sum = [(led.x, own.x), (led.y, own.y)];
        let [x, y] = sum.map(|(led, own)| if share > 0.0 { led } else { own });
        let over_length = Vec2::new(x, y).length_recip();
        let has_length = (over_length > 0.0) & (over_length < f32::INFINITY);
        directions[0][lane] = if has_length { x * over_length } else { last.x };
        directions[1][lane] = if has_length { y * over_length } else { last.y };
    }
}
