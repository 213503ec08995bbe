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

/// The words of a block of `size` bytes, an even number; the stream must have just that many.
pub(super) fn inflate(compressed: &[u8], size: usize) -> Parsed<Vec<u16>> {
    let mut bytes = vec![0; size];
    if zlib::inflate(compressed, &mut bytes) != Some(size) {
        return Err(Fault::damaged("is damaged (ZIP-compressed pixels)"));
    }
    Ok(words(bytes))
}

/// The words that were sorted and differenced.
fn words(mut differences: Vec<u8>) -> Vec<u16> {
    let mut sum = 128_u8;
    for byte in &mut differences {
        // The same as 128 less.
        sum = sum.wrapping_add(*byte ^ 128);
        *byte = sum;
    }
    let (low, high) = differences.split_at(differences.len() / 2);
    let pairs = low.iter().zip(high);
    pairs
        .map(|(&low, &high)| u16::from_le_bytes([low, high]))
        .collect()
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
            let words = match compress(&raw, is_smooth) {
                Some(compressed) => {
                    assert!(compressed.len() < count);
                    inflate(&compressed, count).unwrap()
                }
                None => {
                    let mut differences = vec![0; count];
                    difference(&raw, &mut differences);
                    words(differences)
                }
            };
            let back: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
            assert_eq!(back, raw, "{count}");
        }
    }

    #[test]
    fn a_stream_of_another_size_is_damaged() {
        let raw = vec![0; 400];
        let compressed = compress(&raw, false).unwrap();
        assert!(inflate(&compressed, 400).is_ok());
        assert!(inflate(&compressed, 399).is_err());
        assert!(inflate(&compressed, 401).is_err());
        assert!(inflate(&compressed[..compressed.len() - 5], 400).is_err());
    }
}
