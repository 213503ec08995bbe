//! The number of threads, and of frames processed at a time.

use super::message;
use crate::command::args::MOST_THREADS;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::num::NonZeroUsize;
use std::thread;

/// Bytes of a thread's stack: as many as a main thread usually has.
const STACK_BYTES: usize = 8 << 20;

/// Share of a limit on the address space, such as `ulimit -v`, that stacks may take: threads need some of the rest to
/// start, and abort the program where it is used up.
const STACKS_SHARE: u64 = 4;

/// Runs `run` on a pool of `threads`, by default as many as the machine grants this process.
///
/// If the system allows fewer threads, the pool is smaller, down to the calling thread alone.
pub(super) fn on_threads<T: Send>(threads: Option<u16>, run: impl FnOnce() -> T + Send) -> T {
    let wanted = threads.map_or_else(of_machine, usize::from);
    let pool = pool_of(wanted);
    let got = pool.current_num_threads();
    if got < wanted {
        message::say(&format!(
            "note: the system does not allow {wanted} threads; working with {got}"
        ));
    }
    pool.install(run)
}

/// Lets a window, which has to stay on the main thread, work with `threads`.
#[cfg(feature = "view")]
pub(super) fn use_threads(threads: Option<u16>) {
    let builder = ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from));
    // A pool that exists already, in a program that calls this twice, keeps its size.
    let _ = builder.build_global();
}

fn of_machine() -> usize {
    let machine = thread::available_parallelism().map_or(1, NonZeroUsize::get);
    machine.min(MOST_THREADS.into())
}

/// A pool of `threads`, or of a half, a quarter, ... of them where the system allows no more.
fn pool_of(threads: usize) -> ThreadPool {
    let of = |threads| {
        ThreadPoolBuilder::new()
            .num_threads(threads)
            .stack_size(STACK_BYTES)
    };
    let halves = std::iter::successors(Some(threads), |n| (*n > 1).then_some(n / 2));
    let room = room_for_stacks();
    halves
        .filter(|threads| (threads * STACK_BYTES) as u64 <= room)
        .filter_map(|threads| of(threads).build().ok())
        .next()
        .unwrap_or_else(|| {
            let alone = of(1).use_current_thread().build();
            alone.expect("a pool of the thread that asks for it starts none")
        })
}

/// Bytes of address space that stacks may take.
fn room_for_stacks() -> u64 {
    #[cfg(unix)]
    let limit = rustix::process::getrlimit(rustix::process::Resource::As).current;
    #[cfg(not(unix))]
    let limit = None;
    limit.map_or(u64::MAX, |limit: u64| limit / STACKS_SHARE)
}

/// Frames made in parallel, with the threads of each.
pub(super) struct FrameThreads {
    threads: Vec<usize>,
}

impl FrameThreads {
    /// One lane for each pair of threads, at least two, as far as memory allows: the single-threaded parts of a frame,
    /// such as reading and compressing, then overlap with the work of another. `in_memory` frames fit. `and_one_more`
    /// works while others wait until their frames are on disk.
    pub(super) fn of(frames: usize, in_memory: u64, and_one_more: bool) -> Self {
        let threads = rayon::current_num_threads();
        let fit = frames.min(usize::try_from(in_memory).unwrap_or(usize::MAX));
        let paired = threads.div_ceil(2).max(2).min(threads);
        let lanes = (paired + usize::from(and_one_more)).min(fit).max(1);
        let sharing = lanes.min(paired);
        let share = |lane: usize| threads / sharing + usize::from(lane < threads % sharing);
        Self {
            threads: (0..lanes).map(share).collect(),
        }
    }

    /// Runs `lane` on every lane at once, each in a pool of its own; on this thread where no other can be had.
    pub(super) fn each(&self, lane: impl Fn() + Sync) {
        let lane = &lane;
        let begun = thread::scope(|scope| {
            let begin = |&threads: &usize| {
                let begun = thread::Builder::new()
                    .spawn_scoped(scope, move || pool_of(threads).install(lane));
                begun.is_ok()
            };
            // Every lane that can begin does.
            self.threads.iter().filter(|threads| begin(threads)).count()
        });
        if begun == 0 {
            lane();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_lane_more_has_as_many_threads_as_others_and_takes_none_from_them() {
        let lanes = |threads, frames, in_memory, more| {
            pool_of(threads).install(|| FrameThreads::of(frames, in_memory, more).threads)
        };
        assert_eq!(lanes(2, 9, 9, false), [1, 1]);
        assert_eq!(lanes(2, 9, 9, true), [1, 1, 1]);
        assert_eq!(lanes(5, 9, 9, false), [2, 2, 1]);
        assert_eq!(lanes(5, 9, 9, true), [2, 2, 1, 1]);
        // Threads of lanes that no frame or no memory is left for go to others.
        assert_eq!(lanes(4, 1, 9, true), [4]);
        assert_eq!(lanes(4, 9, 1, true), [4]);
        assert_eq!(lanes(4, 2, 9, true), [2, 2]);
        assert_eq!(lanes(1, 9, 9, true), [1, 1]);
        assert_eq!(lanes(1, 9, 0, true), [1]);
    }
}
