//! Adding channels to a part of a copy of a file.

use super::chunks::ChunkReader;
use super::decode::PictureRows;
use super::fault::{Fault, Parsed};
use super::header::TILED;
use super::layout::BandLayout;
use super::read::PartBlocks;
use super::sink::ChunkSink;
use super::write::{
    PartDescription, ReadyPart, SampleSource, channel_entry, set_added, sorted_channels,
};
use super::{ExrFile, OutputCompression};
use crate::error::{Error, Result};
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::LevelMode;
use std::collections::BTreeSet;
use std::io::{Seek, Write};
use std::ops::Range;
use std::path::Path;

/// The result of adding channels to a part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Merged {
    /// The names the channels have in the part, in the order in which they were given.
    pub channels: Vec<String>,
    /// What is not as it was in the part, a sentence each.
    pub warnings: Vec<String>,
}

/// Starts a copy of `input` in which the part at index `part` also has the channels of `added`: its header is written,
/// and no pixels yet.
pub(super) fn start_merge<'w, W: Write + Seek>(
    input: &ExrFile,
    part: usize,
    w: &'w mut W,
    target: &Path,
    added: &PartDescription,
) -> Result<(ChunkSink<'w, W>, ReadyPart, Merged)> {
    let window = input.parts[part].window;
    if window != added.data_window {
        return Err(Error::SizeMismatch {
            path: input.path.clone(),
            found: format!("{window} in the part that is added to"),
            expected: format!("the results are {}", added.data_window),
        });
    }
    let own = input.parts[part].channels.iter().map(|c| c.name.as_str());
    let channels = free_channels(added, &own.collect());
    let names = channels.iter().map(|(name, _)| name.clone()).collect();
    let (ready, warnings) = ready(input, part, &added.with(channels), target)?;

    let mut parts = input.header.parts.clone();
    parts[part] = ready.attributes.clone();
    let mut counts = input.header.chunk_counts();
    counts[part] = ready.header.chunk_count;
    let flags = input.header.flags & !TILED;
    let out = ChunkSink::start(w, target, flags, (&parts, &ready), &counts)?;
    let merged = Merged {
        channels: names,
        warnings,
    };
    Ok((out, ready, merged))
}

/// The header of the part with the channels `added`, and what is lost of the part.
fn ready(
    input: &ExrFile,
    part: usize,
    added: &PartDescription,
    target: &Path,
) -> Result<(ReadyPart, Vec<String>)> {
    let header = &input.header.meta.headers[part];
    let mut attributes = input.header.parts[part].clone();
    let mut warnings = Vec::new();
    if header.compression.may_loose_data() {
        let zip = vec![OutputCompression::Zip.code()];
        attributes.set("compression", "compression", zip);
        attributes.remove("dwaCompressionLevel");
        warnings.push(format!(
            "its {} pixels would lose precision once more; the part is ZIP-compressed now, and larger",
            input.parts[part].compression
        ));
    }
    if let BlockDescription::Tiles(tiles) = header.blocks
        && tiles.level_mode != LevelMode::Singular
    {
        warnings.push("its smaller resolutions are left out".into());
    }
    attributes.remove("tiles");
    attributes.set_text("type", "scanlineimage");
    attributes.set("lineOrder", "lineOrder", vec![0]);
    set_added(&mut attributes, added)?;
    let (list, sources) = merged_channels(input, part, added)?;
    attributes.set("channels", "chlist", list);
    attributes.remove("chunkCount");
    Ok((ReadyPart::of(attributes, sources, target)?, warnings))
}

/// The channel list of the part with those `added`, and where each comes from.
fn merged_channels(
    input: &ExrFile,
    part: usize,
    added: &PartDescription,
) -> Result<(Vec<u8>, Vec<SampleSource>)> {
    let list = &input.header.meta.headers[part].channels.list;
    let raw = input.header.parts[part].get("channels");
    let entries = raw.map_or(Vec::new(), |a| raw_entries(&a.value));
    if entries.len() != list.len() {
        return Err(Fault::damaged("its list of channels contradicts itself").at(&input.path));
    }
    let mut channels = Vec::new();
    let mut before = 0;
    for (entry, channel) in entries.into_iter().zip(list) {
        channels.push((entry.to_vec(), SampleSource::Carried { before }));
        before += channel.sample_type.bytes_per_sample();
    }
    for i in sorted_channels(added)? {
        let (name, sample_type) = &added.channels[i];
        let entry = channel_entry(name, *sample_type);
        channels.push((entry, SampleSource::Given(i, *sample_type)));
    }
    // An entry starts with the name and a zero byte, so the shorter of two names comes first.
    channels.sort_by(|(a, _), (b, _)| a.cmp(b));
    let mut bytes: Vec<u8> = channels.iter().flat_map(|(e, _)| e).copied().collect();
    bytes.push(0);
    Ok((bytes, channels.into_iter().map(|(_, s)| s).collect()))
}

