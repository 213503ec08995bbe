//! Division of the drawing among maps of places.

use crate::frame::memory::Memory;
use crate::frame::rows::ROWS_PER_TASK;
use crate::frame::{Mask, Plane};
use crate::line::texture_coordinates::places::{MovingSurface, PlaceMap, jacobian_at};
use crate::line::texture_coordinates::{distortion, soundness};
use rayon::prelude::*;

/// The shares of maps, with that of the next one last.
pub(crate) struct Weighed {
    pub(crate) shares: Vec<Plane>,
    /// Their sums over the surface.
    pub(crate) totals: Vec<f64>,
}

impl Weighed {
    /// The share that falls to the next map.
    pub(crate) fn asked(&self) -> f64 {
        self.totals.last().copied().unwrap_or(0.0)
    }

    /// The map that serves least.
    pub(crate) fn least_used(&self) -> usize {
        let used = self.totals[..self.totals.len() - 1].iter().enumerate();
        let least = used.min_by(|a, b| a.1.total_cmp(b.1));
        least.map_or(0, |(i, _)| i)
    }

    pub(crate) fn of(
        maps: &[PlaceMap],
        mask: &Mask,
        surface: &MovingSurface,
        memory: &Memory,
    ) -> Self {
        let mut shares: Vec<Plane> = (0..=maps.len()).map(|_| memory.plane(mask)).collect();
        let width = mask.width().max(1);
        let mut rows: Vec<Vec<&mut [f32]>> = (0..mask.height()).map(|_| Vec::new()).collect();
        for share in &mut shares {
            let of_share = share.samples_mut().chunks_mut(width);
            rows.iter_mut()
                .zip(of_share)
                .for_each(|(rows, row)| rows.push(row));
        }
        let sums = rows.into_par_iter().enumerate().with_min_len(ROWS_PER_TASK);
        let sums: Vec<Vec<f64>> = sums
            .map(|(y, rows)| row_of_shares(maps, mask, surface, y, rows))
            .collect();
        let mut totals = vec![0.0; shares.len()];
        for sums in sums {
            totals
                .iter_mut()
                .zip(sums)
                .for_each(|(total, sum)| *total += sum);
        }
        Self { shares, totals }
    }
}

/// Shares of row `y`, and their sums.
fn row_of_shares(
    maps: &[PlaceMap],
    mask: &Mask,
    surface: &MovingSurface,
    y: usize,
    mut rows: Vec<&mut [f32]>,
) -> Vec<f64> {
    let mut sums = vec![0.0; rows.len()];
    for x in mask.runs(y).flatten() {
        let mut left = 1.0;
        for (i, map) in maps.iter().enumerate() {
            let mut share = 0.0;
            if left > 0.0 {
                let by = jacobian_at(&map.place, surface, x, y);
                share = left * map.fade * soundness(distortion(&by));
            }
            rows[i][x] = share;
            sums[i] += f64::from(share);
            left -= share;
        }
        rows[maps.len()][x] = left;
        sums[maps.len()] += f64::from(left);
    }
    sums
}
