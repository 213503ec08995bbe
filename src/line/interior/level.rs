//! Levels: the normals of a frame on a grid that is as fine as lines need it, and their diffusion.

use crate::frame::memory::Memory;
use crate::frame::{Frame, Mask, Plane, Vector2Planes, Vector3Planes, parallel_rows};
use crate::line::grid::parts;
use crate::params::RunOptions;
use crate::shape::diffusion::cpu::diffusion;
use crate::shape::diffusion::medium::Medium;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Normals of the visible surface, with the conductance of their diffusion.
pub(super) struct FormLevel {
    /// The normals with their mask.
    pub(super) frame: Frame,
    /// 0..1, 0 where a silhouette passes and outside the mask.
    pub(super) conductance: Plane,
}

/// Share of a block's pixels that must be covered for it to be.
const COVERED: f32 = 0.5;

/// Smallest weight of normals under a silhouette, so that a block of nothing else has one.
const LEAST_WEIGHT: f32 = 1e-3;

/// Error of the diffusion, relative to a normal's length: a tenth of the faintest line's turn per pixel.
const TOLERANCE: f64 = 1e-3;

impl FormLevel {
    /// The level of a frame whose silhouettes are known, in blocks of `factor` by `factor` pixels.
    pub(super) fn of(frame: &Frame, silhouette: &Plane, factor: usize) -> Self {
        let Vector3Planes { x, y, z } = &frame.normal;
        Self::blocks(&frame.mask, factor, |row, pixels, blocks| {
            let rows = [x, y, z, silhouette].map(|plane| plane.row(row));
            for (block, pixels) in parts(pixels, factor) {
                for i in pixels {
                    let [x, y, z, silhouette] = rows.map(|row| row[i]);
                    blocks[block].add(Vec3::new(x, y, z), 1.0 - silhouette);
                }
            }
        })
    }

    /// The level of half the size, of normals at a scale that this one was diffused to.
    pub(super) fn halved(&self, normals: &Plane<Vec3>) -> Self {
        Self::blocks(&self.frame.mask, 2, |row, pixels, blocks| {
            let (normals, conductance) = (normals.row(row), self.conductance.row(row));
            for x in pixels {
                blocks[x / 2].add(normals[x], conductance[x]);
            }
        })
    }

    /// The level of blocks: `read` gives the normals and conductances of a run of covered pixels in a row.
    fn blocks(
        mask: &Mask,
        factor: usize,
        read: impl Fn(usize, Range<usize>, &mut [Block]) + Sync,
    ) -> Self {
        let (width, height) = (
            mask.width().div_ceil(factor),
            mask.height().div_ceil(factor),
        );
        let blank = || Plane::filled(width, height, 0.0);
        let (mut normal, mut conductance) = ([blank(), blank(), blank()], blank());
        let mut covered = Plane::filled(width, height, false);
        let [nx, ny, nz] = normal.each_mut();
        let rows = parallel_rows([nx, ny, nz, &mut conductance])
            .zip(covered.samples_mut().par_chunks_mut(width));
        rows.for_each_init(
            || vec![Block::default(); width],
            |blocks, ((y, [nx, ny, nz, conductance]), covered)| {
                blocks.fill(Block::default());
                let rows = y * factor..((y + 1) * factor).min(mask.height());
                for row in rows.clone() {
                    for run in mask.runs(row) {
                        read(row, run, blocks);
                    }
                }
                for (x, block) in blocks.iter().enumerate() {
                    let columns = factor.min(mask.width() - x * factor);
                    if let Some(unit) = block.normal(rows.len() * columns) {
                        [nx[x], ny[x], nz[x]] = unit.to_array();
                        (conductance[x], covered[x]) = (block.least, true);
                    }
                }
            },
        );
        let [x, y, z] = normal;
        Self {
            conductance,
            frame: Frame::of_normals(Vector3Planes { x, y, z }, Mask::new(covered)),
        }
    }

    /// The unit normals diffused to each of these scales, in pixels; 0 outside the mask.
    pub(super) fn diffused(
        &self,
        sigmas: &[f32],
        options: &RunOptions,
        memory: &Memory,
    ) -> Vec<Plane<Vec3>> {
        let sweeps = DiffusionSchedule::to_sigmas(sigmas, TOLERANCE);
        let Vector3Planes { x, y, z } = &self.frame.normal;
        let zero = Plane::filled(z.width(), z.height(), 0.0);
        let across = self.spread([x.clone(), y.clone()], &sweeps, options, memory);
        let toward = self.spread([z.clone(), zero], &sweeps, options, memory);
        let pairs = across.iter().zip(&toward);
        pairs
            .map(|(across, toward)| self.units(across, &toward.x))
            .collect()
    }

    /// A scalar diffused to a scale, in pixels.
    pub(super) fn spread_scalar(
        &self,
        scalar: Plane,
        sigma: f32,
        options: &RunOptions,
        memory: &Memory,
    ) -> Plane {
        let sweeps = DiffusionSchedule::to_sigmas(&[sigma], TOLERANCE);
        let zero = Plane::filled(scalar.width(), scalar.height(), 0.0);
        let mut spread = self.spread([scalar, zero], &sweeps, options, memory);
        spread.pop().expect("one scale was asked for").x
    }

    /// Two components, as many as the operator takes at once, at the scales of a schedule.
    fn spread(
        &self,
        [x, y]: [Plane; 2],
        sweeps: &DiffusionSchedule,
        options: &RunOptions,
        memory: &Memory,
    ) -> Vec<Vector2Planes> {
        let medium = Medium::of_whole(&self.conductance, &self.frame.mask);
        let memory = &memory.at_other_size();
        diffusion(Vector2Planes { x, y }, medium, sweeps, options, memory).scales
    }

    fn units(&self, across: &Vector2Planes, z: &Plane) -> Plane<Vec3> {
        Plane::of_covered(&self.frame.mask, |y| {
            let [across_x, across_y, z] = [&across.x, &across.y, z].map(|plane| plane.row(y));
            move |x| Vec3::new(across_x[x], across_y[x], z[x]).normalize_or_zero()
        })
    }
}

/// Sums over the covered pixels of a block: normals weighted by conductance, so that one side of a silhouette through
/// it dominates, and the least conductance, so that it stays closed.
#[derive(Debug, Clone, Copy)]
struct Block {
    sum: Vec3,
    least: f32,
    count: usize,
}

impl Default for Block {
    fn default() -> Self {
        Self {
            sum: Vec3::ZERO,
            least: 1.0,
            count: 0,
        }
    }
}

impl Block {
    /// Adds a pixel, unless its normal has no meaning.
    #[inline]
    fn add(&mut self, normal: Vec3, open: f32) {
        if !normal.is_finite() {
            return;
        }
        // A weight of no meaning is that of an edge.
        let open = if open > 0.0 { open.min(1.0) } else { 0.0 };
        self.sum += (open + LEAST_WEIGHT) * normal;
        self.least = self.least.min(open);
        self.count += 1;
    }

    /// The unit normal of a block of this area, if enough of it is covered.
    fn normal(&self, area: usize) -> Option<Vec3> {
        let is_covered = self.count as f32 >= COVERED * area as f32;
        is_covered.then(|| self.sum.try_normalize())?
    }
}
