//! Adding a part to a copy of a file, leaving the existing parts as they are.

use super::ExrFile;
use super::attributes::Attributes;
use super::chunks::{ChunkReader, RawChunk};
use super::fault::{Fault, Parsed};
use super::header::{MULTI_PART, TILED};
use super::sink::ChunkSink;
use super::write::{PartDescription, ReadyPart};
use crate::error::{Error, Result};
use std::io::{Seek, Write};
use std::path::Path;

/// Name of the only part of a file that gave it none.
const FIRST_NAME: &str = "main";

/// Starts a copy of `input` with `part` added: its header is written, and no pixels yet.
pub(super) fn start_append<'w, W: Write + Seek>(
    input: &ExrFile,
    w: &'w mut W,
    target: &Path,
    part: &PartDescription,
) -> Result<(ChunkSink<'w, W>, ReadyPart)> {
    let mut parts = named_parts(input);
    let part = PartDescription {
        name: free_name(&part.name, &parts),
        ..part.clone()
    };
    let ready = ReadyPart::new(&part, target, parts.first())?;
    parts.push(ready.attributes.clone());
    let mut counts = input.header.chunk_counts();
    counts.push(ready.header.chunk_count);
    let flags = input.header.flags & !TILED | MULTI_PART;
    let out = ChunkSink::start(w, target, flags, (&parts, &ready), &counts)?;
    Ok((out, ready))
}

/// The input's attributes, plus those that only a multi-part file must have.
fn named_parts(input: &ExrFile) -> Vec<Attributes> {
    let mut parts = input.header.parts.clone();
    for (i, header) in input.header.meta.headers.iter().enumerate() {
        if parts[i].text("name").is_none_or(|name| name.is_empty()) {
            let name = match input.header.is_multi_part() {
                true => free_name(&format!("part{i}"), &parts),
                false => FIRST_NAME.to_owned(),
            };
            parts[i].set_text("name", &name);
        }
        parts[i].set_int("chunkCount", header.chunk_count as i32);
    }
    parts
}

/// `name`, with a number added if one of `parts` has it.
fn free_name(name: &str, parts: &[Attributes]) -> String {
    let taken: Vec<_> = parts.iter().filter_map(|part| part.text("name")).collect();
    let numbered = (2..).map(|n| format!("{name}.{n}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    names.find(|name| !taken.contains(name)).unwrap_or_default()
}

/// Copies all chunks of `input` but those of part `without`, in file order.
pub(super) fn copy_chunks(
    input: &ExrFile,
    without: Option<usize>,
    out: &mut ChunkSink<impl Write + Seek>,
    target: &Path,
) -> Result<()> {
    let damaged = |fault: Fault| fault.at(&input.path);
    let mut chunks = ChunkReader::open(input).map_err(damaged)?;
    let all = all_chunks(input, &mut chunks, without).map_err(damaged)?;
    let mut end = 0;
    for (offset, part, index) in all {
        let chunk = next_chunk(&mut chunks, offset, end, part).map_err(damaged)?;
        end = chunks.position;
        let written = out.chunk(part, index, &chunk.place, &chunk.bytes);
        written.map_err(Error::io(target, "write"))?;
    }
    Ok(())
}

/// Offset, part and index within the part of every chunk, by offset; none of part `without`.
fn all_chunks(
    input: &ExrFile,
    chunks: &mut ChunkReader,
    without: Option<usize>,
) -> Parsed<Vec<(u64, usize, usize)>> {
    let mut all = Vec::new();
    for (part, header) in input.header.meta.headers.iter().enumerate() {
        if Some(part) == without {
            continue;
        }
        let offsets = chunks.offsets(part, header.chunk_count)?;
        all.extend(offsets.iter().enumerate().map(|(i, &o)| (o, part, i)));
    }
    all.sort_unstable();
    Ok(all)
}

/// The chunk at `offset`, which must not reach back before `end`: a small file whose chunks overlap
/// could be made into a huge copy.
fn next_chunk(chunks: &mut ChunkReader, offset: u64, end: u64, part: usize) -> Parsed<RawChunk> {
    let chunk = chunks.chunk(offset, i32::MAX as u64)?;
    match offset >= end && chunk.part as usize == part {
        true => Ok(chunk),
        false => Err(Fault::damaged("its blocks of pixels overlap")),
    }
}
