//! Raking light by region: the azimuth from which most of the detail around each pixel is seen.
//!
//! Light across ridges shows them, light along them hides them. The structure tensor of the slopes' detail (J. Bigun, G. H.
//! Granlund: Optimal Orientation Detection of Linear Symmetry, ICCV 1987), as a vector of twice the angle, has the azimuth
//! in which most detail slopes. A share of the given light is added to it, so that where nothing has a direction the light
//! stays. Which of both sides is the one nearer to the given light; where both are as near, neighbours agree on one, those with
//! more detail above all. The azimuths are blended, so that regions have no borders.
//!
//! All lamps are turned alike, as the first of them is: key and fill stay apart.

use crate::frame::percentile::percentile;
use crate::frame::rows::ROWS_PER_TASK;
use crate::frame::{Plane, Vector2Planes, Vector3Planes, parallel_rows};
use crate::light::lights::DirectionalLight;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::shape::coarse_normals::sweeps;
use crate::shape::diffusion::cpu::diffusion;
use crate::shape::diffusion::medium::Medium;
use crate::shape::diffusion::stage::in_tile;
use glam::Vec2;
use rayon::prelude::*;

/// The scales between which slopes are detail, sigmas in pixels.
const DETAIL_PX: [f32; 2] = [2.0, 10.0];

/// Sigmas in pixels of the region whose detail counts, and of the blend of azimuths.
const REGION_PX: f32 = 15.0;
const BLEND_PX: f32 = 7.5;

/// What the given light counts for beside the detail, as a share of that of the pixel with more than this percentage. With
/// the median, bare ground between marks is lit from all sides; with nine tenths, a cliff would leave marks as they were.
const PRIOR: f32 = 0.4;
const PRIOR_PERCENT: u32 = 75;

/// How often neighbours look at each other's side.
const AGREEING: usize = 2;

/// The length of blended azimuths below which the given one is added.
const SURE: f32 = 0.35;

/// Floor of n_z in slopes.
const FLATTEST: f32 = 0.05;

/// Its name in timings and in a session.
const NAME: &str = "raking";

/// How far samples reach.
pub(crate) fn reach(plan: &Plan) -> usize {
    let [detail, region, blend] =
        [&DETAIL_PX[..], &[REGION_PX], &[BLEND_PX]].map(|sigmas| sweeps(plan, sigmas).count());
    detail + (1 + AGREEING) * region + blend
}

/// The turn of lamps about the view axis at every pixel, as cosine and sine, for the first of these.
pub(crate) fn turns(
    run: &mut Execution,
    normal: &Vector3Planes,
    lamps: &[DirectionalLight],
) -> Option<Vector2Planes> {
    let given = lamps.first()?.to_light.truncate().try_normalize()?;
    Some(run.timed_on(NAME, |run| {
        let mask = &run.frame.mask;
        let [axes, strength] = structure(detail(run, normal));
        let mut spread = [axes, strength].map(|field| blurred(run, field, &[REGION_PX]).remove(0));
        let [axes, strength] = &mut spread;
        let much = percentile(mask, PRIOR_PERCENT, |x, y| Some(strength.x.at(x, y)));
        let prior = PRIOR * much.unwrap_or(0.0) * doubled(given);
        each(axes, strength, |axis, _| nearer(axis + prior, given));
        for _ in 0..AGREEING {
            let mut weighted = axes.clone();
            each(&mut weighted, strength, |azimuth, strength| {
                strength.x * azimuth
            });
            let around = blurred(run, weighted, &[REGION_PX]).remove(0);
            each(axes, &around, |azimuth, around| {
                azimuth * azimuth.dot(around).signum()
            });
        }
        let [axes, strength] = spread;
        let mut blended = blurred(run, axes, &[BLEND_PX]).remove(0);
        each(&mut blended, &strength, |azimuth, _| {
            let azimuth = azimuth + (SURE - azimuth.length()).max(0.0) * given;
            let azimuth = azimuth.try_normalize().unwrap_or(given);
            Vec2::new(given.dot(azimuth), given.perp_dot(azimuth))
        });
        blended
    }))
}

/// A vector of twice the angle, of the same length.
fn doubled(v: Vec2) -> Vec2 {
    let length = v.length().max(f32::MIN_POSITIVE);
    Vec2::new(v.x * v.x - v.y * v.y, 2.0 * v.x * v.y) / length
}

/// The unit vector of half the angle, on the side of `given`; that itself where there is none.
fn nearer(axis: Vec2, given: Vec2) -> Vec2 {
    let Some(axis) = axis.try_normalize() else {
        return given;
    };
    let half = Vec2::new(0.5 * (1.0 + axis.x), 0.5 * (1.0 - axis.x)).max(Vec2::ZERO);
    let half = Vec2::new(half.x.sqrt(), half.y.sqrt().copysign(axis.y));
    if half.dot(given) < 0.0 { -half } else { half }
}

/// Changes every vector of a field, beside one of another.
fn each(
    field: &mut Vector2Planes,
    beside: &Vector2Planes,
    change: impl Fn(Vec2, Vec2) -> Vec2 + Sync,
) {
    parallel_rows([&mut field.x, &mut field.y])
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(y, [to_x, to_y])| {
            let beside = beside.x.row(y).iter().zip(beside.y.row(y));
            for ((to_x, to_y), (&x, &y)) in to_x.iter_mut().zip(to_y).zip(beside) {
                let changed = change(Vec2::new(*to_x, *to_y), Vec2::new(x, y));
                (*to_x, *to_y) = (changed.x, changed.y);
            }
        });
}

/// The slopes finer than the coarser scale and coarser than the finer one.
fn detail(run: &Execution, normal: &Vector3Planes) -> Vector2Planes {
    let mut slopes = run.memory.vectors(&run.frame.mask);
    parallel_rows([&mut slopes.x, &mut slopes.y])
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(y, [to_x, to_y])| {
            let [nx, ny, nz] = [&normal.x, &normal.y, &normal.z].map(|plane| plane.row(y));
            for x in 0..to_x.len() {
                let per_z = 1.0 / nz[x].max(FLATTEST);
                (to_x[x], to_y[x]) = (nx[x] * per_z, ny[x] * per_z);
            }
        });
    let mut scales = blurred(run, slopes, &DETAIL_PX);
    let (coarse, mut fine) = (scales.remove(1), scales.remove(0));
    each(&mut fine, &coarse, |fine, coarse| fine - coarse);
    fine
}

/// The directions that detail slopes in, as vectors of twice the angle, and how much it does, as the first component.
fn structure(detail: Vector2Planes) -> [Vector2Planes; 2] {
    let (mut axes, mut strength) = (detail.clone(), detail);
    each(&mut axes, &strength, |d, _| {
        Vec2::new(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y)
    });
    each(&mut strength, &axes, |d, _| {
        Vec2::new(d.length_squared(), 0.0)
    });
    [axes, strength]
}

/// A field blurred within the mask by Gaussians of these sigmas.
fn blurred(run: &Execution, field: Vector2Planes, sigmas_px: &[f32]) -> Vec<Vector2Planes> {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let (mask, options) = (&frame.mask, &run.runner.options);
    let open = Plane::filled(mask.width(), mask.height(), 1.0);
    let medium = Medium::of_whole(&open, mask);
    let sweeps = sweeps(plan, sigmas_px);
    let Some(tile) = plan.tile else {
        return diffusion(field, medium, &sweeps, options, memory).scales;
    };
    let memory = &memory.at_other_size();
    let spread = in_tile(field, medium, tile, frame.data_window, |field, medium| {
        diffusion(field, medium, &sweeps, options, memory)
    });
    spread.scales
}
