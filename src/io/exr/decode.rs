//! Chunks to samples, with everything a chunk claims checked before it is believed.

use super::attributes::text_of_bytes;
use super::chunks::{Place, RawChunk};
use super::fault::{Fault, Parsed};
use crate::io::fence::fenced;
use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::{
    Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates,
};
use ::exr::compression::Compression;
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;
use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};

/// A channel to be read: where its samples lie in a row of a decompressed block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    /// Bytes per pixel of the channels before it.
    before: usize,
    sample_type: SampleType,
}

impl Slot {
    pub(super) fn of_channel(header: &Header, channel: usize) -> Slot {
        let list = &header.channels.list;
        Slot {
            before: bytes_per_pixel(&list[..channel]),
            sample_type: list[channel].sample_type,
        }
    }

    /// Converts this channel's samples of one row of a block, `pixels` wide.
    fn convert(self, row: &[u8], pixels: usize, bits: &mut Vec<u16>, into: &mut [f32]) {
        let bytes = self.sample_type.bytes_per_sample();
        let from = &row[self.before * pixels..][..bytes * pixels];
        match self.sample_type {
            SampleType::F16 => {
                bits.clear();
                bits.extend(from.as_chunks().0.iter().map(|&b| u16::from_ne_bytes(b)));
                let halves: &[f16] = bits.reinterpret_cast();
                halves.convert_to_f32_slice(into);
            }
            SampleType::F32 => {
                for (to, &b) in into.iter_mut().zip(from.as_chunks().0) {
                    *to = f32::from_ne_bytes(b);
                }
            }
            SampleType::U32 => {
                for (to, &b) in into.iter_mut().zip(from.as_chunks().0) {
                    *to = u32::from_ne_bytes(b) as f32;
                }
            }
        }
    }
}

fn bytes_per_pixel(channels: &[::exr::meta::attribute::ChannelDescription]) -> usize {
    channels
        .iter()
        .map(|c| c.sample_type.bytes_per_sample())
        .sum()
}

/// Copies the wanted channels of `block` into `rows`: for each slot, full rows of the picture that
/// start with row `first_row`.
pub(super) fn scatter(
    block: &UncompressedBlock,
    header: &Header,
    first_row: usize,
    rows: &mut [(Slot, &mut [f32])],
) {
    let Vec2(x, y) = block.index.pixel_position;
    let width = block.index.pixel_size.width();
    let row_bytes = header.channels.bytes_per_pixel * width;
    let picture_width = header.layer_size.width();
    let mut bits = Vec::with_capacity(width);
    for (i, row) in block.data.chunks_exact(row_bytes).enumerate() {
        let start = (y - first_row + i) * picture_width + x;
        for (slot, samples) in rows.iter_mut() {
            slot.convert(row, width, &mut bits, &mut samples[start..start + width]);
        }
    }
}

/// Decompresses a chunk that lies where its part says.
pub(super) fn decompress(chunk: RawChunk, meta: &MetaData) -> Parsed<UncompressedBlock> {
    let part = chunk.part as usize;
    let header = &meta.headers[part];
    let pixels = block_size(&chunk, header)?;
    if matches!(
        header.compression,
        Compression::DWAA(_) | Compression::DWAB(_)
    ) {
        check_dwa_counters(&chunk.bytes, pixels, header)?;
    }
    let chunk = Chunk {
        layer_index: part,
        compressed_block: compressed_block(chunk),
    };
    match fenced(|| UncompressedBlock::decompress_chunk(chunk, meta, false)) {
        Some(block) => Ok(block?),
        None => Err(Fault::damaged(format!(
            "a block of pixels in part {} contradicts itself",
            part_name(part, header)
        ))),
    }
}

fn part_name(index: usize, header: &Header) -> String {
    match &header.own_attributes.layer_name {
        Some(name) => format!("{:?}", text_of_bytes(name.as_slice())),
        None => index.to_string(),
    }
}

fn block_size(chunk: &RawChunk, header: &Header) -> Parsed<Vec2<usize>> {
    let tile = match chunk.place {
        Place::Row(y) => header.get_scan_line_block_tile_coordinates(y)?,
        Place::Tile(place) => tile_coordinates(place),
    };
    Ok(header.get_absolute_block_pixel_coordinates(tile)?.size)
}

fn compressed_block(chunk: RawChunk) -> CompressedBlock {
    let compressed_pixels_le = chunk.bytes;
    match chunk.place {
        Place::Row(y_coordinate) => CompressedBlock::ScanLine(CompressedScanLineBlock {
            y_coordinate,
            compressed_pixels_le,
        }),
        Place::Tile(place) => CompressedBlock::Tile(CompressedTileBlock {
            coordinates: tile_coordinates(place),
            compressed_pixels_le,
        }),
    }
}

/// Tile coordinates that have been compared with those expected, so none is negative.
fn tile_coordinates([x, y, level_x, level_y]: [i32; 4]) -> TileCoordinates {
    TileCoordinates {
        tile_index: Vec2(x as usize, y as usize),
        level_index: Vec2(level_x as usize, level_y as usize),
    }
}

/// Refuses DWA chunks whose counters exceed what a block of `size` pixels can hold: the decoder
/// allocates as much as they say.
fn check_dwa_counters(bytes: &[u8], size: Vec2<usize>, header: &Header) -> Parsed<()> {
    let raw = size.area() * header.channels.bytes_per_pixel;
    if bytes.is_empty() || bytes.len() == raw {
        return Ok(()); // all zero, or not compressed
    }
    let counters: Vec<u64> = bytes
        .as_chunks()
        .0
        .iter()
        .take(11)
        .map(|&b| u64::from_le_bytes(b))
        .collect();
    let &[_, unknown, c0, c1, c2, c3, rle, rle_raw, ac, dc, _] = counters.as_slice() else {
        return Err(Fault::damaged(
            "a DWA block is shorter than its own counters",
        ));
    };
    let squares = size.width().div_ceil(8) * size.height().div_ceil(8);
    let (raw, squares) = (raw as u64, (squares * header.channels.list.len()) as u64);
    let stored = [c0, c1, c2, c3]
        .iter()
        .try_fold(0u64, |sum, &c| sum.checked_add(c));
    let credible = stored.is_some_and(|s| s <= bytes.len() as u64)
        && unknown <= raw
        && rle_raw <= raw
        // Runs may be stored one by one, at two bytes for one.
        && rle <= 2 * raw + 64
        && ac <= 64 * squares
        && dc <= squares;
    match credible {
        true => Ok(()),
        false => Err(Fault::damaged(
            "a DWA block claims more data than its pixels have",
        )),
    }
}
