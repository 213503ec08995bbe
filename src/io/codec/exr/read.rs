//! Reading channels: whole, or some rows of them.

use super::chunks::ChunkReader;
use super::decode::{COPIES, PictureRows, PlaneTarget, decode_block};
use super::fault::{Fault, Parsed};
use super::layout::BandLayout;
use super::{ChannelId, ExrFile};
use crate::error::Result;
use crate::frame::Plane;
use ::exr::meta::header::Header;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

impl ExrFile {
    /// The samples of the `wanted` channels, in that order.
    ///
    /// Parts and resolution levels without a wanted channel are skipped. Samples are returned as
    /// stored: NaN and infinities included, unsigned integers rounded to 32-bit floating point.
    ///
    /// # Panics
    /// If a wanted channel is not in [`ExrFile::parts`].
    pub fn read_channels(&self, wanted: &[ChannelId]) -> Result<Vec<Plane>> {
        self.read_some(wanted, None)
    }

    /// The rows `rows` of the `wanted` channels, in that order, counted from the top of the data
    /// window of each channel's part.
    ///
    /// Only the blocks with such rows are read. The limits apply to the rows, not to the whole picture.
    ///
    /// # Panics
    /// If a wanted channel is not in [`ExrFile::parts`], or its part has fewer rows.
    pub fn read_rows(&self, wanted: &[ChannelId], rows: Range<usize>) -> Result<Vec<Plane>> {
        self.read_some(wanted, Some(rows))
    }

    /// The rows `rows`, or all, of the `wanted` channels.
    pub(in crate::io) fn read_some(
        &self,
        wanted: &[ChannelId],
        rows: Option<Range<usize>>,
    ) -> Result<Vec<Plane>> {
        self.read_each(wanted, rows)
            .map_err(|fault| fault.at(&self.path))
    }

    fn read_each(&self, wanted: &[ChannelId], rows: Option<Range<usize>>) -> Parsed<Vec<Plane>> {
        let rows_of = |part: usize| {
            let all = 0..self.parts[part].window.height();
            rows.clone().unwrap_or(all)
        };
        self.check_rows(wanted, rows_of)?;
        let blank = |id: &ChannelId| {
            let (width, height) = (self.parts[id.part].window.width(), rows_of(id.part).len());
            Plane::filled(width, height, 0.0)
        };
        let mut planes: Vec<_> = wanted.iter().map(blank).collect();
        let mut chunks = ChunkReader::open(self)?;
        for part in 0..self.parts.len() {
            let header = &self.header.meta.headers[part];
            let targets: Vec<PlaneTarget> = wanted
                .iter()
                .zip(&mut planes)
                .filter(|(id, _)| id.part == part)
                .map(|(id, plane)| PlaneTarget::of_channel(header, id.channel, plane.samples_mut()))
                .collect();
            if !targets.is_empty() {
                let blocks = PartBlocks::open(&mut chunks, part)?;
                blocks.read(&mut chunks, rows_of(part), PictureRows::Samples(targets))?;
            }
        }
        Ok(planes)
    }

    /// Refuses rows of parts that are more than allowed, before anything is allocated.
    fn check_rows(
        &self,
        wanted: &[ChannelId],
        rows_of: impl Fn(usize) -> Range<usize>,
    ) -> Parsed<()> {
        let mut planes = 0;
        for id in wanted {
            let (window, rows) = (self.parts[id.part].window, rows_of(id.part));
            let fits = rows.start <= rows.end && rows.end <= window.height();
            assert!(fits, "rows {rows:?} are not all in {window}");
            let pixels = window.width() as u128 * rows.len() as u128;
            if pixels > u128::from(self.limits.max_pixels) {
                return Err(Fault::Unsupported {
                    found: format!(
                        "holds {window}: {pixels} pixels at one time are more than the {} allowed",
                        self.limits.max_pixels
                    ),
                    remedy: "crop it",
                });
            }
            planes += 4 * pixels;
        }
        let parts: BTreeSet<usize> = wanted.iter().map(|id| id.part).collect();
        let decoding = parts
            .into_iter()
            .map(|part| decoding_bytes(&self.header.meta.headers[part]));
        let decoding = decoding.max().unwrap_or(0);
        self.check_memory(planes + decoding)
    }

    /// Refuses to use more bytes of memory than allowed.
    pub(super) fn check_memory(&self, needed: u128) -> Parsed<()> {
        match needed <= u128::from(self.limits.max_bytes) {
            true => Ok(()),
            false => Err(Fault::Unsupported {
                found: format!(
                    "needs {} MiB of memory to be read, more than the {} MiB allowed",
                    needed >> 20,
                    self.limits.max_bytes >> 20
                ),
                remedy: "crop it, or name fewer layers",
            }),
        }
    }
}

