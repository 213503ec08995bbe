//! Writing parts.

use super::attributes::{Attributes, MAX_NAME, MAX_SHORT_NAME};
use super::fault::Fault;
use super::header::{LONG_NAMES, MULTI_PART, header_bytes, typed};
use crate::error::{Error, Result};
use crate::frame::{Plane, Window};
use ::exr::compression::Compression;
use ::exr::math::Vec2;
use ::exr::meta::attribute::IntegerBounds;
use ::exr::meta::header::Header;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

const VERSION: u32 = 2;
const ZIP: u8 = 3;
/// Rows in a block of ZIP-compressed pixels.
const BLOCK_ROWS: usize = 16;
/// Uncompressed bytes that are worked on at one time, unless a single block has more.
const BATCH_BYTES: usize = 32 << 20;
/// Attributes that describe the part and are not free to be given.
const RESERVED: [&str; 20] = [
    "channels",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "name",
    "type",
    "chunkCount",
    "tiles",
    "version",
    "maxSamplesPerPixel",
    "chromaticities",
    "timeCode",
    "preview",
    "envmap",
    "multiView",
    "dwaCompressionLevel",
];

/// A part to be written.
#[derive(Debug, Clone)]
pub struct OutputPart<'a> {
    /// Its name. Where it is taken already a number is added.
    pub name: String,
    /// The pixels that the planes hold.
    pub data_window: Window,
    /// The pixels meant to be shown.
    pub display_window: Window,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// What is stored, in any order.
    pub channels: Vec<OutputChannel<'a>>,
    /// More text attributes by name, such as "software".
    pub attributes: Vec<(String, String)>,
    /// x and y of the red, green and blue primaries and of white; `None` means Rec. 709.
    pub chromaticities: Option<[f32; 8]>,
}

/// A channel to be written.
#[derive(Debug, Clone)]
pub struct OutputChannel<'a> {
    /// Its full name, such as "relief.R".
    pub name: String,
    /// Its samples, of the size of the data window.
    pub plane: &'a Plane,
    /// How they are stored.
    pub sample_type: OutputType,
}

/// How samples are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum OutputType {
    /// 16-bit floating point, rounded to nearest; what is too large becomes 65504 with its sign.
    /// Infinities and NaN stay what they are.
    Half,
    /// 32-bit floating point.
    Float,
}

/// Writes `part` alone as a file, ZIP-compressed. `target` is only named in errors.
///
/// # Panics
/// If a plane does not have the size of the data window.
pub fn write_results(w: &mut (impl Write + Seek), target: &Path, part: &OutputPart) -> Result<()> {
    let failed = |source| Error::io(target, "write")(source);
    let ready = ReadyPart::new(part, target, None)?;
    let start = w.stream_position().map_err(failed)?;
    let head = header_bytes(
        VERSION | ready.long_names(),
        std::slice::from_ref(&ready.attributes),
    );
    let mut out = ChunkSink::new(w, start, &head, vec![ready.chunk_count()]).map_err(failed)?;
    ready.write_chunks(&mut out, 0, target)?;
    out.finish().map_err(failed)
}

/// A part whose header has been made.
pub(super) struct ReadyPart<'a> {
    pub(super) attributes: Attributes,
    /// Sorted by name, as the file needs them.
    channels: Vec<&'a OutputChannel<'a>>,
    window: Window,
    header: Header,
}

impl<'a> ReadyPart<'a> {
    /// Makes the header of `part`; `shared` is the first part of the file it is added to.
    pub(super) fn new(
        part: &'a OutputPart,
        target: &Path,
        shared: Option<&Attributes>,
    ) -> Result<Self> {
        let channels = sorted_channels(part)?;
        let mut attributes = attributes_of(part, &channels)?;
        if let Some(shared) = shared {
            share(&mut attributes, shared);
        }
        attributes.sort();
        let meta = typed(VERSION, std::slice::from_ref(&attributes)).map_err(|f| f.at(target))?;
        let header = meta.headers.into_iter().next();
        Ok(ReadyPart {
            header: header.ok_or_else(|| Fault::damaged("has no part").at(target))?,
            attributes,
            channels,
            window: part.data_window,
        })
    }

    /// The flag that a file with this part needs if it holds long names.
    pub(super) fn long_names(&self) -> u32 {
        let long = |c: &&OutputChannel| c.name.len() > MAX_SHORT_NAME;
        match self.attributes.has_long_names() || self.channels.iter().any(long) {
            true => LONG_NAMES,
            false => 0,
        }
    }

