//! Threads, and how many frames are made at a time.

use super::args::WorkArgs;
use std::num::NonZeroUsize;
use std::path::Path;

/// Makes a pool of `threads` for single frames; of as many as the machine lets this process have where not given.
pub(super) fn use_threads(threads: Option<u16>) {
    if let Some(threads) = threads {
        // A pool that exists already, in a program that calls this twice, keeps its size.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global();
    }
}

/// Frames that are made at the same time, and the threads of each.
pub(super) struct Lanes {
    threads: Vec<usize>,
}

impl Lanes {
    /// As many frames at a time as there are pairs of threads, two at the least, as far as memory goes: what a frame does
    /// on one thread, such as reading and compressing, then overlaps with the work of another. `first` is one of the
    /// frames, by which its memory is judged.
    pub(super) fn of(work: &WorkArgs, first: &Path, frames: usize) -> Self {
        let machine = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let threads = work.run.threads.map_or(machine, usize::from);
        let most = work.run.max_memory.bytes() / work.frame_bytes(first).max(1);
        let lanes = threads
            .div_ceil(2)
            .max(2)
            .min(threads)
            .min(frames)
            .min(usize::try_from(most).unwrap_or(usize::MAX))
            .max(1);
        let share = |lane: usize| threads / lanes + usize::from(lane < threads % lanes);
        Self {
            threads: (0..lanes).map(share).collect(),
        }
    }

    /// Runs `lane` on every lane at once, each in a pool of its own.
    pub(super) fn each(&self, lane: impl Fn() + Sync) {
        std::thread::scope(|scope| {
            for &threads in &self.threads {
                let lane = &lane;
                scope.spawn(move || {
                    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
                        Ok(pool) => pool.install(lane),
                        // No more threads are to be had: the global pool does it.
                        Err(_) => lane(),
                    }
                });
            }
        });
    }
}
