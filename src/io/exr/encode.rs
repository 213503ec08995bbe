//! Rows to compressed blocks.

use super::decode::OWN_CODEC;
use super::fault::{Fault, Parsed};
use super::write::{OutputType, ReadyPart, Source};
use super::zip;
use crate::frame::Plane;
use crate::io::fence::fenced;
use ::exr::compression::Compression;
use ::exr::math::Vec2;
use ::exr::meta::attribute::IntegerBounds;
use ::exr::meta::header::Header;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use std::ops::Range;

/// Uncompressed bytes that are worked on at one time, unless a single block has more.
const BATCH_BYTES: usize = 32 << 20;

/// Compresses the rows of a part, block by block.
///
/// Rows that do not fill a block wait for the next ones, so the blocks do not depend on how the rows
/// are cut.
pub(super) struct Encoder {
    header: Header,
    sources: Vec<Source>,
    /// Rows of a block.
    block_rows: usize,
    /// Rows that have been taken, those that wait included.
    taken: usize,
    /// Rows that wait, as they will stand in their block.
    waiting: Vec<u8>,
}

/// Rows to be written: the same of every plane that is given.
pub(super) struct Strip<'a> {
    pub(super) planes: &'a [&'a Plane],
    pub(super) rows: Range<usize>,
    /// The same rows of the part that is added to, if there is one, as it stores them.
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
        }
    }

    /// The rows that have been taken.
    pub(super) fn taken(&self) -> usize {
        self.taken
    }

    /// Rows that are still to come.
    pub(super) fn missing(&self) -> usize {
        self.header.layer_size.height() - self.taken
    }

    /// How many rows should be given at one time, at most.
    pub(super) fn batch_rows(&self) -> usize {
        let block_bytes = self.block_rows * self.row_bytes();
        let blocks = (BATCH_BYTES / block_bytes.max(1)).clamp(1, 1024);
        blocks * self.block_rows - self.waiting_rows()
    }

    pub(super) fn block_rows(&self) -> usize {
        self.block_rows
    }

    fn row_bytes(&self) -> usize {
        self.header.layer_size.width() * self.header.channels.bytes_per_pixel
    }

    fn waiting_rows(&self) -> usize {
        self.taken % self.block_rows
    }

    /// Takes rows, at least one, and returns the index of the first block that became complete, and their bytes.
    pub(super) fn take(&mut self, strip: &Strip) -> Parsed<(usize, Vec<Vec<u8>>)> {
        let waiting = self.waiting_rows();
        let first = self.taken / self.block_rows;
        let rows = waiting + strip.rows.len();
        let complete = match strip.rows.len() == self.missing() {
            true => rows.div_ceil(self.block_rows),
            false => rows / self.block_rows,
        };
        let blocks: Vec<Parsed<Vec<u8>>> = (0..complete)
            .into_par_iter()
            .map(|block| {
                let end = rows.min((block + 1) * self.block_rows);
                let start = block * self.block_rows;
                let mut raw = Vec::with_capacity((end - start) * self.row_bytes());
                if block == 0 {
                    raw.extend_from_slice(&self.waiting);
                }
                self.lay_rows(strip, start.max(waiting) - waiting..end - waiting, &mut raw);
                self.compressed((first + block) * self.block_rows, end - start, raw)
            })
            .collect();

        let mut rest = std::mem::take(&mut self.waiting);
        if complete > 0 {
            rest.clear();
        }
        let laid = (complete * self.block_rows).clamp(waiting, rows);
        self.lay_rows(strip, laid - waiting..strip.rows.len(), &mut rest);
        self.waiting = rest;
        self.taken += strip.rows.len();
        Ok((first, blocks.into_iter().collect::<Parsed<_>>()?))
    }

    /// Appends the rows `rows` of a strip as they stand in a block.
    fn lay_rows(&self, strip: &Strip, rows: Range<usize>, raw: &mut Vec<u8>) {
        let mut halves = Vec::new();
        let width = self.header.layer_size.width();
        let kept_bytes = strip.kept.len() / strip.rows.len();
        for y in rows {
            for source in &self.sources {
                match *source {
                    Source::Given(plane, sample_type) => {
                        let row = strip.planes[plane].row(strip.rows.start + y);
                        lay_samples(row, sample_type, &mut halves, raw);
                    }
                    Source::Kept { before, bytes } => {
                        let row = &strip.kept[y * kept_bytes..][..kept_bytes];
                        raw.extend_from_slice(&row[before * width..][..bytes * width]);
                    }
                }
            }
        }
    }

    fn compressed(&self, first_row: usize, rows: usize, raw: Vec<u8>) -> Parsed<Vec<u8>> {
        match self.header.compression {
            Compression::Uncompressed if OWN_CODEC => return Ok(raw),
            Compression::ZIP1 | Compression::ZIP16 if OWN_CODEC => return Ok(zip::compress(raw)),
            _ => {}
        }
        let section = IntegerBounds {
            position: Vec2(0, first_row as i32),
            size: Vec2(self.header.layer_size.width(), rows),
        };
        let compress = || {
            let compression = self.header.compression;
            compression.compress_image_section_to_le(&self.header, raw, section)
        };
        match fenced(compress) {
            Some(bytes) => Ok(bytes?),
            None => Err(Fault::damaged("cannot be compressed")),
        }
    }
}

fn lay_samples(row: &[f32], sample_type: OutputType, halves: &mut Vec<f16>, raw: &mut Vec<u8>) {
    let start = raw.len();
    match sample_type {
        OutputType::Float => {
            raw.resize(start + 4 * row.len(), 0);
            for (to, v) in raw[start..].as_chunks_mut().0.iter_mut().zip(row) {
                *to = v.to_ne_bytes();
            }
        }
        OutputType::Half => {
            halves.resize(row.len(), f16::ZERO);
            halves.convert_from_f32_slice(row);
            // Rare: what was finite and is no more.
            if halves.iter().any(|half| half.is_infinite()) {
                for (half, &v) in halves.iter_mut().zip(row) {
                    *half = f16::from_f32(clamped_to_half(v));
                }
            }
            raw.resize(start + 2 * row.len(), 0);
            for (to, v) in raw[start..].as_chunks_mut().0.iter_mut().zip(halves.iter()) {
                *to = v.to_ne_bytes();
            }
        }
    }
}

/// `v`, moved into the range of half precision if it is finite.
fn clamped_to_half(v: f32) -> f32 {
    match v.is_finite() {
        true => v.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()),
        false => v,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_saturates_and_rounds_to_nearest() {
        let half = |v: f32| f16::from_f32(clamped_to_half(v)).to_f32();
        assert_eq!(half(1e9), 65504.0);
        assert_eq!(half(-65530.0), -65504.0);
        assert_eq!(half(f32::INFINITY), f32::INFINITY);
        assert!(half(f32::NAN).is_nan());
        // 2049 lies between 2048 and 2050: a tie goes to the even mantissa.
        assert_eq!(half(2049.0), 2048.0);
        assert_eq!(half(2051.0), 2052.0);
    }
}
