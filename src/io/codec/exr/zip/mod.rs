//! ZIP compression: zlib over reordered and differenced bytes.
//!
//! A block is split into the bytes at even positions followed by those at odd positions; then each byte but the first
//! is replaced by its difference from the previous one, plus 128. Samples are stored low byte first, so a pair of
//! bytes, one of each half, is a half float or half of a 32-bit sample. Only requested pairs are assembled: of the rest
//! only the sum is needed.

#[cfg(feature = "libdeflate")]
mod libdeflate;
mod smooth;
#[cfg(not(feature = "libdeflate"))]
mod zlib;

use super::fault::{Fault, Parsed};
#[cfg(feature = "libdeflate")]
use libdeflate as zlib;
use std::cell::RefCell;

/// Undoes zlib. `into` must have the size of the block, which must have just that many bytes.
pub(super) fn inflate(compressed: &[u8], into: &mut [u8]) -> Parsed<()> {
    match zlib::inflate(compressed, into) {
        Some(bytes) if bytes == into.len() => Ok(()),
        _ => Err(Fault::damaged("is damaged (ZIP-compressed pixels)")),
    }
}

thread_local! {
    /// The differences of a block and its compressed bytes: fresh memory would cost as much as a pass over it.
    static BUFFERS: RefCell<[Vec<u8>; 2]> = RefCell::default();
}

/// Compresses a block, of samples computed here alone or not; `None` if it would not shrink.
pub(super) fn compress(raw: &[u8], is_smooth: bool) -> Option<Vec<u8>> {
    BUFFERS.with_borrow_mut(|buffers| {
        let [differences, bytes] = buffers.each_mut().map(|buffer| sized(buffer, raw.len()));
        difference(raw, differences);
        let size = match is_smooth {
            true => smooth::deflate(differences, bytes, &zlib::QUICKER, zlib::deflate),
            false => zlib::deflate(differences, bytes),
        };
        let size = size.filter(|&size| size < raw.len())?;
        Some(bytes[..size].to_vec())
    })
}

/// The first `count` bytes of a buffer that grows as needed, with anything in them.
pub(super) fn sized(buffer: &mut Vec<u8>, count: usize) -> &mut [u8] {
    if buffer.len() < count {
        buffer.resize(count, 0);
    }
    &mut buffer[..count]
}

/// Sorts and differences the bytes of a block, an even number of them.
fn difference(raw: &[u8], differences: &mut [u8]) {
    let (pairs, _) = raw.as_chunks::<2>();
    let (Some(first), Some(last)) = (pairs.first(), pairs.last()) else {
        return;
    };
    let (low, high) = differences.split_at_mut(pairs.len());
    let delta = |byte: u8, before: u8| byte.wrapping_sub(before).wrapping_add(128);
    // The high bytes come after the last of the low ones.
    (low[0], high[0]) = (first[0], delta(first[1], last[0]));
    // Words split by shifts, without a branch, so that the compiler takes many at a time.
    let count = pairs.len() - 1;
    let (low, high) = (&mut low[1..][..count], &mut high[1..][..count]);
    let (before, now) = (&pairs[..count], &pairs[1..][..count]);
    for i in 0..count {
        let [now, before] = [now[i], before[i]].map(u16::from_le_bytes);
        low[i] = delta(now as u8, before as u8);
        high[i] = delta((now >> 8) as u8, (before >> 8) as u8);
    }
}

/// The pairs of bytes of a block whose zlib compression has been undone, from first to last.
pub(super) struct Pairs<'b> {
    low: &'b [u8],
    high: &'b [u8],
    /// The byte before the next one of each half; 128 before the first of all.
    low_sum: u8,
    high_sum: u8,
}

impl<'b> Pairs<'b> {
    /// The pairs of `differences`, an even number of bytes.
    pub(super) fn new(differences: &'b [u8]) -> Self {
        let (low, high) = differences.split_at(differences.len() / 2);
        Pairs {
            low,
            high,
            low_sum: 128,
            high_sum: total(128, low),
        }
    }

    /// Passes over `count` pairs.
    pub(super) fn skip(&mut self, count: usize) {
        let (low, high) = self.next(count);
        self.low_sum = total(self.low_sum, low);
        self.high_sum = total(self.high_sum, high);
    }

