//! Levels: the normals of a frame on a grid that is as fine as lines need it, and their diffusion.

use crate::engine::cpu::memory::Memory;
use crate::frame::{Frame, Mask, Plane, Vector2Planes, Vector3Planes};
use crate::params::RunOptions;
use crate::shape::diffusion::cpu::diffusion;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use glam::Vec3;
use rayon::prelude::*;

/// Normals where a surface was seen, and how freely they spread there.
pub(super) struct Level {
    /// The normals with their mask.
    pub(super) frame: Frame,
    /// 0..1, 0 where a silhouette passes and outside the mask.
    pub(super) conductance: Plane,
}

/// Share of a block's pixels that must be covered for it to be.
const COVERED: f32 = 0.5;

/// What normals under a silhouette count at least, so that a block of nothing else has one.
const LEAST_WEIGHT: f32 = 1e-3;

/// Error of the diffusion, relative to a normal's length: a tenth of what the faintest line turns by in a pixel.
const TOLERANCE: f64 = 1e-3;

/// Blocks' means: normal, conductance, and whether the block is covered.
type Block = (Vec3, f32, bool);

impl Level {
    /// The level of a frame whose silhouettes are known, in blocks of `factor` by `factor` pixels.
    pub(super) fn of(frame: &Frame, silhouette: &Plane, factor: usize) -> Self {
        let normal = &frame.normal;
        let width = frame.mask.width();
        Self::blocks(&frame.mask, factor, |x, y| {
            let i = y * width + x;
            let [x, y, z] = [&normal.x, &normal.y, &normal.z].map(|plane| plane.samples()[i]);
            (Vec3::new(x, y, z), 1.0 - silhouette.samples()[i])
        })
    }

    /// The level of half the size, of normals at a scale that this one was diffused to.
    pub(super) fn halved(&self, normals: &Plane<Vec3>) -> Self {
        Self::blocks(&self.frame.mask, 2, |x, y| {
            (normals.at(x, y), self.conductance.at(x, y))
        })
    }

    fn blocks(
        mask: &Mask,
        factor: usize,
        pixel: impl Fn(usize, usize) -> (Vec3, f32) + Sync,
    ) -> Self {
        let (width, height) = (
            mask.width().div_ceil(factor),
            mask.height().div_ceil(factor),
        );
        let block = |x: usize, y: usize| -> Block {
            let columns = x * factor..((x + 1) * factor).min(mask.width());
            let rows = y * factor..((y + 1) * factor).min(mask.height());
            let area = columns.len() * rows.len();
            let pixels = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
            let covered = pixels
                .filter(|&(x, y)| mask.at(x, y))
                .map(|(x, y)| pixel(x, y));
            mean(covered, area)
        };
        let rows: Vec<Vec<Block>> = (0..height)
            .into_par_iter()
            .map(|y| (0..width).map(|x| block(x, y)).collect())
            .collect();
        Self::of_blocks(width, height, &rows.concat())
    }

    fn of_blocks(width: usize, height: usize, blocks: &[Block]) -> Self {
        let plane = |sample: fn(&Block) -> f32| {
            Plane::from_samples(width, height, blocks.iter().map(sample).collect())
        };
        let normal = Vector3Planes {
            x: plane(|block| block.0.x),
            y: plane(|block| block.0.y),
            z: plane(|block| block.0.z),
        };
        let covered = blocks.iter().map(|block| block.2).collect();
        Self {
            conductance: plane(|block| block.1),
            frame: Frame::of_normals(
                normal,
                Mask::new(Plane::from_samples(width, height, covered)),
            ),
        }
    }

    /// The unit normals diffused to each of these scales, in pixels; 0 outside the mask.
    pub(super) fn diffused(&self, sigmas: &[f32], options: &RunOptions) -> Vec<Plane<Vec3>> {
        let sweeps = DiffusionSchedule::to_sigmas(sigmas, TOLERANCE);
        let Vector3Planes { x, y, z } = &self.frame.normal;
        let memory = Memory::default();
        // The operator takes two components at a time.
        let spread = |x: Plane, y: Plane| {
            let pair = Vector2Planes { x, y };
            diffusion(
                pair,
                &self.conductance,
                &self.frame.mask,
                None,
                &sweeps,
                options,
                &memory,
            )
        };
        let across = spread(x.clone(), y.clone());
        let toward = spread(z.clone(), Plane::filled(z.width(), z.height(), 0.0));
        let pairs = across.iter().zip(&toward);
        pairs
            .map(|(across, toward)| self.units(across, &toward.x))
            .collect()
    }

    fn units(&self, across: &Vector2Planes, z: &Plane) -> Plane<Vec3> {
        let (width, mask) = (z.width(), &self.frame.mask);
        let mut normals = Plane::filled(width, z.height(), Vec3::ZERO);
        let rows = normals.samples_mut().par_chunks_mut(width);
        rows.enumerate().for_each(|(y, row)| {
            for x in mask.runs(y).flatten() {
                row[x] =
                    Vec3::new(across.x.at(x, y), across.y.at(x, y), z.at(x, y)).normalize_or_zero();
            }
        });
        normals
    }
}

/// The mean of the covered pixels of a block of this area: normals by conductance, so that it shows one side of a silhouette
/// that passes, and the least of the conductances, so that it stays closed.
fn mean(pixels: impl Iterator<Item = (Vec3, f32)>, area: usize) -> Block {
    let (mut sum, mut least, mut count) = (Vec3::ZERO, 1.0_f32, 0);
    for (normal, open) in pixels.filter(|(normal, _)| normal.is_finite()) {
        // A weight of no meaning is that of an edge.
        let open = open.clamp(0.0, 1.0);
        let open = if open.is_nan() { 0.0 } else { open };
        sum += (open + LEAST_WEIGHT) * normal;
        least = least.min(open);
        count += 1;
    }
    let normal = sum.normalize_or_zero();
    match count as f32 >= COVERED * area as f32 && normal != Vec3::ZERO {
        true => (normal, least, true),
        false => (Vec3::ZERO, 0.0, false),
    }
}
