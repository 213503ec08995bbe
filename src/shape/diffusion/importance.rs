//! Importance maps, quantised for the readout of sweeps.

use crate::frame::{Frame, Plane};
use crate::shape::diffusion::LEVELS;
use crate::shape::diffusion::sweeps::{DiffusionSchedule, Readout};
use rayon::prelude::*;

/// Quantised importance, and the weights of every level that occurs.
pub(crate) struct ImportanceLevels {
    pub(crate) plane: Plane<u16>,
    /// Number of levels.
    pub(crate) count: usize,
    /// For every term, the weight of every level.
    pub(crate) weights: Vec<[f32; LEVELS]>,
}

impl ImportanceLevels {
    /// The levels of a frame, if the sweeps are weighted by importance.
    pub(crate) fn of(frame: &Frame, sweeps: &DiffusionSchedule) -> Option<Self> {
        let Readout::ByImportance(_) = sweeps.readout else {
            return None;
        };
        let importance = frame
            .importance
            .as_ref()
            .expect("the plan found it in the frame");
        let top = (LEVELS - 1) as f32;
        // NaN counts as 0.
        let level = |share: f32| (share.clamp(0.0, 1.0) * top + 0.5) as usize;
        let occurs = importance
            .samples()
            .par_chunks(1 << 16)
            .map(|part| {
                let mut occurs = [false; LEVELS];
                part.iter().for_each(|&share| occurs[level(share)] = true);
                occurs
            })
            .reduce(
                || [false; LEVELS],
                |a, b| std::array::from_fn(|i| a[i] | b[i]),
            );
        // Levels that occur are renumbered: usually there are few.
        let mut number = [0; LEVELS];
        let mut shares = Vec::new();
        for level in (0..LEVELS).filter(|&level| occurs[level]) {
            number[level] = shares.len() as u16;
            shares.push(level as f64 / f64::from(top));
        }
        let mut plane = Plane::filled(importance.width(), importance.height(), 0);
        plane
            .samples_mut()
            .par_chunks_mut(1 << 16)
            .zip(importance.samples().par_chunks(1 << 16))
            .for_each(|(numbers, shares)| {
                for (out, &share) in numbers.iter_mut().zip(shares) {
                    *out = number[level(share)];
                }
            });
        let mut weights = vec![[0.0; LEVELS]; sweeps.count() + 1];
        for (level, of_level) in sweeps.weights_by_importance(&shares).iter().enumerate() {
            for (of_term, weight) in weights.iter_mut().zip(of_level) {
                of_term[level] = *weight;
            }
        }
        Some(Self {
            plane,
            count: shares.len(),
            weights,
        })
    }
}