    pub(super) fn chunk_count(&self) -> usize {
        self.window.height().div_ceil(BLOCK_ROWS)
    }

    /// Compresses and writes all pixels.
    pub(super) fn write_chunks(
        &self,
        out: &mut ChunkSink<impl Write + Seek>,
        index: usize,
        target: &Path,
    ) -> Result<()> {
        let block_bytes = BLOCK_ROWS * self.window.width() * self.header.channels.bytes_per_pixel;
        let batch = (BATCH_BYTES / block_bytes).clamp(1, 1024);
        let blocks: Vec<usize> = (0..self.chunk_count()).collect();
        for blocks in blocks.chunks(batch) {
            let compressed: Vec<_> = blocks.par_iter().map(|&b| self.compressed(b)).collect();
            for (&block, bytes) in blocks.iter().zip(compressed) {
                let bytes = bytes.map_err(|error| Fault::from(error).at(target))?;
                let y = self.window.y0 + (block * BLOCK_ROWS) as i32;
                out.chunk(index, block, &[y], &bytes)
                    .map_err(Error::io(target, "write"))?;
            }
        }
        Ok(())
    }

    fn compressed(&self, block: usize) -> ::exr::error::Result<Vec<u8>> {
        let first = block * BLOCK_ROWS;
        let rows = first..(first + BLOCK_ROWS).min(self.window.height());
        let section = IntegerBounds {
            position: Vec2(0, first as i32),
            size: Vec2(self.window.width(), rows.len()),
        };
        let mut bytes =
            Vec::with_capacity(section.size.area() * self.header.channels.bytes_per_pixel);
        let mut halves = vec![f16::ZERO; self.window.width()];
        for y in rows {
            for channel in &self.channels {
                push_row(channel, y, &mut halves, &mut bytes);
            }
        }
        Compression::ZIP16.compress_image_section_to_le(&self.header, bytes, section)
    }
}

