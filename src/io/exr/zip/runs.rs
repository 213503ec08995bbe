//! zlib for samples computed here, which are smooth: by zlib-rs, looking for runs alone, where that finds as much.
//!
//! 20 layers of shape of a render of 1920x1080 become 22.0 % at 440 MB/s of one core, where looking for repetitions
//! makes 22.2 % at 275 MB/s; as 32-bit floats 33.1 % at 430 MB/s, and 30.9 % at 240. libdeflate takes 265 to 300 MB/s
//! for 22.1 to 22.3 %, and 280 to 310 for 30.9 %. Strokes repeat themselves: they would be half as large again.

use std::cell::RefCell;
use zlib_rs::{Deflate, DeflateConfig, DeflateFlush, Status, Strategy};

/// Effort, 1 to 9. A render of 1920x1080 with 16 channels of halves becomes 12.4 MB in 0.52 s of
/// one core; with 2, 13.1 MB in 0.40 s; with 4, 12.1 MB in 0.64 s; with 6, 11.6 MB in 1.00 s. Level 4 of
/// miniz_oxide, which the `exr` crate uses, makes 12.2 MB in 1.41 s. Runs take the same at any.
const LEVEL: i32 = 3;
/// The window, as a power of two; the largest possible.
pub(super) const WINDOW_BITS: i32 = 15;
/// Room for literals and matches that share a code; the most possible. Fewer codes take 7 % less time than with the
/// usual room, for 0.01 % more bytes.
const MEMORY_LEVEL: i32 = 9;

/// Bytes of each half of a block on which runs alone are tried, in its middle.
const SAMPLE: usize = 8192;
/// Runs are taken if they make the sample at most so many times as large.
const MOST: f64 = 1.05;
/// Smaller blocks are not worth trying.
const LEAST_BLOCK: usize = 16 * SAMPLE;

thread_local! {
    /// zlib's working state: costly to make, and reused by all blocks of a thread.
    static RUNS: RefCell<Deflate> = RefCell::new(deflate_by(Strategy::Rle));
}

/// A compressor that searches in this way.
pub(super) fn deflate_by(strategy: Strategy) -> Deflate {
    Deflate::new_with_config(DeflateConfig {
        level: LEVEL,
        strategy,
        window_bits: WINDOW_BITS,
        mem_level: MEMORY_LEVEL,
        ..DeflateConfig::default()
    })
}

/// Compresses `bytes` into `into`; returns the number of compressed bytes, `None` if they do not fit.
pub(super) fn compressed(by: &mut Deflate, bytes: &[u8], into: &mut [u8]) -> Option<usize> {
    by.reset();
    match by.compress(bytes, into, DeflateFlush::Finish) {
        Ok(Status::StreamEnd) => Some(by.total_out() as usize),
        _ => None,
    }
}

/// Compresses smooth samples into `into`, as `by_all_means` compresses others.
pub(super) fn deflate(
    bytes: &[u8],
    into: &mut [u8],
    by_all_means: impl Fn(&[u8], &mut [u8]) -> Option<usize>,
) -> Option<usize> {
    RUNS.with_borrow_mut(|runs| match are_enough(runs, bytes, into, &by_all_means) {
        true => compressed(runs, bytes, into),
        false => by_all_means(bytes, into),
    })
}

/// Whether a sample of a block, of its low bytes and of its high ones, compresses as well by `runs` as by all means.
fn are_enough(
    runs: &mut Deflate,
    bytes: &[u8],
    into: &mut [u8],
    by_all_means: impl Fn(&[u8], &mut [u8]) -> Option<usize>,
) -> bool {
    if bytes.len() < LEAST_BLOCK {
        return false;
    }
    let (low, high) = bytes.split_at(bytes.len() / 2);
    let samples = [low, high].map(|half| &half[(half.len() - SAMPLE) / 2..][..SAMPLE]);
    let sum = |sizes: [Option<usize>; 2]| -> usize {
        sizes.into_iter().map(|size| size.unwrap_or(SAMPLE)).sum()
    };
    let by_runs = sum(samples.map(|sample| compressed(runs, sample, into)));
    by_runs as f64 <= MOST * sum(samples.map(|sample| by_all_means(sample, into))) as f64
}
