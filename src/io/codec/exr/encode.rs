//! Rows to compressed blocks.

use super::attributes::text_of_bytes;
use super::compression::dwa_spoils;
use super::decode::{OWN_CODEC, is_dwa};
use super::fault::{Fault, Parsed};
use super::write::{OutputType, ReadyPart, SampleSource};
use super::zip;
use crate::frame::Plane;
use crate::io::fence::fenced;
use ::exr::compression::Compression;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{ChannelDescription, IntegerBounds};
use ::exr::meta::header::Header;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use std::borrow::Cow;
use std::cell::RefCell;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Uncompressed bytes that are worked on at one time, unless a single block has more.
pub(super) const BATCH_BYTES: usize = 32 << 20;

/// A block is as large as its rows.
const SIZED: &str = "a block has room for its rows";

thread_local! {
    /// A block before compression: fresh memory for each would cost as much as a pass over it.
    static RAW: RefCell<Vec<u8>> = RefCell::default();
}

/// Compresses the rows of a part, block by block.
///
/// Incomplete blocks wait for the next rows, so the blocks do not depend on how the rows are divided.
pub(super) struct Encoder {
    header: Header,
    sources: Vec<SampleSource>,
    /// Rows of a block.
    pub(super) block_rows: usize,
    /// Rows taken, including those waiting.
    pub(super) taken: usize,
    /// Rows of the incomplete block, in its layout.
    waiting: Vec<u8>,
    /// Samples that were clamped.
    pub(super) clamped: u64,
}

/// Rows to write: the same of every plane.
pub(super) struct Strip<'a> {
    pub(super) planes: &'a [&'a Plane],
    pub(super) rows: Range<usize>,
    /// The same rows of the part that channels are added to, if any, as stored.
    pub(super) kept: &'a [u8],
}

impl Encoder {
    pub(super) fn new(part: &ReadyPart) -> Self {
        Encoder {
            header: part.header.clone(),
            sources: part.sources.clone(),
            block_rows: part.header.compression.scan_lines_per_block(),
            taken: 0,
            waiting: Vec::new(),
            clamped: 0,
        }
    }

    /// Rows that are still to come.
    pub(super) fn missing(&self) -> usize {
        self.header.layer_size.height() - self.taken
    }

    /// Most rows to pass at a time.
    pub(super) fn batch_rows(&self) -> usize {
        let block_bytes = self.block_rows * self.row_bytes();
        let blocks = (BATCH_BYTES / block_bytes.max(1)).clamp(1, 1024);
        blocks * self.block_rows - self.waiting_rows()
    }

    fn row_bytes(&self) -> usize {
        self.header.layer_size.width() * self.header.channels.bytes_per_pixel
    }

    fn waiting_rows(&self) -> usize {
        self.taken % self.block_rows
    }

    /// Takes at least one row, and returns the index of the first completed block, and the bytes of all completed ones.
    ///
    /// `beside` is done once, as threads run out of blocks.
    pub(super) fn take(
        &mut self,
        strip: &Strip,
        beside: &mut (dyn FnMut() + Send),
    ) -> Parsed<(usize, Vec<Vec<u8>>)> {
        let waiting = self.waiting_rows();
        let first = self.taken / self.block_rows;
        let rows = waiting + strip.rows.len();
        let complete = match strip.rows.len() == self.missing() {
            true => rows.div_ceil(self.block_rows),
            false => rows / self.block_rows,
        };
        let encoded = |block: usize| {
            let end = rows.min((block + 1) * self.block_rows);
            let start = block * self.block_rows;
            let laid = start.max(waiting) - waiting..end - waiting;
            let before = match block {
                0 => &self.waiting[..],
                _ => &[],
            };
            RAW.with_borrow_mut(|raw| {
                let raw = zip::sized(raw, (end - start) * self.row_bytes());
                let (given, rest) = raw.split_at_mut(before.len());
                given.copy_from_slice(before);
                let clamped = self.lay_rows(strip, laid, rest);
                let bytes = self.compressed((first + block) * self.block_rows, end - start, raw)?;
                Ok((bytes, clamped))
            })
        };
        let beside = Mutex::new(beside);
        // What is beside comes last: a thread that steals work takes the first half of what is left.
        let blocks: Vec<Parsed<(Vec<u8>, u64)>> = (0..complete + 1)
            .into_par_iter()
            .with_max_len(1)
            .filter_map(|block| {
                if block < complete {
                    return Some(encoded(block));
                }
                let mut beside = beside.lock().unwrap_or_else(PoisonError::into_inner);
                beside();
                None
            })
            .collect();

        let mut rest = std::mem::take(&mut self.waiting);
        if complete > 0 {
            rest.clear();
        }
        let laid = (complete * self.block_rows).clamp(waiting, rows);
        let laid = laid - waiting..strip.rows.len();
        let given = rest.len();
        rest.resize(given + laid.len() * self.row_bytes(), 0);
        self.clamped += self.lay_rows(strip, laid, &mut rest[given..]);
        self.waiting = rest;
        self.taken += strip.rows.len();
        let blocks: Vec<_> = blocks.into_iter().collect::<Parsed<_>>()?;
        self.clamped += blocks.iter().map(|(_, clamped)| clamped).sum::<u64>();
        Ok((first, blocks.into_iter().map(|(bytes, _)| bytes).collect()))
    }