/// The entries of a channel list: each a name, a zero byte and 16 more.
fn raw_entries(mut list: &[u8]) -> Vec<&[u8]> {
    let mut entries = Vec::new();
    while let Some(name) = list.iter().position(|&b| b == 0).filter(|&n| n > 0) {
        let Some((entry, rest)) = list.split_at_checked(name + 17) else {
            break;
        };
        entries.push(entry);
        list = rest;
    }
    entries
}

/// The channels of `added` under names that are not in `own`. A layer keeps its channels together:
/// bare ones become a layer with the name of the part, others get a number.
fn free_channels(
    added: &PartDescription,
    own: &BTreeSet<&str>,
) -> Vec<(String, super::OutputType)> {
    let split = |name: &str| match name.rsplit_once('.') {
        Some((layer, component)) => (layer.to_owned(), component.to_owned()),
        None => (String::new(), name.to_owned()),
    };
    let joined = |layer: &str, component: &str| match layer {
        "" => component.to_owned(),
        _ => format!("{layer}.{component}"),
    };
    let mut taken: BTreeSet<String> = own.iter().map(|&name| name.to_owned()).collect();
    let mut channels = added.channels.clone();
    let layers: BTreeSet<String> = channels.iter().map(|(name, _)| split(name).0).collect();
    for layer in layers {
        let of_layer = |(name, _): &&mut (String, super::OutputType)| split(name).0 == layer;
        let mut of_layer: Vec<_> = channels.iter_mut().filter(of_layer).collect();
        let components: Vec<String> = of_layer.iter().map(|(name, _)| split(name).1).collect();
        let named = Some(&layer).filter(|layer| !layer.is_empty());
        let base = named.unwrap_or(&added.name);
        let others = (2..).map(|n| format!("{base}.{n}"));
        let is_taken = |layer: &str, c: &String| taken.contains(&joined(layer, c));
        let is_free = |layer: &String| !components.iter().any(|c| is_taken(layer, c));
        let mut names = [layer.clone(), base.clone()].into_iter().chain(others);
        let free = names.find(is_free).unwrap_or_default();
        for ((name, _), component) in of_layer.iter_mut().zip(&components) {
            *name = joined(&free, component);
            taken.insert(name.clone());
        }
    }
    channels
}

/// The rows of a part as they are stored, all channels, for a part that takes them over.
pub(super) struct InputRows<'f> {
    chunks: ChunkReader<'f>,
    blocks: PartBlocks,
    /// The rows that are decoded, those of whole bands.
    decoded: Range<usize>,
    bytes: Vec<u8>,
}

impl<'f> InputRows<'f> {
    /// Opens a part of which no more than `rows` rows will be wanted at one time.
    pub(super) fn open(exr: &'f ExrFile, part: usize, rows: usize) -> Parsed<Self> {
        let layout = BandLayout::of(&exr.header.meta.headers[part]);
        let stride = layout.width * layout.pixel_bytes;
        // Those rows, the rest of their first and last band, and the batches of the reader.
        exr.check_memory(rows as u128 * stride as u128 + 5 * layout.band_bytes())?;
        let mut chunks = ChunkReader::open(exr)?;
        let blocks = PartBlocks::open(&mut chunks, part)?;
        Ok(InputRows {
            chunks,
            blocks,
            decoded: 0..0,
            bytes: Vec::new(),
        })
    }

    /// The rows `rows`, each as in a block over the full width. They follow those that were wanted before.
    pub(super) fn rows(&mut self, rows: &Range<usize>) -> Result<&[u8]> {
        let layout = &self.blocks.layout;
        let stride = layout.width * layout.pixel_bytes;
        let goal = layout.rows_of(&layout.bands_of(rows));
        // The last band may be wanted again.
        let first = self.decoded.end.clamp(goal.start, goal.end);
        let passed = self.bytes.len() - (first - goal.start) * stride;
        self.bytes.drain(..passed);
        self.bytes.resize(goal.len() * stride, 0);
        let missing = PictureRows::Bytes(&mut self.bytes[(first - goal.start) * stride..]);
        let read = self.blocks.read(&mut self.chunks, first..goal.end, missing);
        read.map_err(|fault| fault.at(&self.chunks.exr.path))?;
        self.decoded = goal;
        Ok(&self.bytes[(rows.start - self.decoded.start) * stride..][..rows.len() * stride])
    }
}
