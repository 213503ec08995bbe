//! The file header, checked before anything is allocated for it.

use super::attributes::{Attributes, HeaderReader, text_of_bytes};
use super::compression::NAMES;
use super::fault::{Fault, Parsed};
use super::part::{Channel, Part, SampleType};
use crate::frame::Window;
use crate::io::fence::fenced;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use std::io::Read;

/// The first bytes of every EXR file.
pub(in crate::io) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
pub(super) const VERSION: u32 = 2;
pub(super) const TILED: u32 = 1 << 9;
pub(super) const LONG_NAMES: u32 = 1 << 10;
const DEEP: u32 = 1 << 11;
pub(super) const MULTI_PART: u32 = 1 << 12;
/// Corners beyond this are refused by OpenEXR too; below it no sum of two overflows.
const MAX_CORNER: i64 = (i32::MAX / 2) as i64;
/// Most channels of a file; renderers write hundreds.
const MAX_CHANNELS: usize = 1 << 15;
/// Most bytes of the names of parts and views; those of a thousand parts have fewer.
const MAX_LABELS: usize = 256 << 10;
/// Bytes of a chunk without pixels: its place and size, and its entry in the offset table.
const MIN_CHUNK_BYTES: u64 = 16;

/// The header of a file, byte for byte and as understood.
#[derive(Debug)]
pub(super) struct FileHeader {
    /// Version and flags.
    pub(super) flags: u32,
    /// The attributes of each part.
    pub(super) parts: Vec<Attributes>,
    /// The same, typed.
    pub(super) meta: MetaData,
    /// Start of the offset tables.
    pub(super) end: u64,
}

impl FileHeader {
    pub(super) fn read(read: impl Read, file_len: u64) -> Parsed<FileHeader> {
        let mut read = HeaderReader::new(read, file_len);
        let (flags, mut parts) = raw_header(&mut read)?;
        for part in &mut parts {
            check_part(part, flags)?;
        }
        check_labels(&parts)?;
        let meta = typed(flags, &parts)?;
        check_channels(&meta)?;
        check_chunk_count(&meta, file_len.saturating_sub(read.position))?;
        match fenced(|| MetaData::validate(&meta.headers, false)) {
            Some(valid) => _ = valid?,
            None => return Err(Fault::damaged("its header contradicts itself")),
        }
        Ok(FileHeader {
            flags,
            parts,
            meta,
            end: read.position,
        })
    }

    pub(super) fn is_multi_part(&self) -> bool {
        self.flags & MULTI_PART != 0
    }

    /// Number of chunks of each part.
    pub(super) fn chunk_counts(&self) -> Vec<usize> {
        self.meta.headers.iter().map(|h| h.chunk_count).collect()
    }

    pub(super) fn part(&self, index: usize) -> Part {
        let (raw, header) = (&self.parts[index], &self.meta.headers[index]);
        Part {
            name: raw.text("name"),
            view: raw.text("view"),
            window: data_window(header),
            compression: NAMES[usize::from(compression(raw).unwrap_or_default())].to_owned(),
            tiled: header.blocks.has_tiles(),
            channels: header.channels.list.iter().map(channel).collect(),
            color_interop_id: raw.text("colorInteropID"),
        }
    }
}

/// The version field and the attributes of every part.
fn raw_header(read: &mut HeaderReader<impl Read>) -> Parsed<(u32, Vec<Attributes>)> {
    if read.array()? != MAGIC {
        return Err(Fault::damaged("is not an OpenEXR file"));
    }
    let flags = u32::from_le_bytes(read.array()?);
    if flags & 0xff != VERSION || flags & !0xff & !(TILED | LONG_NAMES | DEEP | MULTI_PART) != 0 {
        return Err(Fault::Unsupported {
            found: format!("is of an OpenEXR version that is not supported ({flags:#x})"),
            remedy: "rewrite it: oiiotool in.exr --compression zip -o out.exr",
        });
    }
    let mut parts = vec![read.attributes()?];
    if flags & MULTI_PART != 0 {
        // The list of parts ends with an empty one.
        loop {
            let part = read.attributes()?;
            if part.is_empty() {
                break;
            }
            parts.push(part);
        }
    }
    Ok((flags, parts))
}

/// Refuses unsupported parts, and settles contradictions about the type the way OpenEXR does.
fn check_part(part: &mut Attributes, flags: u32) -> Parsed<()> {
    if flags & (MULTI_PART | DEEP) == 0 {
        // Only the version field counts in these files, and it is not "deep".
        let tiled = flags & TILED != 0;
        part.set_text("type", if tiled { "tiledimage" } else { "scanlineimage" });
    }
    if flags & DEEP != 0 && flags & MULTI_PART == 0
        || part.text("type").is_some_and(|t| t.starts_with("deep"))
    {
        return Err(Fault::Unsupported {
            found: "holds deep pixels, which are not supported".into(),
            remedy: "flatten it: oiiotool in.exr --flatten -o out.exr",
        });
    }
    check_compression(part)?;
    check_window(part, "displayWindow")?;
    check_window(part, "dataWindow")?;
    check_pixel_aspect(part)
}

fn check_compression(part: &Attributes) -> Parsed<()> {
    let name = match compression(part) {
        Some(0..=9) => return Ok(()),
        Some(10 | 11) => "HTJ2K".to_owned(),
        Some(12) => "ZSTD".to_owned(),
        Some(other) => format!("unknown (number {other})"),
        None => return Err(Fault::damaged("does not say how it is compressed")),
    };
    Err(Fault::Unsupported {
        found: format!("its compression, {name}, is not supported"),
        remedy: "rewrite it: oiiotool in.exr --compression zip -o out.exr",
    })
}

