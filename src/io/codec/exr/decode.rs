//! Chunks to samples, with everything a chunk claims checked before it is believed.

use super::attributes::text_of_bytes;
use super::fault::{Fault, Parsed};
use super::layout::{Area, BandLayout};
use super::zip::inflate;
use crate::io::fence::fenced;
use ::exr::compression::Compression;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{IntegerBounds, SampleType};
use ::exr::meta::header::Header;
use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use std::ops::Range;

/// Whether ZIP and uncompressed blocks are decoded and encoded here: on machines that store numbers in the byte order
/// of the files, low byte first.
pub(super) const OWN_CODEC: bool = cfg!(target_endian = "little");

/// The 16-bit words of a decompressed block, in the order of memory: for each row, all samples of one channel after
/// another.
pub(super) type BlockWords = Vec<u16>;

/// The rows of a plane, as wide as the picture, that a channel is read to.
pub(super) struct PlaneTarget<'t> {
    /// Bytes per pixel of the channels before it in a row of a decompressed block.
    before: usize,
    sample_type: SampleType,
    samples: &'t mut [f32],
}

impl<'t> PlaneTarget<'t> {
    pub(super) fn of_channel(header: &Header, channel: usize, samples: &'t mut [f32]) -> Self {
        let list = &header.channels.list;
        let before = list[..channel].iter();
        PlaneTarget {
            before: before.map(|c| c.sample_type.bytes_per_sample()).sum(),
            sample_type: list[channel].sample_type,
            samples,
        }
    }
}

/// Converts samples given as 16-bit words, in the order of memory.
fn convert(sample_type: SampleType, words: &[u16], into: &mut [f32]) {
    let bits = |&[a, b]: &[u16; 2]| {
        let ([a, b], [c, d]) = (a.to_ne_bytes(), b.to_ne_bytes());
        u32::from_ne_bytes([a, b, c, d])
    };
    match sample_type {
        SampleType::F16 => {
            let halves: &[f16] = words[..into.len()].reinterpret_cast();
            halves.convert_to_f32_slice(into);
        }
        SampleType::F32 => {
            for (to, words) in into.iter_mut().zip(words.as_chunks().0) {
                *to = f32::from_bits(bits(words));
            }
        }
        SampleType::U32 => {
            for (to, words) in into.iter_mut().zip(words.as_chunks().0) {
                *to = bits(words) as f32;
            }
        }
    }
}

/// Rows are split off rows that hold them.
const HELD: &str = "the rows are held";

/// Rows of a picture that are to be filled.
pub(super) enum PictureRows<'t> {
    /// The samples of some channels.
    Samples(Vec<PlaneTarget<'t>>),
    /// All channels as stored, laid out as in a block as wide as the picture.
    Bytes(&'t mut [u8]),
}

impl<'t> PictureRows<'t> {
    /// Splits off the first `rows` rows.
    pub(super) fn split_off_top(&mut self, rows: usize, layout: &BandLayout) -> PictureRows<'t> {
        let pixels = rows * layout.width;
        match self {
            PictureRows::Samples(planes) => {
                let top = planes.iter_mut().map(|target| PlaneTarget {
                    samples: target.samples.split_off_mut(..pixels).expect(HELD),
                    ..*target
                });
                PictureRows::Samples(top.collect())
            }
            PictureRows::Bytes(bytes) => {
                let top = bytes.split_off_mut(..pixels * layout.pixel_bytes);
                PictureRows::Bytes(top.expect(HELD))
            }
        }
    }

    /// Copies the part of `block`, whose pixels are those of `area`, in the rows `rows`: those held here.
    pub(super) fn fill(
        &mut self,
        block: &[u16],
        area: &Area,
        rows: &Range<usize>,
        layout: &BandLayout,
    ) {
        let (x, width) = (area.columns.start, area.columns.len());
        let row_words = layout.pixel_bytes / 2 * width;
        let shared = area.rows.start.max(rows.start)..area.rows.end.min(rows.end);
        for y in shared {
            let words = &block[(y - area.rows.start) * row_words..][..row_words];
            let y = y - rows.start;
            match self {
                PictureRows::Samples(planes) => {
                    for target in planes {
                        let row = &mut target.samples[y * layout.width + x..][..width];
                        let words = &words[target.before / 2 * width..];
                        convert(target.sample_type, words, row);
                    }
                }
                PictureRows::Bytes(bytes) => {
                    let into = &mut bytes[y * layout.width * layout.pixel_bytes..];
                    copy_row(words, into, layout, &area.columns);
                }
            }
        }
    }
}

/// Copies the samples of a row of a block, which has the `columns`, into a row of a picture `width`
/// wide; `sample_bytes` are those of each channel.
fn copy_row(words: &[u16], into: &mut [u8], layout: &BandLayout, columns: &Range<usize>) {
    let row: Vec<u8> = words.iter().flat_map(|w| w.to_ne_bytes()).collect();
    let mut before = 0;
    for bytes in &layout.sample_bytes {
        let from = &row[before * columns.len()..][..bytes * columns.len()];
        into[before * layout.width + bytes * columns.start..][..from.len()].copy_from_slice(from);
        before += bytes;
    }
}

pub(super) fn is_dwa(compression: Compression) -> bool {
    matches!(compression, Compression::DWAA(_) | Compression::DWAB(_))
}

/// Copies of a block while it is decoded: compressed, decompressed, and one in between.
pub(super) const COPIES: usize = 3;

/// The words of bytes in the order of memory.
fn words(bytes: &[u8]) -> BlockWords {
    let (pairs, _) = bytes.as_chunks();
    pairs.iter().map(|&pair| u16::from_ne_bytes(pair)).collect()
}

/// Decompresses a block of `part`, which has the pixels of `area`.
pub(super) fn decode_block(
    bytes: Vec<u8>,
    header: &Header,
    part: usize,
    area: &Area,
) -> Parsed<BlockWords> {
    let (columns, rows) = (area.columns.len(), area.rows.len());
    let size = columns * rows * header.channels.bytes_per_pixel;
    // Blocks that compression would not shrink are stored uncompressed.
    if OWN_CODEC && bytes.len() == size {
        return Ok(words(&bytes));
    }
    let decoded = match header.compression {
        Compression::ZIP1 | Compression::ZIP16 if OWN_CODEC => fenced(|| inflate(&bytes, size)),
        compression => {
            let section = IntegerBounds {
                position: Vec2(area.columns.start as i32, area.rows.start as i32),
                size: Vec2(columns, rows),
            };
            if is_dwa(compression) {
                check_dwa_counters(&bytes, section.size, header)?;
            }
            fenced(|| compression.decompress_image_section_from_le(header, bytes, section, false))
                .map(|bytes| Ok(words(&bytes?)))
        }
    };
    decoded.unwrap_or_else(|| Err(contradiction(part, header)))
}

fn contradiction(part: usize, header: &Header) -> Fault {
    Fault::damaged(format!(
        "a block of pixels in part {} contradicts itself",
        part_name(part, header)
    ))
}

fn part_name(index: usize, header: &Header) -> String {
    match &header.own_attributes.layer_name {
        Some(name) => format!("{:?}", text_of_bytes(name.as_slice())),
        None => index.to_string(),
    }
}

/// Refuses DWA chunks whose counters exceed the content of a block of `size` pixels: the decoder allocates memory by
/// them.
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
