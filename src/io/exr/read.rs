//! Reading channels.

use super::chunks::{ChunkReader, Place, RawChunk};
use super::decode::{Slot, decompress, scatter};
use super::fault::{Fault, Parsed};
use super::{ChannelId, ExrFile};
use crate::error::Result;
use crate::frame::Plane;
use ::exr::meta::attribute::TileDescription;
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use rayon::prelude::*;
use std::ops::Range;

/// Decoded bytes that are worked on at one time, unless a single band has more.
const BATCH_BYTES: usize = 32 << 20;

impl ExrFile {
    /// The samples of the `wanted` channels, in that order.
    ///
    /// Parts and resolution levels without a wanted channel are skipped. Samples are returned as
    /// stored: NaN and infinities included, unsigned integers rounded to 32-bit floating point.
    ///
    /// # Panics
    /// If a wanted channel is not in [`ExrFile::parts`].
    pub fn read_channels(&self, wanted: &[ChannelId]) -> Result<Vec<Plane>> {
        self.read_parts(wanted)
            .map_err(|fault| fault.at(&self.path))
    }

    fn read_parts(&self, wanted: &[ChannelId]) -> Parsed<Vec<Plane>> {
        self.check_memory(wanted)?;
        let mut samples: Vec<Vec<f32>> = wanted
            .iter()
            .map(|id| vec![0.0; self.pixels(id.part)])
            .collect();
        let mut chunks = ChunkReader::open(self)?;
        for part in 0..self.parts.len() {
            let header = &self.header.meta.headers[part];
            let planes: Vec<(Slot, &mut [f32])> = wanted
                .iter()
                .zip(&mut samples)
                .filter(|(id, _)| id.part == part)
                .map(|(id, plane)| (Slot::of_channel(header, id.channel), plane.as_mut_slice()))
                .collect();
            if !planes.is_empty() {
                read_part(&mut chunks, &self.header.meta, part, planes)?;
            }
        }
        let plane = |(id, samples): (&ChannelId, Vec<f32>)| {
            let window = self.parts[id.part].window;
            Plane::from_samples(window.width(), window.height(), samples)
        };
        Ok(wanted.iter().zip(samples).map(plane).collect())
    }

    fn pixels(&self, part: usize) -> usize {
        self.header.meta.headers[part].layer_size.area()
    }

