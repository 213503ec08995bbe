//! Tensors of curvature of patches, lane by lane.

use crate::frame::{line_of, step_by_normals};
use crate::line::normal_rays::{Local, NormalRay, Sides, Slopes, upright};
use glam::DVec3;

/// Patches that are looked at together.
pub(crate) const LANES: usize = 16;

/// Patches with those beside each.
#[derive(Default)]
pub(crate) struct Neighbourhoods {
    pub(crate) here: Lanes,
    /// Left, right, below and above.
    pub(crate) beside: [Lanes; 4],
}

/// Patches, one in each lane.
#[derive(Default)]
pub(crate) struct Lanes {
    pub(crate) normal: [[f64; LANES]; 3],
    /// What distinguishes their sight lines.
    pub(crate) line: [[f64; LANES]; 2],
    /// 1 for a patch, 0 for none.
    pub(crate) is_there: [u8; LANES],
}

/// What is the same for all patches.
pub(crate) struct PatchSource {
    pub(crate) is_perspective: bool,
    /// Side of a cell, in pixels.
    pub(crate) step_px: f64,
    /// Pixels per unit of length.
    pub(crate) pixels: f64,
}

/// The tensor of each lane, per pixel; 0 where it is not known.
#[derive(Default)]
pub(crate) struct Tensors {
    /// The deviator.
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    pub(crate) mean: [f32; LANES],
}

/// A patch of a lane.
struct Seen {
    normal: DVec3,
    line: (DVec3, DVec3),
}

impl Lanes {
    #[inline(always)]
    fn at<const IS_PERSPECTIVE: bool>(&self, lane: usize) -> Seen {
        let ([x, y, z], [across, up]) = (&self.normal, &self.line);
        Seen {
            normal: DVec3::new(x[lane], y[lane], z[lane]),
            line: line_of(IS_PERSPECTIVE, across[lane], up[lane]),
        }
    }

    /// The ray in a lane, seen from `here`.
    #[inline(always)]
    fn ray<const IS_PERSPECTIVE: bool>(&self, lane: usize, here: &Seen) -> NormalRay {
        let there = self.at::<IS_PERSPECTIVE>(lane);
        let lines = [here.line, there.line];
        let (is_seen, offset) = step_by_normals(IS_PERSPECTIVE, lines, here.normal + there.normal);
        NormalRay {
            is_there: is_seen & (self.is_there[lane] != 0),
            offset,
            normal: there.normal,
        }
    }
}

/// The tensors of curvature at all lanes: in the frame that coincides with the picture's when the normal is rotated to
/// the viewer by the shortest way, so that those of neighbours can be averaged.
///
/// Not known where an axis has no usable ray, the surface is seen edge-on, or the normal points straight away from the
/// viewer.
#[inline(always)]
pub(crate) fn patch_tensors(out: &mut Tensors, around: &Neighbourhoods, source: &PatchSource) {
    // One loop for each case, without branches.
    match source.is_perspective {
        true => tensors_by::<true>(out, around, source),
        false => tensors_by::<false>(out, around, source),
    }
}

#[inline(always)]
fn tensors_by<const IS_PERSPECTIVE: bool>(
    out: &mut Tensors,
    around: &Neighbourhoods,
    source: &PatchSource,
) {
    let [left, right, below, above] = &around.beside;
    for lane in 0..LANES {
        let here = around.here.at::<IS_PERSPECTIVE>(lane);
        let (faces, tangents) = upright(here.normal);
        let local = Local {
            tangents,
            normal: here.normal,
        };
        let along_x = Sides {
            before: left.ray::<IS_PERSPECTIVE>(lane, &here),
            after: right.ray::<IS_PERSPECTIVE>(lane, &here),
            step_px: source.step_px,
        };
        let along_y = Sides {
            before: below.ray::<IS_PERSPECTIVE>(lane, &here),
            after: above.ray::<IS_PERSPECTIVE>(lane, &here),
            step_px: source.step_px,
        };
        let slopes = Slopes::of(&local.difference(&along_x), &local.difference(&along_y));
        let x = (slopes.half_difference / source.pixels) as f32;
        let y = (slopes.off / source.pixels) as f32;
        let mean = (slopes.mean / source.pixels) as f32;
        let sizes = x.abs() + y.abs() + mean.abs();
        let is_known = faces & slopes.is_there & (sizes < f32::INFINITY);
        out.x[lane] = if is_known { x } else { 0.0 };
        out.y[lane] = if is_known { y } else { 0.0 };
        out.mean[lane] = if is_known { mean } else { 0.0 };
    }
}