fn push_row(channel: &OutputChannel, y: usize, halves: &mut [f16], bytes: &mut Vec<u8>) {
    let row = channel.plane.row(y);
    match channel.sample_type {
        OutputType::Float => bytes.extend(row.iter().flat_map(|v| v.to_ne_bytes())),
        OutputType::Half => {
            let clamped: Vec<f32> = row.iter().map(|&v| clamped_to_half(v)).collect();
            halves.convert_from_f32_slice(&clamped);
            bytes.extend(halves.iter().flat_map(|v| v.to_ne_bytes()));
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

fn sorted_channels<'a>(part: &'a OutputPart) -> Result<Vec<&'a OutputChannel<'a>>> {
    let mut channels: Vec<_> = part.channels.iter().collect();
    channels.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
    for channel in &channels {
        check_name("channel name", &channel.name)?;
        let (width, height) = (part.data_window.width(), part.data_window.height());
        assert!(
            (channel.plane.width(), channel.plane.height()) == (width, height),
            "plane {} does not fill the data window",
            channel.name
        );
    }
    match channels
        .windows(2)
        .find(|pair| pair[0].name == pair[1].name)
    {
        Some(pair) => Err(Error::BadParameter {
            name: "channel name",
            found: format!("{:?} is used twice", pair[0].name),
            remedy: "give each channel a name of its own".into(),
        }),
        None => Ok(channels),
    }
}

fn check_name(what: &'static str, name: &str) -> Result<()> {
    match name.is_empty() || name.len() > MAX_NAME || name.contains('\0') {
        true => Err(Error::BadParameter {
            name: what,
            found: format!("is {name:?}"),
            remedy: format!("use 1 to {MAX_NAME} bytes without a zero byte"),
        }),
        false => Ok(()),
    }
}

fn attributes_of(part: &OutputPart, channels: &[&OutputChannel]) -> Result<Attributes> {
    if part.data_window.width() == 0 || part.data_window.height() == 0 || channels.is_empty() {
        return Err(Error::BadParameter {
            name: "output",
            found: format!("has {} channels, {}", channels.len(), part.data_window),
            remedy: "write at least one channel and one pixel".into(),
        });
    }
    let mut attributes = Attributes::default();
    attributes.set("channels", "chlist", channel_list(channels));
    attributes.set("compression", "compression", vec![ZIP]);
    attributes.set_window("dataWindow", part.data_window);
    attributes.set_window("displayWindow", part.display_window);
    attributes.set("lineOrder", "lineOrder", vec![0]);
    attributes.set_text("name", &part.name);
    attributes.set_floats("pixelAspectRatio", "float", &[part.pixel_aspect]);
    attributes.set_floats("screenWindowCenter", "v2f", &[0.0, 0.0]);
    attributes.set_floats("screenWindowWidth", "float", &[1.0]);
    attributes.set_text("type", "scanlineimage");
    let chunks = part.data_window.height().div_ceil(BLOCK_ROWS);
    attributes.set_int("chunkCount", chunks as i32);
    if let Some(chromaticities) = part.chromaticities {
        attributes.set_floats("chromaticities", "chromaticities", &chromaticities);
    }
    for (name, text) in &part.attributes {
        check_attribute_name(name)?;
        attributes.set_text(name, text);
    }
    Ok(attributes)
}

fn check_attribute_name(name: &str) -> Result<()> {
    match RESERVED.contains(&name) {
        true => Err(Error::BadParameter {
            name: "attribute",
            found: format!("{name:?} describes the file itself"),
            remedy: "use another name".into(),
        }),
        false => check_name("attribute", name),
    }
}

fn channel_list(channels: &[&OutputChannel]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for channel in channels {
        let kind: i32 = match channel.sample_type {
            OutputType::Half => 1,
            OutputType::Float => 2,
        };
        bytes.extend_from_slice(channel.name.as_bytes());
        bytes.push(0);
        bytes.extend_from_slice(&kind.to_le_bytes());
        bytes.extend_from_slice(&[0; 4]); // not perceptually linear, three bytes unused
        bytes.extend_from_slice(&1i32.to_le_bytes());
        bytes.extend_from_slice(&1i32.to_le_bytes());
    }
    bytes.push(0);
    bytes
}

/// Takes over what all parts of a file must have in common.
fn share(attributes: &mut Attributes, first: &Attributes) {
    for name in [
        "displayWindow",
        "pixelAspectRatio",
        "chromaticities",
        "timeCode",
    ] {
        match first.get(name) {
            Some(a) => attributes.set(name, &String::from_utf8_lossy(&a.kind), a.value.clone()),
            None => attributes.remove(name),
        }
    }
}

/// Where chunks go: keeps the offset tables and writes them last.
pub(super) struct ChunkSink<'w, W> {
    w: &'w mut W,
    /// Where the file starts in `w`.
    start: u64,
    /// Where the tables start.
    tables_at: u64,
    /// Where the next chunk goes.
    position: u64,
    tables: Vec<Vec<u64>>,
    multi_part: bool,
}

impl<'w, W: Write + Seek> ChunkSink<'w, W> {
    /// Writes the header and leaves room for tables of the given sizes, one for each part.
    pub(super) fn new(
        w: &'w mut W,
        start: u64,
        header: &[u8],
        counts: Vec<usize>,
    ) -> std::io::Result<Self> {
        w.write_all(header)?;
        let tables: Vec<Vec<u64>> = counts.iter().map(|&n| vec![0; n]).collect();
        for table in &tables {
            write_table(w, table)?;
        }
        let tables_at = header.len() as u64;
        Ok(ChunkSink {
            w,
            start,
            tables_at,
            position: tables_at + 8 * counts.iter().sum::<usize>() as u64,
            tables,
            multi_part: u32::from_le_bytes([header[4], header[5], header[6], header[7]])
                & MULTI_PART
                != 0,
        })
    }

    /// Writes a chunk as number `index` of `part`; `place` is its row, or its tile and level.
    pub(super) fn chunk(
        &mut self,
        part: usize,
        index: usize,
        place: &[i32],
        bytes: &[u8],
    ) -> std::io::Result<()> {
        self.tables[part][index] = self.position;
        let part = [part as i32];
        let part = if self.multi_part { &part[..] } else { &[] };
        let size = [bytes.len() as i32];
        for number in part.iter().chain(place).chain(&size) {
            self.w.write_all(&number.to_le_bytes())?;
            self.position += 4;
        }
        self.w.write_all(bytes)?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    /// Writes the tables, and leaves `w` at the end of the file.
    pub(super) fn finish(self) -> std::io::Result<()> {
        self.w.seek(SeekFrom::Start(self.start + self.tables_at))?;
        for table in &self.tables {
            write_table(self.w, table)?;
        }
        self.w.seek(SeekFrom::Start(self.start + self.position))?;
        self.w.flush()
    }
}

fn write_table(w: &mut impl Write, table: &[u64]) -> std::io::Result<()> {
    let bytes: Vec<u8> = table.iter().flat_map(|o| o.to_le_bytes()).collect();
    w.write_all(&bytes)
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