    /// Assembles enough pairs to fill `into`.
    pub(super) fn take(&mut self, into: &mut [u16]) {
        let (low, high) = self.next(into.len());
        let (into, into_rest) = into.as_chunks_mut::<8>();
        let (low, low_rest) = low.as_chunks::<8>();
        let (high, high_rest) = high.as_chunks::<8>();
        for ((into, &low), &high) in into.iter_mut().zip(low).zip(high) {
            let low = sums(low, &mut self.low_sum);
            let high = sums(high, &mut self.high_sum);
            let [even, odd] = [low[0] | high[0] << 8, low[1] | high[1] << 8];
            for i in 0..4 {
                into[2 * i] = (even >> (16 * i)) as u16;
                into[2 * i + 1] = (odd >> (16 * i)) as u16;
            }
        }
        for ((into, low), high) in into_rest.iter_mut().zip(low_rest).zip(high_rest) {
            self.low_sum = total(self.low_sum, &[*low]);
            self.high_sum = total(self.high_sum, &[*high]);
            *into = u16::from_le_bytes([self.low_sum, self.high_sum]);
        }
    }

    fn next(&mut self, count: usize) -> (&'b [u8], &'b [u8]) {
        let (low, high) = (&self.low[..count], &self.high[..count]);
        (self.low, self.high) = (&self.low[count..], &self.high[count..]);
        (low, high)
    }
}

/// The byte that `differences` lead to from `before`.
fn total(before: u8, differences: &[u8]) -> u8 {
    let sum = differences
        .iter()
        .fold(before, |sum, &d| sum.wrapping_add(d));
    // Each was stored with 128 added, and two of those cancel.
    sum.wrapping_add(128 * (differences.len() % 2) as u8)
}

/// The eight bytes reached from `before` by `differences`; `before` becomes the last of them: those at even and those
/// at odd positions, in 16-bit lanes.
///
/// All eight sums are computed at once: multiplying by 1 in every lane adds to each lane those below it.
fn sums(differences: [u8; 8], before: &mut u8) -> [u64; 2] {
    const ONES: u64 = 0x0001_0001_0001_0001;
    const BYTES: u64 = 0x00ff * ONES;
    let bytes = u64::from_le_bytes(differences) ^ 0x8080_8080_8080_8080;
    let odd = (bytes >> 8) & BYTES;
    let pairs = (bytes & BYTES) + odd;
    // At most 255 + 4 * 510 in a lane, so none overflows into the next.
    let odd_sums = pairs.wrapping_mul(ONES) + u64::from(*before) * ONES;
    *before = (odd_sums >> 48) as u8;
    [(odd_sums - odd) & BYTES, odd_sums & BYTES]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes that look random (a linear congruential generator), with runs.
    fn bytes(count: usize) -> Vec<u8> {
        let mut state = 7u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        (0..count)
            .map(|i| if i / 50 % 2 == 0 { next() } else { 9 })
            .collect()
    }

    #[test]
    fn a_block_comes_back() {
        // From 131072 bytes on quicker ways are tried: these have some runs, and others that grow by and by.
        let steps: Vec<u8> = (0..200_000u32)
            .flat_map(|i| (i / 40).to_le_bytes())
            .collect();
        let counts = [2, 16, 30, 1000, 4096, 200_000].map(bytes);
        for (raw, is_smooth) in counts
            .into_iter()
            .chain([steps])
            .flat_map(|raw| [(raw.clone(), false), (raw, true)])
        {
            let count = raw.len();
            let mut differences = vec![0; count];
            match compress(&raw, is_smooth) {
                Some(compressed) => {
                    assert!(compressed.len() < count);
                    inflate(&compressed, &mut differences).unwrap();
                }
                None => difference(&raw, &mut differences),
            }
            let mut words = vec![0; count / 2];
            Pairs::new(&differences).take(&mut words);
            let back: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
            assert_eq!(back, raw, "{count}");
        }
    }

    #[test]
    fn pairs_may_be_passed_over() {
        let raw = bytes(2000);
        let mut differences = vec![0; raw.len()];
        difference(&raw, &mut differences);
        let mut pairs = Pairs::new(&differences);
        let mut next = 0;
        // Skipped and taken: none, few, odd, more than a lane holds.
        for (skipped, taken) in [(0, 3), (5, 0), (1, 17), (300, 8), (64, 100)] {
            pairs.skip(skipped);
            next += skipped;
            let mut words = vec![0; taken];
            pairs.take(&mut words);
            let expected = raw.as_chunks().0[next..next + taken].iter();
            assert!(
                words.iter().eq(expected
                    .map(|&b| u16::from_le_bytes(b))
                    .collect::<Vec<_>>()
                    .iter())
            );
            next += taken;
        }
    }

    #[test]
    fn a_stream_of_another_size_is_damaged() {
        let raw = vec![0; 400];
        let compressed = compress(&raw, false).unwrap();
        assert!(inflate(&compressed, &mut [0; 400]).is_ok());
        assert!(inflate(&compressed, &mut [0; 399]).is_err());
        assert!(inflate(&compressed, &mut [0; 401]).is_err());
        assert!(inflate(&compressed[..compressed.len() - 5], &mut [0; 400]).is_err());
    }
}