    /// Lays the rows `rows` of a strip out in a block, of which they fill `raw`; returns the number of samples clamped.
    fn lay_rows(&self, strip: &Strip, rows: Range<usize>, mut raw: &mut [u8]) -> u64 {
        let (mut clamped, mut halves) = (0, Vec::new());
        let width = self.header.layer_size.width();
        let kept_bytes = strip.kept.len() / strip.rows.len();
        for y in rows {
            for (source, channel) in self.sources.iter().zip(&self.header.channels.list) {
                let bytes = channel.sample_type.bytes_per_sample();
                let laid = raw.split_off_mut(..bytes * width).expect(SIZED);
                match *source {
                    SampleSource::Given(plane, sample_type) => {
                        let row = strip.planes[plane].row(strip.rows.start + y);
                        let (row, count) = self.within_reach(channel, row);
                        clamped += count + lay_samples(&row, sample_type, &mut halves, laid);
                    }
                    SampleSource::Carried { before } => {
                        let row = &strip.kept[y * kept_bytes..][..kept_bytes];
                        laid.copy_from_slice(&row[before * width..][..bytes * width]);
                    }
                }
            }
        }
        clamped
    }

    /// Samples within the reach of DWA if it treats the channel as colour, and how many of them had to be clamped for it.
    fn within_reach<'r>(
        &self,
        channel: &ChannelDescription,
        row: &'r [f32],
    ) -> (Cow<'r, [f32]>, u64) {
        let name = channel.name.as_slice();
        let is_beyond = |v: &&f32| v.abs() > DWA_MOST;
        if !is_dwa(self.header.compression) || !dwa_spoils(&text_of_bytes(name)) {
            return (row.into(), 0);
        }
        let clamped = row.iter().map(|v| v.clamp(-DWA_MOST, DWA_MOST));
        let count = row.iter().filter(is_beyond).count();
        (clamped.collect(), count as u64)
    }

    fn compressed(&self, first_row: usize, rows: usize, raw: &[u8]) -> Parsed<Vec<u8>> {
        match self.header.compression {
            Compression::Uncompressed if OWN_CODEC => return Ok(raw.to_vec()),
            Compression::ZIP1 | Compression::ZIP16 if OWN_CODEC => {
                let is_smooth = self
                    .sources
                    .iter()
                    .all(|s| matches!(s, SampleSource::Given(..)));
                return Ok(zip::compress(raw, is_smooth).unwrap_or_else(|| raw.to_vec()));
            }
            _ => {}
        }
        let section = IntegerBounds {
            position: Vec2(0, first_row as i32),
            size: Vec2(self.header.layer_size.width(), rows),
        };
        let compress = || {
            let compression = self.header.compression;
            compression.compress_image_section_to_le(&self.header, raw.to_vec(), section)
        };
        match fenced(compress) {
            Some(bytes) => Ok(bytes?),
            None => Err(Fault::damaged("cannot be compressed")),
        }
    }
}

/// Colours up to this magnitude stay finite through DWA.
///
/// DWA stores `1 + ln(v) / 2.2` for values above 1, as cosines of 8x8 pixels with errors of their tolerance and of
/// rounding to half floats; above 65520 a half float is infinite. So the errors at a pixel may add up to `ln(65520 /
/// 32768) / 2.2 = 0.315`. Tolerances are 0.00045 times JPEG's tables over their least entry, and a cosine is at most
/// 1/4 at a pixel: 0.0415 in luminance, and 0.036 in each chroma. Rounding adds 2^-11 of each cosine, which with values
/// up to 5.73 (their squares add up to 64 times that of a pixel) is at most `2^-13 * sqrt(64 * 64 * 5.73^2) = 0.045`
/// and half of it for chroma. Blue is luminance plus 1.8556 times a chroma: `0.0865 + 1.8556 * 0.0585 = 0.195`, plus
/// 0.004 for its own rounding before and after.
const DWA_MOST: f32 = 32768.0;

/// Lays out a row of samples, which fills `raw`; returns the number of finite ones too large for their type.
fn lay_samples(row: &[f32], sample_type: OutputType, halves: &mut Vec<f16>, raw: &mut [u8]) -> u64 {
    let mut clamped = 0;
    match sample_type {
        OutputType::Float => {
            for (to, v) in raw.as_chunks_mut().0.iter_mut().zip(row) {
                *to = v.to_ne_bytes();
            }
        }
        OutputType::Half => {
            halves.resize(row.len(), f16::ZERO);
            halves.convert_from_f32_slice(row);
            // Rare: finite samples that became infinite. All are looked at, many at a time.
            let is_infinite = |any, half: &f16| any | half.is_infinite();
            if halves.iter().fold(false, is_infinite) {
                let both = halves.iter_mut().zip(row);
                for (half, _) in both.filter(|(half, v)| half.is_infinite() && v.is_finite()) {
                    *half = f16::MAX.copysign(*half);
                    clamped += 1;
                }
            }
            for (to, v) in raw.as_chunks_mut().0.iter_mut().zip(halves.iter()) {
                *to = v.to_ne_bytes();
            }
        }
    }
    clamped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_saturates_and_rounds_to_nearest() {
        let half = |v: f32| {
            let mut raw = [0; 2];
            lay_samples(&[v], OutputType::Half, &mut Vec::new(), &mut raw);
            f16::from_ne_bytes(raw).to_f32()
        };
        assert_eq!(half(1e9), 65504.0);
        assert_eq!(half(-65530.0), -65504.0);
        assert_eq!(half(f32::INFINITY), f32::INFINITY);
        assert!(half(f32::NAN).is_nan());
        // 2049 lies between 2048 and 2050: a tie goes to the even mantissa.
        assert_eq!(half(2049.0), 2048.0);
        assert_eq!(half(2051.0), 2052.0);
    }
}
