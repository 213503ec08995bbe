//! Chains: patches in a line, each continuing in the next. Averages are taken along them.

use crate::engine::cpu::simd::Simd;
use crate::line::direction_field::Both;
use crate::line::direction_field::patches::{Links, NONE, Patches};
use rayon::prelude::*;
use std::ops::Range;

/// All patches in the order of their chains along one axis.
struct PatchChains {
    order: Vec<u32>,
    /// Position of a patch in that order.
    place: Vec<u32>,
    /// Chains, gathered into tasks.
    tasks: Vec<Vec<Range<usize>>>,
}

/// Fewest patches per task.
const PATCHES_PER_TASK: usize = 2048;

impl PatchChains {
    fn new(links: &Links) -> Self {
        let count = links.after.len();
        let mut order = Vec::with_capacity(count);
        let mut place = vec![0; count];
        let mut tasks = vec![Vec::new()];
        let mut in_task = 0;
        for start in (0..count).filter(|&i| links.before[i] == NONE) {
            let from = order.len();
            let mut i = start as u32;
            while i != NONE {
                place[i as usize] = order.len() as u32;
                order.push(i);
                i = links.after[i as usize];
            }
            if in_task >= PATCHES_PER_TASK {
                tasks.push(Vec::new());
                in_task = 0;
            }
            in_task += order.len() - from;
            tasks
                .last_mut()
                .expect("one at the least")
                .push(from..order.len());
        }
        Self {
            order,
            place,
            tasks,
        }
    }

    /// The sums along every chain, in the order of the chains.
    fn sum(&self, sums: &mut [Both], values: &[Both], reach: &[f32]) {
        let mut rest = sums;
        let mut parts = Vec::with_capacity(self.tasks.len());
        for task in &self.tasks {
            let length = task.iter().map(Range::len).sum();
            let (part, after) = rest.split_at_mut(length);
            parts.push((task, part));
            rest = after;
        }
        let simd = Simd::widest();
        parts.into_par_iter().for_each_init(
            || (Vec::new(), Vec::new(), Vec::new()),
            |(chain, far, scratch), (task, mut part)| {
                for range in task {
                    let (own, after) = part.split_at_mut(range.len());
                    let members = &self.order[range.clone()];
                    chain.clear();
                    chain.extend(members.iter().map(|&i| values[i as usize]));
                    far.clear();
                    far.extend(members.iter().map(|&i| reach[i as usize]));
                    simd.sums_along(own, chain, far, scratch);
                    part = after;
                }
            },
        );
    }
}

/// The cross-shaped kernel over patches.
pub(crate) struct CrossKernel {
    across: PatchChains,
    down: PatchChains,
}

impl CrossKernel {
    pub(crate) fn new(patches: &Patches) -> Self {
        let (across, down) = rayon::join(
            || PatchChains::new(&patches.across),
            || PatchChains::new(&patches.down),
        );
        Self { across, down }
    }

    /// Replaces values by their means around each patch, along both axes up to `reach`, in patches: pass after pass.
    pub(crate) fn average(&self, values: &mut [Both], reach: &[f32], passes: u32) {
        let [mut across, mut down] = [(); 2].map(|()| vec![[[0.0; 4]; 2]; values.len()]);
        for _ in 0..passes {
            rayon::join(
                || self.across.sum(&mut across, values, reach),
                || self.down.sum(&mut down, values, reach),
            );
            let mean = |(i, value): (usize, &mut Both)| {
                let a = &across[self.across.place[i] as usize];
                let b = &down[self.down.place[i] as usize];
                for f in 0..2 {
                    // The patch itself is in both.
                    let weights = a[f][3] + b[f][3] - 1.0;
                    for c in 0..4 {
                        value[f][c] = (a[f][c] + b[f][c] - value[f][c]) / weights;
                    }
                }
            };
            values
                .par_iter_mut()
                .with_min_len(PATCHES_PER_TASK)
                .enumerate()
                .for_each(mean);
        }
    }
}
