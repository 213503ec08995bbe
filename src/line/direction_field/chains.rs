//! Chains: patches in a line, each continuing in the next. Averages are taken along them.

use crate::kernel::simd::wide;
use crate::line::direction_field;
use crate::line::direction_field::Weighted;
use crate::line::direction_field::patches::{Links, NONE, Patches};
use rayon::prelude::*;
use std::ops::Range;

/// All patches in the order of their chains along one axis.
struct PatchChains {
    order: Vec<u32>,
    /// Chains, gathered into tasks.
    tasks: Vec<Vec<Range<usize>>>,
}

/// Fewest patches per task.
const PATCHES_PER_TASK: usize = 2048;

impl PatchChains {
    /// The chains of these links; a task may begin with a chain `from` a place in the order, with its first patch.
    fn new(links: &Links, may_begin: impl Fn(usize, usize) -> bool) -> Self {
        let count = links.after.len();
        let mut order = Vec::with_capacity(count);
        let mut tasks = vec![Vec::new()];
        let mut in_task = 0;
        for start in (0..count).filter(|&i| links.before[i] == NONE) {
            let from = order.len();
            if in_task >= PATCHES_PER_TASK && may_begin(from, start) {
                tasks.push(Vec::new());
                in_task = 0;
            }
            let mut i = start as u32;
            while i != NONE {
                order.push(i);
                i = links.after[i as usize];
            }
            in_task += order.len() - from;
            tasks
                .last_mut()
                .expect("one at the least")
                .push(from..order.len());
        }
        Self { order, tasks }
    }

    /// The tasks, each with its part of some values.
    fn parts<'a, T: Send>(
        &'a self,
        values: &'a mut [T],
    ) -> impl IndexedParallelIterator<Item = (&'a [Range<usize>], &'a mut [T])> {
        let mut rest = values;
        let mut parts = Vec::with_capacity(self.tasks.len());
        for task in &self.tasks {
            let length = task.iter().map(Range::len).sum();
            let (part, after) = rest.split_at_mut(length);
            parts.push((&task[..], part));
            rest = after;
        }
        parts.into_par_iter()
    }
}

/// A chain taken together, and room for its sums.
#[derive(Default)]
struct Chain<const N: usize> {
    values: Vec<[Weighted; N]>,
    reach: Vec<f32>,
    sums: Vec<[Weighted; N]>,
    scratch: Vec<[[f64; 4]; N]>,
}

impl<const N: usize> Chain<N> {
    /// Takes the values of these patches from all `values`, which begin with that of the patch `first`.
    #[inline]
    fn take(&mut self, members: &[u32], values: &[[Weighted; N]], first: usize, reach: &[f32]) {
        self.values.clear();
        let own = members.iter().map(|&i| values[i as usize - first]);
        self.values.extend(own);
        self.reach.clear();
        self.reach
            .extend(members.iter().map(|&i| reach[i as usize]));
    }
}

/// The cross-shaped kernel over patches.
pub(crate) struct CrossKernel {
    /// Each task has all patches from one to another.
    across: PatchChains,
    down: PatchChains,
    /// Position of a patch in the order of the chains down.
    place: Vec<u32>,
}

impl CrossKernel {
    pub(crate) fn new(patches: &Patches) -> Self {
        let down = || {
            let down = PatchChains::new(&patches.down, |_, _| true);
            let mut place = vec![0; down.order.len()];
            for (at, &i) in (0..).zip(&down.order) {
                place[i as usize] = at;
            }
            (down, place)
        };
        let (across, (down, place)) = rayon::join(
            // Chains across lead to later patches: as many before one as its number are all.
            || PatchChains::new(&patches.across, |from, first| from == first),
            down,
        );
        Self {
            across,
            down,
            place,
        }
    }

    /// Replaces values by their means around each patch, along both axes up to `reach`, in patches: pass after pass.
    pub(crate) fn average<const N: usize>(
        &self,
        values: &mut [[Weighted; N]],
        reach: &[f32],
        passes: u32,
    ) {
        let mut down = vec![[[0.0; 4]; N]; values.len()];
        for _ in 0..passes {
            let tasks = self.down.parts(&mut down);
            tasks.for_each_init(Chain::default, |chain, (task, mut part)| {
                for range in task {
                    let (own, after) = part.split_at_mut(range.len());
                    chain.take(&self.down.order[range.clone()], values, 0, reach);
                    wide!(direction_field::sums_along(
                        own,
                        &chain.values,
                        &chain.reach,
                        &mut chain.scratch
                    ));
                    part = after;
                }
            });
            let tasks = self.across.parts(values);
            tasks.for_each_init(Chain::default, |chain, (task, part)| {
                let first = task.first().map_or(0, |range| range.start);
                for range in task {
                    let members = &self.across.order[range.clone()];
                    let begin = members[0] as usize;
                    // Each leads to later ones: as many as from the first to the last are all of these.
                    let is_whole = members.last() == Some(&((begin + range.len() - 1) as u32));
                    if !is_whole {
                        chain.take(members, part, first, reach);
                    }
                    let (own, own_reach) = match is_whole {
                        true => (&part[begin - first..][..range.len()], &reach[begin..]),
                        false => (&chain.values[..], &chain.reach[..]),
                    };
                    chain.sums.resize(range.len(), [[0.0; 4]; N]);
                    wide!(direction_field::sums_along(
                        &mut chain.sums,
                        own,
                        own_reach,
                        &mut chain.scratch
                    ));
                    for (&i, a) in members.iter().zip(&chain.sums) {
                        let b = &down[self.place[i as usize] as usize];
                        let own = part[i as usize - first];
                        let mut mean = own;
                        for f in 0..N {
                            // The patch itself is in both.
                            let weights = a[f][3] + b[f][3] - 1.0;
                            for c in 0..4 {
                                mean[f][c] = (a[f][c] + b[f][c] - own[f][c]) / weights;
                            }
                        }
                        part[i as usize - first] = mean;
                    }
                }
            });
        }
    }
}