/// Most bytes of the blocks of a part that are decoded at one time.
pub(super) fn decoding_bytes(header: &Header) -> u128 {
    let layout = BandLayout::of(header);
    (COPIES * layout.bands_at_once()) as u128 * layout.band_bytes()
}

/// Offsets of the blocks of a part, at full resolution.
pub(super) struct PartBlocks {
    part: usize,
    pub(super) layout: BandLayout,
    offsets: Vec<u64>,
}

impl PartBlocks {
    pub(super) fn open(chunks: &mut ChunkReader, part: usize) -> Parsed<Self> {
        let layout = BandLayout::of(&chunks.exr.header.meta.headers[part]);
        // The full resolution comes first in every kind of file.
        let offsets = chunks.offsets(part, layout.blocks())?;
        Ok(PartBlocks {
            part,
            layout,
            offsets,
        })
    }

    /// Decodes `rows` into `target`, which holds these rows and no others.
    pub(super) fn read(
        &self,
        chunks: &mut ChunkReader,
        rows: Range<usize>,
        target: PictureRows,
    ) -> Parsed<()> {
        let header = &chunks.exr.header.meta.headers[self.part];
        let mut bands = self.bands(target, &rows).into_iter();
        let mut is_readable = true;
        let read = Mutex::new(std::iter::from_fn(|| {
            let band = bands.next().filter(|_| is_readable)?;
            let blocks = self.read_blocks(chunks, band.index);
            is_readable = blocks.is_ok();
            Some((band, blocks))
        }));
        let next = || read.lock().unwrap_or_else(PoisonError::into_inner).next();

        // One reads while others decode what was read before. No more of them than threads: one that waits for its blocks
        // may begin another, on top of it.
        let faults = (0..self.layout.bands_at_once())
            .into_par_iter()
            .with_max_len(1)
            .filter_map(|_| {
                let faults = std::iter::from_fn(next).filter_map(|(mut band, blocks)| {
                    let decoded = blocks.and_then(|b| self.decode_band(b, &mut band, header));
                    Some((band.index, decoded.err()?))
                });
                faults.min_by_key(|&(index, _)| index)
            });
        // The first of several faults is the one reported, always the same.
        match faults.min_by_key(|&(index, _)| index) {
            Some((_, fault)) => Err(fault),
            None => Ok(()),
        }
    }

    /// Divides rows into bands, the first and the last of which may be partial.
    fn bands<'t>(&self, mut target: PictureRows<'t>, rows: &Range<usize>) -> Vec<WantedBand<'t>> {
        let layout = &self.layout;
        let cut = |index: usize| {
            let whole = layout.rows_of(&(index..index + 1));
            let rows = whole.start.max(rows.start)..whole.end.min(rows.end);
            WantedBand {
                index,
                target: target.split_off_top(rows.len(), layout),
                rows,
            }
        };
        layout.bands_of(rows).map(cut).collect()
    }

    /// The compressed blocks of a band.
    fn read_blocks(&self, chunks: &mut ChunkReader, band: usize) -> Parsed<Vec<Vec<u8>>> {
        let per_band = self.layout.blocks_per_band();
        let most = self.layout.block_bytes().min(i32::MAX as u128) as u64;
        let block = |block: usize| {
            let chunk = chunks.chunk(self.offsets[band * per_band + block], most)?;
            let expected = self.layout.place(band, block);
            match chunk.part as usize == self.part && chunk.place == expected {
                true => Ok(chunk.bytes),
                false => Err(Fault::damaged(format!(
                    "a block of pixels that should be at {expected:?} of part {} is at {:?} of part {}",
                    self.part, chunk.place, chunk.part
                ))),
            }
        };
        (0..per_band).map(block).collect()
    }

    fn decode_band(
        &self,
        blocks: Vec<Vec<u8>>,
        band: &mut WantedBand,
        header: &Header,
    ) -> Parsed<()> {
        let area = |i: usize| self.layout.area(band.index, i);
        let decode = |(i, bytes)| decode_block(bytes, header, self.part, &area(i));
        let decoded: Vec<_> = blocks.into_par_iter().enumerate().map(decode).collect();
        for (i, block) in decoded.into_iter().enumerate() {
            band.target.fill(
                &block?,
                &self.layout.area(band.index, i),
                &band.rows,
                &self.layout,
            );
        }
        Ok(())
    }
}

/// The wanted rows of one band.
struct WantedBand<'t> {
    index: usize,
    rows: Range<usize>,
    target: PictureRows<'t>,
}
