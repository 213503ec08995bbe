//! Chains: patches in a line, each continuing in the next. Averages are taken along them.

use crate::kernel::simd::wide;
use crate::line::direction_field;
use crate::line::direction_field::Weighted;
use crate::line::direction_field::patches::{Links, NONE, Patches};
use rayon::prelude::*;

/// All patches in the order of their chains along one axis.
struct PatchChains {
    chains: Vec<Vec<u32>>,
    /// Position of a patch in the order of the chains.
    place: Vec<u32>,
}

/// Fewest chains per task.
const CHAINS_PER_TASK: usize = 16;

impl PatchChains {
    fn new(links: &Links) -> Self {
        let next = |&i: &u32| Some(links.after[i as usize]).filter(|&next| next != NONE);
        let starts = (0..)
            .zip(&links.before)
            .filter(|(_, before)| **before == NONE);
        let chains = starts.map(|(start, _)| std::iter::successors(Some(start), next).collect());
        let chains: Vec<Vec<u32>> = chains.collect();
        let mut place = vec![0; links.after.len()];
        for (at, &i) in (0..).zip(chains.iter().flatten()) {
            place[i as usize] = at;
        }
        Self { chains, place }
    }

    /// The sums along the chains around every patch, in their order.
    fn sums<const N: usize>(&self, all: &[[Weighted; N]], reach: &[f32]) -> Vec<[Weighted; N]> {
        let chains = self.chains.par_iter().with_min_len(CHAINS_PER_TASK);
        let room = || (Vec::new(), Vec::new(), Vec::new());
        let sums = chains.map_init(room, |(values, reaches, scratch), chain| {
            values.clear();
            values.extend(chain.iter().map(|&i| all[i as usize]));
            reaches.clear();
            reaches.extend(chain.iter().map(|&i| reach[i as usize]));
            let mut sums = vec![[[0.0; 4]; N]; chain.len()];
            wide!(direction_field::sums_along(
                &mut sums, values, reaches, scratch
            ));
            sums
        });
        sums.collect::<Vec<_>>().concat()
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
    pub(crate) fn average<const N: usize>(
        &self,
        values: &mut [[Weighted; N]],
        reach: &[f32],
        passes: u32,
    ) {
        for _ in 0..passes {
            let [across, down] = [&self.across, &self.down].map(|axis| axis.sums(values, reach));
            let places = self.across.place.par_iter().zip(&self.down.place);
            values
                .par_iter_mut()
                .zip(places)
                .for_each(|(own, (&a, &b))| {
                    let (a, b) = (&across[a as usize], &down[b as usize]);
                    for f in 0..N {
                        // The patch itself is in both.
                        let weights = a[f][3] + b[f][3] - 1.0;
                        own[f] = std::array::from_fn(|c| (a[f][c] + b[f][c] - own[f][c]) / weights);
                    }
                });
        }
    }
}
