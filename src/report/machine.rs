//! Memory bandwidth and arithmetic rate of the machine.
//!
//! Both are measured in the caller's rayon pool, in well under half a second, so that the time of a stage can be
//! compared with the minimum for its data and its arithmetic.

use rayon::prelude::*;
use serde::Serialize;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Measured rates of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Machine {
    /// Threads of the pool.
    pub threads: usize,
    /// Bytes per second of a triad `a = b + s c` over arrays larger than any cache; 12 bytes per element, without the
    /// read of a cache line that is then overwritten.
    pub bytes_per_second: f64,
    /// Single-precision operations per second, with a multiplication and an addition counting as two, from registers,
    /// as vectorised in this build.
    pub operations_per_second: f64,
    /// The operation of a link: fused, or a multiplication and an addition.
    pub multiply_add: &'static str,
}

/// Elements of each array of the triad: 3 x 64 MiB.
const ELEMENTS: usize = 1 << 24;
/// Elements per task.
const TASK: usize = 1 << 16;
/// Independent chains per thread: enough registers to hide the latency, leaving two for the constants.
const LANES: usize = if cfg!(target_feature = "avx") { 96 } else { 48 };
/// Links of each chain: about 10 ms on a core of 2.5 GHz.
const LINKS: usize = 1 << 18;
/// The best of this many runs counts.
const RUNS: usize = 4;

impl Machine {
    /// Measures the machine.
    pub(crate) fn measured() -> Self {
        let threads = rayon::current_num_threads();
        let fused = cfg!(target_feature = "fma");
        Self {
            threads,
            bytes_per_second: bandwidth(),
            operations_per_second: arithmetic(threads),
            multiply_add: if fused {
                "fused multiply-add"
            } else {
                "multiplication and addition"
            },
        }
    }
}

fn best(mut run: impl FnMut()) -> Duration {
    let mut timed = || {
        let start = Instant::now();
        run();
        start.elapsed()
    };
    (0..RUNS).map(|_| timed()).min().expect("there are runs")
}

fn bandwidth() -> f64 {
    let b: Vec<f32> = (0..ELEMENTS).into_par_iter().map(|i| i as f32).collect();
    let c: Vec<f32> = b.par_iter().map(|v| 0.5 * v).collect();
    let mut a: Vec<f32> = b.par_iter().map(|v| v + 1.0).collect();
    let time = best(|| {
        a.par_chunks_mut(TASK)
            .zip(b.par_chunks(TASK))
            .zip(c.par_chunks(TASK))
            .for_each(|((a, b), c)| {
                for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                    *a = b + 3.0 * c;
                }
            });
        black_box(&mut a);
    });
    12.0 * ELEMENTS as f64 / time.as_secs_f64()
}

fn arithmetic(threads: usize) -> f64 {
    let time = best(|| {
        (0..threads)
            .into_par_iter()
            .with_max_len(1)
            .for_each(|thread| {
                let start = black_box(thread as f32 + 1.0);
                black_box(chains(black_box([start; LANES])));
            });
    });
    (2 * LANES * LINKS * threads) as f64 / time.as_secs_f64()
}

/// Parallel chains of `v = 0.999 v + 0.001`.
fn chains(mut v: [f32; LANES]) -> [f32; LANES] {
    for _ in 0..LINKS {
        for v in &mut v {
            *v = if cfg!(target_feature = "fma") {
                v.mul_add(0.999, 0.001)
            } else {
                *v * 0.999 + 0.001
            };
        }
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chains_do_what_they_are_counted_for() {
        // v -> 0.999 v + 0.001 has the fixed point 1, and converges to it.
        assert!(chains([5.0; LANES]).iter().all(|v| (v - 1.0).abs() < 1e-4));
    }
}
