//! Raking light by region: the azimuth from which most of the detail around each pixel is seen.
//!
//! Light across ridges shows them, light along them hides them. The structure tensor of the slopes' detail (J. Bigun, G. H.
//! Granlund: Optimal Orientation Detection of Linear Symmetry, ICCV 1987), as a vector of twice the angle, has the azimuth
//! in which most detail slopes. A share of the given light is added to it, so that where nothing has a direction the light
//! stays, and neighbours flip to the other side in fewer than one pixel of a thousand; which of both sides is the one nearer
//! to the given light. The azimuths are blended, so that regions have no borders.
//!
//! All lamps are turned alike, as the first of them is: key and fill stay apart.

use crate::frame::percentile::percentile;
use crate::frame::rows::ROWS_PER_TASK;
use crate::frame::{Mask, Plane, Vector2Planes, Vector3Planes, parallel_rows};
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

/// What the given light counts for beside the detail, as a share of the median of that.
const PRIOR: f32 = 0.4;

/// The length of blended azimuths below which the given one is added.
const SURE: f32 = 0.35;

/// Floor of n_z in slopes.
const FLATTEST: f32 = 0.05;

/// Its name in timings and in a session.
const NAME: &str = "raking";

/// How far samples reach.
pub(crate) fn reach(plan: &Plan) -> usize {
    let all = [&DETAIL_PX[..], &[REGION_PX], &[BLEND_PX]];
    all.iter().map(|sigmas| sweeps(plan, sigmas).count()).sum()
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
        let detail = detail(run, normal);
        let [axes, strength] = structure(detail, mask);
        let mut spread = [axes, strength].map(|field| blurred(run, field, &[REGION_PX]).remove(0));
        let [axes, strength] = &mut spread;
        let median = percentile(mask, 50, |x, y| Some(strength.x.at(x, y)));
        let prior = PRIOR * median.unwrap_or(0.0) * doubled(given);
        each(axes, |axis| nearer(axis + prior, given));
        let [axes, _] = spread;
        let mut blended = blurred(run, axes, &[BLEND_PX]).remove(0);
        each(&mut blended, |azimuth| {
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

/// Changes every vector of a field.
fn each(field: &mut Vector2Planes, change: impl Fn(Vec2) -> Vec2 + Sync) {
    parallel_rows([&mut field.x, &mut field.y])
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(_, [x, y])| {
            for (x, y) in x.iter_mut().zip(y) {
                let changed = change(Vec2::new(*x, *y));
                (*x, *y) = (changed.x, changed.y);
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
    let (coarse, mut fine) = (scales.pop(), scales.pop());
    if let (Some(fine), Some(coarse)) = (&mut fine, coarse) {
        for (fine, coarse) in [(&mut fine.x, coarse.x), (&mut fine.y, coarse.y)] {
            fine.each_row(|y, row| {
                let samples = row.iter_mut().zip(coarse.row(y));
                samples.for_each(|(fine, coarse)| *fine -= coarse);
            });
        }
    }
    fine.expect("two scales are made")
}

/// The directions that detail slopes in, as vectors of twice the angle, and how much it does, as the first component.
fn structure(mut detail: Vector2Planes, mask: &Mask) -> [Vector2Planes; 2] {
    let blank = || Plane::filled(mask.width(), mask.height(), 0.0);
    let mut strength = blank();
    parallel_rows([&mut detail.x, &mut detail.y, &mut strength])
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(_, [x, y, strength])| {
            for ((x, y), strength) in x.iter_mut().zip(y).zip(strength) {
                let (dx, dy) = (*x, *y);
                (*x, *y) = (dx * dx - dy * dy, 2.0 * dx * dy);
                *strength = dx * dx + dy * dy;
            }
        });
    let strength = Vector2Planes {
        x: strength,
        y: blank(),
    };
    [detail, strength]
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