/// The number of the compression of a part.
fn compression(part: &Attributes) -> Option<u8> {
    part.byte("compression", "compression")
}

fn check_window(part: &Attributes, name: &str) -> Parsed<()> {
    let Some(corners) = part.corners(name) else {
        return Err(Fault::damaged(format!("has no valid {name}")));
    };
    let [x0, y0, x1, y1] = corners.map(i64::from);
    let in_range = corners.iter().all(|&c| i64::from(c).abs() < MAX_CORNER);
    if !in_range || x1 < x0 || y1 < y0 {
        let found = format!("its {name} ({x0}, {y0}) to ({x1}, {y1}) is not a window");
        return Err(Fault::Damaged(found));
    }
    Ok(())
}

fn check_pixel_aspect(part: &Attributes) -> Parsed<()> {
    let aspect = pixel_aspect(part);
    match crate::frame::PIXEL_ASPECTS.contains(&aspect) {
        true => Ok(()),
        false => Err(Fault::Unsupported {
            found: format!("its pixels are {aspect:e} times as wide as high"),
            remedy: "set its pixelAspectRatio to 0.001 to 1000",
        }),
    }
}

/// Width of a pixel over its height.
pub(super) fn pixel_aspect(part: &Attributes) -> f32 {
    part.floats("pixelAspectRatio", "float")
        .map_or(1.0, |[aspect]| aspect)
}

/// The display window of a part that has been checked.
pub(super) fn display_window(part: &Attributes) -> Option<Window> {
    let [x0, y0, x1, y1] = part.corners("displayWindow")?;
    let (x1, y1) = (x1 + 1, y1 + 1);
    Some(Window { x0, y0, x1, y1 })
}

/// The header of a whole file: magic number, version field, all parts.
pub(super) fn header_bytes(flags: u32, parts: &[Attributes]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&flags.to_le_bytes());
    for part in parts {
        part.write_to(&mut bytes);
    }
    if flags & MULTI_PART != 0 {
        bytes.push(0);
    }
    bytes
}

/// The header as the `exr` crate understands it.
pub(super) fn typed(flags: u32, parts: &[Attributes]) -> Parsed<MetaData> {
    // The rest may be large, and tells it nothing that it is asked for.
    let parts: Vec<Attributes> = parts.iter().map(Attributes::of_pixels).collect();
    // Without the long-name flag names are still read: only the writer has to obey it.
    let bytes = header_bytes(flags | LONG_NAMES, &parts);
    let meta = fenced(|| MetaData::read_from_buffered(bytes.as_slice(), false)).transpose()?;
    let meta = meta.filter(|meta| meta.headers.len() == parts.len());
    meta.ok_or_else(|| Fault::damaged("its header contradicts itself"))
}

fn check_labels(parts: &[Attributes]) -> Parsed<()> {
    let labels = parts
        .iter()
        .flat_map(|part| [part.get("name"), part.get("view")]);
    let bytes: usize = labels.flatten().map(|label| label.value.len()).sum();
    match bytes <= MAX_LABELS {
        true => Ok(()),
        false => Err(Fault::Unsupported {
            found: format!("has {bytes} bytes of names of parts and views, more than {MAX_LABELS}"),
            remedy: "shorten them",
        }),
    }
}

fn check_channels(meta: &MetaData) -> Parsed<()> {
    let channels: usize = meta.headers.iter().map(|h| h.channels.list.len()).sum();
    if channels > MAX_CHANNELS {
        return Err(Fault::Unsupported {
            found: format!("has {channels} channels, more than the {MAX_CHANNELS} that are read"),
            remedy: "split it into files with fewer layers",
        });
    }
    for channel in meta.headers.iter().flat_map(|h| &h.channels.list) {
        if channel.sampling != ::exr::math::Vec2(1, 1) {
            let name = text_of_bytes(channel.name.as_slice());
            return Err(Fault::Unsupported {
                found: format!("channel {name:?} is subsampled, which is not supported"),
                remedy: "save the picture as RGB, with every channel at full resolution",
            });
        }
    }
    Ok(())
}

/// Compares the number of chunks with the bytes behind the header.
fn check_chunk_count(meta: &MetaData, bytes: u64) -> Parsed<()> {
    let chunks = meta
        .headers
        .iter()
        .try_fold(0u64, |sum, h| sum.checked_add(h.chunk_count as u64));
    match chunks.and_then(|c| c.checked_mul(MIN_CHUNK_BYTES)) {
        Some(needed) if needed <= bytes => Ok(()),
        _ => Err(Fault::damaged(format!(
            "its size calls for {} blocks of pixels, but only {bytes} bytes follow the header",
            chunks.map_or("countless".into(), |c| c.to_string())
        ))),
    }
}

/// The data window of a part that has been checked.
pub(super) fn data_window(header: &Header) -> Window {
    let ::exr::math::Vec2(x, y) = header.own_attributes.layer_position;
    Window::at(x, y, header.layer_size.width(), header.layer_size.height())
}

fn channel(channel: &::exr::meta::attribute::ChannelDescription) -> Channel {
    use ::exr::meta::attribute::SampleType as Exr;
    Channel {
        name: text_of_bytes(channel.name.as_slice()),
        sample_type: match channel.sample_type {
            Exr::F16 => SampleType::Half,
            Exr::F32 => SampleType::Float,
            Exr::U32 => SampleType::Uint,
        },
    }
}
