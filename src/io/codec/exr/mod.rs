//! OpenEXR: channels to planes, planes to parts.
//!
//! Opening reads the header alone and refuses what cannot be read. Reading takes only the channels
//! asked for, whole or by rows, and skips whole parts and resolution levels. Writing
//! makes a file of one part, adds a part to a copy of the input in which every other byte of pixels
//! stays as it was, or adds channels to a part of a copy. All three go by strips of rows.
//!
//! ZIP is decoded and encoded here, other compressions by the `exr` crate; everything that decides memory use and the
//! place of chunks is done here, because that crate trusts the file's claims.

mod append;
mod attributes;
mod chunks;
mod compression;
mod decode;
mod encode;
mod fault;
mod header;
mod layout;
#[cfg(feature = "cli")]
mod memory;
mod merge;
mod part;
mod read;
mod sink;
mod write;
mod writer;
mod zip;

pub use compression::OutputCompression;
#[cfg(feature = "cli")]
pub(crate) use memory::encoding_bytes;
pub use merge::Merged;
pub use part::{Channel, ChannelId, Part, SampleType};
#[cfg(feature = "cli")]
pub(crate) use write::X_DENSITY;
pub use write::{OutputChannel, OutputPart, OutputType, PartDescription, PartWith};
pub use writer::{PartWriter, write_results};

use crate::error::{Error, Result};
use crate::frame::Window;
use crate::io::open::open_input;
use header::FileHeader;
pub(in crate::io) use header::MAGIC;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// How much may be read of a file at one time before it is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Most pixels of a part, in the rows that are read.
    pub max_pixels: u64,
    /// Most bytes of decoded planes and the blocks being decoded, at one time.
    pub max_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            max_pixels: 1 << 28,
            max_bytes: 2 << 30,
        }
    }
}

/// An OpenEXR file whose header has been read.
#[derive(Debug)]
pub struct ExrFile {
    /// Where the file is.
    pub path: PathBuf,
    /// Its parts, in order.
    pub parts: Vec<Part>,
    /// The pixels meant to be shown.
    pub display_window: Window,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The attributes of the first part as text, long ones cut. Numbers stand in the order of the
    /// file, with blanks between them.
    pub attributes: BTreeMap<String, String>,
    /// x and y of the red, green and blue primaries and of white, where the file gives them.
    pub chromaticities: Option<[f32; 8]>,
    header: FileHeader,
    file_len: u64,
    limits: Limits,
}

impl ExrFile {
    /// Reads the header of the file at `path`. The limits count where pixels are read.
    pub fn open(path: &Path, limits: &Limits) -> Result<ExrFile> {
        let file = open_input(path).map_err(Error::io(path, "read"))?;
        let metadata = file.metadata().map_err(Error::io(path, "read"))?;
        let header = FileHeader::read(BufReader::new(file), metadata.len())
            .map_err(|fault| fault.at(path))?;
        let first = &header.parts[0];
        let chromaticities = first.floats("chromaticities", "chromaticities");
        Ok(ExrFile {
            path: path.to_path_buf(),
            parts: (0..header.parts.len()).map(|i| header.part(i)).collect(),
            display_window: header::display_window(first)
                .unwrap_or_else(|| header::data_window(&header.meta.headers[0])),
            pixel_aspect: header::pixel_aspect(first),
            attributes: first
                .iter()
                .map(|a| (attributes::text_of_bytes(&a.name), a.text()))
                .collect(),
            chromaticities,
            file_len: metadata.len(),
            limits: *limits,
            header,
        })
    }

    /// The strings among the attributes of all parts whose names begin with `prefix`, whole, by the rest of their names.
    pub(in crate::io) fn strings(&self, prefix: &str) -> Vec<(String, Cow<'_, str>)> {
        let all = self.header.parts.iter().flat_map(|part| part.iter());
        let strings = all.filter(|attribute| attribute.kind == b"string");
        let named = strings.filter_map(|attribute| {
            let name = attributes::text_of_bytes(&attribute.name);
            let rest = name.strip_prefix(prefix)?.to_owned();
            Some((rest, attributes::text_or_latin(&attribute.value)))
        });
        named.collect()
    }

    /// All channels of all parts, in order.
    pub fn channel_ids(&self) -> impl Iterator<Item = ChannelId> {
        let parts = self.parts.iter().enumerate();
        parts.flat_map(|(part, p)| {
            (0..p.channels.len()).map(move |channel| ChannelId { part, channel })
        })
    }
}
