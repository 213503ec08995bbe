//! Directions of the larger curvature of a bundle of pixels, lane by lane.

use crate::frame::{DepthKind, direction_seen, line_of, point_on, step_by_normals};
use crate::line::normal_rays::{LocalShape, Noise, NormalRay, Sides, principal_curvatures};
use glam::DVec3;

/// Pixels of a bundle: many for the widest vectors, few for the pixels of a row that need longer steps.
pub(crate) const LANES: usize = 32;

/// Pixels of one row, with those at whose rays each looks.
#[derive(Default)]
#[cfg_attr(test, derive(Debug, PartialEq))]
pub(crate) struct Bundle {
    pub(crate) here: BundlePixels,
    /// Left, right, below and above.
    pub(crate) beside: [BundlePixels; 4],
    /// Distance along x and along y, in pixels.
    pub(crate) steps_px: [[f32; LANES]; 2],
}

/// What pixels show.
#[derive(Default)]
#[cfg_attr(test, derive(Debug, PartialEq))]
pub(crate) struct BundlePixels {
    pub(crate) normal: [[f32; LANES]; 3],
    /// Where points are taken from depth.
    pub(crate) depth: [f32; LANES],
    /// What distinguishes the sight lines of their columns and rows.
    pub(crate) across: [f64; LANES],
    pub(crate) up: [f64; LANES],
    /// 1 for a pixel, 0 for none.
    pub(crate) is_there: [u8; LANES],
}

/// Directions in the picture: unit, x right and y up, or 0.
#[derive(Default)]
pub(crate) struct Directions {
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    pub(crate) forms: [LocalShape; LANES],
}

/// How pixels of a frame become points.
pub(crate) struct PointSource {
    /// The kind of depth that points are taken from; `None`: from normals alone.
    pub(crate) depth: Option<DepthKind>,
    pub(crate) is_perspective: bool,
    /// Height of a pixel over its width.
    pub(crate) pixel_shape: f64,
    /// Deviations of a component of a normal, and of a point as a share of its depth.
    pub(crate) normal_noise: f64,
    pub(crate) offset_noise: f64,
}

/// A pixel of a bundle.
struct BundlePixel {
    normal: DVec3,
    depth: f64,
    line: (DVec3, DVec3),
}

impl BundlePixels {
    #[inline(always)]
    fn at<const IS_PERSPECTIVE: bool>(&self, lane: usize) -> BundlePixel {
        let [x, y, z] = &self.normal;
        BundlePixel {
            normal: DVec3::new(x[lane].into(), y[lane].into(), z[lane].into()),
            depth: self.depth[lane].into(),
            line: line_of(IS_PERSPECTIVE, self.across[lane], self.up[lane]),
        }
    }

    /// The ray in a lane, from `here` by this step.
    #[inline(always)]
    fn ray<const IS_PERSPECTIVE: bool>(
        &self,
        lane: usize,
        here: &BundlePixel,
        step: impl Fn(&BundlePixel, &BundlePixel) -> (bool, DVec3),
    ) -> NormalRay {
        let there = self.at::<IS_PERSPECTIVE>(lane);
        let (is_seen, offset) = step(here, &there);
        NormalRay {
            is_there: is_seen & (self.is_there[lane] != 0),
            offset,
            normal: there.normal,
        }
    }
}

/// Directions of the larger curvature at all lanes.
#[inline(always)]
pub(crate) fn larger_curvature_directions(
    out: &mut Directions,
    bundle: &Bundle,
    source: &PointSource,
) {
    // One loop for each case, without branches.
    match (source.is_perspective, source.depth) {
        (true, Some(DepthKind::Ray)) => {
            directions_by::<true>(out, bundle, source, |here, there| {
                by_depth(here, there, DepthKind::Ray)
            })
        }
        (true, Some(_)) => directions_by::<true>(out, bundle, source, |here, there| {
            by_depth(here, there, DepthKind::Planar)
        }),
        (false, Some(_)) => directions_by::<false>(out, bundle, source, |here, there| {
            by_depth(here, there, DepthKind::Planar)
        }),
        (true, None) => directions_by::<true>(out, bundle, source, |here, there| {
            step_by_normals(true, [here.line, there.line], here.normal + there.normal)
        }),
        (false, None) => directions_by::<false>(out, bundle, source, |here, there| {
            step_by_normals(false, [here.line, there.line], here.normal + there.normal)
        }),
    }
}

#[inline(always)]
fn by_depth(here: &BundlePixel, there: &BundlePixel, kind: DepthKind) -> (bool, DVec3) {
    let point = point_on(there.line, there.depth, kind);
    (true, point - point_on(here.line, here.depth, kind))
}

/// The same with the step to a pixel beside, and whether there is one.
#[inline(always)]
fn directions_by<const IS_PERSPECTIVE: bool>(
    out: &mut Directions,
    bundle: &Bundle,
    source: &PointSource,
    step: impl Fn(&BundlePixel, &BundlePixel) -> (bool, DVec3),
) {
    for lane in 0..LANES {
        let here = bundle.here.at::<IS_PERSPECTIVE>(lane);
        let [left, right, below, above] = &bundle.beside;
        let [steps_x, steps_y] = &bundle.steps_px;
        let along_x = Sides {
            before: left.ray::<IS_PERSPECTIVE>(lane, &here, &step),
            after: right.ray::<IS_PERSPECTIVE>(lane, &here, &step),
            step_px: steps_x[lane].into(),
        };
        let along_y = Sides {
            before: below.ray::<IS_PERSPECTIVE>(lane, &here, &step),
            after: above.ray::<IS_PERSPECTIVE>(lane, &here, &step),
            step_px: steps_y[lane].into(),
        };
        let noise = Noise {
            normal: source.normal_noise,
            offset: source.offset_noise * here.depth,
        };
        let found = principal_curvatures(here.normal, [along_x, along_y], noise);
        let (_, line) = here.line;
        let (is_seen, direction) = direction_seen(line, source.pixel_shape, found.directions[0]);
        let is_known = is_seen & found.form.has_direction();
        out.x[lane] = if is_known { direction.x as f32 } else { 0.0 };
        out.y[lane] = if is_known { direction.y as f32 } else { 0.0 };
        out.forms[lane] = found.form;
    }
}