    /// Refuses what would need more memory than allowed, before any is allocated.
    fn check_memory(&self, wanted: &[ChannelId]) -> Parsed<()> {
        let planes = wanted.iter().map(|id| 4 * self.pixels(id.part) as u128);
        // Two batches of compressed blocks, one of decompressed ones.
        let headers = &self.header.meta.headers;
        let bands = wanted
            .iter()
            .map(|id| 3 * Layout::of(&headers[id.part]).band_bytes());
        let needed = planes.sum::<u128>() + bands.max().unwrap_or(0);
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

/// How a part is divided: into bands over its full width, and those into blocks.
struct Layout {
    /// Rows in a band; the last one may have fewer.
    rows: usize,
    bands: usize,
    blocks_per_band: usize,
    /// Most bytes of one block.
    block_bytes: u128,
    /// First row of the part.
    top: i32,
    tiled: bool,
}

impl Layout {
    fn of(header: &Header) -> Layout {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        let (columns, rows, tiled) = match header.blocks {
            BlockDescription::ScanLines => {
                (width, header.compression.scan_lines_per_block(), false)
            }
            BlockDescription::Tiles(TileDescription { tile_size, .. }) => {
                (tile_size.width(), tile_size.height(), true)
            }
        };
        // A tile may be larger than the picture; its block is not.
        let block_pixels = columns.min(width) as u128 * rows.min(height) as u128;
        Layout {
            rows,
            bands: height.div_ceil(rows),
            blocks_per_band: width.div_ceil(columns),
            block_bytes: block_pixels * header.channels.bytes_per_pixel as u128,
            top: header.own_attributes.layer_position.y(),
            tiled,
        }
    }

    fn band_bytes(&self) -> u128 {
        self.block_bytes * self.blocks_per_band as u128
    }

    fn bands_per_batch(&self) -> usize {
        let fitting = BATCH_BYTES as u128 / self.band_bytes().max(1);
        (fitting as usize).clamp(1, 1024)
    }

    /// What the chunk of block `block` in band `band` has to say about its place.
    fn place(&self, band: usize, block: usize) -> Place {
        match self.tiled {
            true => Place::Tile([block as i32, band as i32, 0, 0]),
            false => Place::Row(self.top + (band * self.rows) as i32),
        }
    }
}

/// The rows of one band in every wanted plane.
type Band<'a> = Vec<(Slot, &'a mut [f32])>;

fn read_part(
    chunks: &mut ChunkReader,
    meta: &MetaData,
    part: usize,
    planes: Vec<(Slot, &mut [f32])>,
) -> Parsed<()> {
    let header = &meta.headers[part];
    let layout = Layout::of(header);
    // The full resolution comes first in every kind of file.
    let offsets = chunks.offsets(part, layout.bands * layout.blocks_per_band)?;
    let mut bands = bands_of(planes, &layout, header);

    // The next batch is read while one is decoded.
    let per_batch = layout.bands_per_batch();
    let batch = |first: usize| first..(first + per_batch).min(layout.bands);
    let mut pending = read_bands(chunks, part, &layout, &offsets, batch(0))?;
    for (i, bands) in bands.chunks_mut(per_batch).enumerate() {
        let first = i * per_batch;
        let (next, decoded) = rayon::join(
            || read_bands(chunks, part, &layout, &offsets, batch(first + per_batch)),
            || decode_bands(pending, bands, first, &layout, meta),
        );
        decoded?;
        pending = next?;
    }
    Ok(())
}

/// Divides the planes of a part into bands.
fn bands_of<'a>(
    planes: Vec<(Slot, &'a mut [f32])>,
    layout: &Layout,
    header: &Header,
) -> Vec<Band<'a>> {
    let band_samples = layout.rows.saturating_mul(header.layer_size.width());
    let mut bands: Vec<Band> = (0..layout.bands).map(|_| Band::new()).collect();
    for (slot, plane) in planes {
        for (band, rows) in bands.iter_mut().zip(plane.chunks_mut(band_samples)) {
            band.push((slot, rows));
        }
    }
    bands
}

/// The chunks of the bands `range`, band by band.
fn read_bands(
    chunks: &mut ChunkReader,
    part: usize,
    layout: &Layout,
    offsets: &[u64],
    range: Range<usize>,
) -> Parsed<Vec<Vec<RawChunk>>> {
    let most = layout.block_bytes.min(i32::MAX as u128) as u64;
    let mut chunk = |band: usize, block: usize| {
        let offset = offsets[band * layout.blocks_per_band + block];
        let chunk = chunks.chunk(offset, most)?;
        let expected = layout.place(band, block);
        match chunk.part as usize == part && chunk.place == expected {
            true => Ok(chunk),
            false => Err(Fault::damaged(format!(
                "a block of pixels that should be {expected:?} of part {part} is {:?} of part {}",
                chunk.place, chunk.part
            ))),
        }
    };
    let mut band = |band| {
        (0..layout.blocks_per_band)
            .map(|b| chunk(band, b))
            .collect()
    };
    range.map(&mut band).collect()
}

fn decode_bands(
    chunks: Vec<Vec<RawChunk>>,
    bands: &mut [Band],
    first: usize,
    layout: &Layout,
    meta: &MetaData,
) -> Parsed<()> {
    let results: Vec<Parsed<()>> = chunks
        .into_par_iter()
        .zip(bands)
        .enumerate()
        .map(|(i, (chunks, band))| decode_band(chunks, band, (first + i) * layout.rows, meta))
        .collect();
    // In order, so that of several faults always the same one is reported.
    results.into_iter().collect()
}

fn decode_band(
    chunks: Vec<RawChunk>,
    band: &mut Band,
    first_row: usize,
    meta: &MetaData,
) -> Parsed<()> {
    let blocks: Vec<_> = chunks
        .into_par_iter()
        .map(|chunk| decompress(chunk, meta))
        .collect();
    for block in blocks {
        let block = block?;
        scatter(&block, &meta.headers[block.index.layer], first_row, band);
    }
    Ok(())
}
