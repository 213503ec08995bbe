//! Writing of chunks and their offset tables.

use super::attributes::{Attributes, MAX_SHORT_NAME};
use super::header::{LONG_NAMES, MULTI_PART, header_bytes};
use super::write::ReadyPart;
use crate::error::{Error, Result};
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

/// A file whose chunks are being written: keeps the offset tables and writes them last.
pub(super) struct ChunkSink<'w, W> {
    w: &'w mut W,
    /// Start of the file in `w`.
    start: u64,
    /// Start of the offset tables.
    tables_at: u64,
    /// Position of the next chunk.
    position: u64,
    tables: Vec<Vec<u64>>,
    multi_part: bool,
}

impl<'w, W: Write + Seek> ChunkSink<'w, W> {
    /// Writes the header of `parts`, of which `ready` is one, and reserves tables of so many chunks for each. `target` is
    /// only named in errors.
    pub(super) fn start(
        w: &'w mut W,
        target: &Path,
        flags: u32,
        (parts, ready): (&[Attributes], &ReadyPart),
        counts: &[usize],
    ) -> Result<Self> {
        let mut channels = ready.header.channels.list.iter();
        let are_long = parts.iter().any(Attributes::has_long_names)
            || channels.any(|channel| channel.name.as_slice().len() > MAX_SHORT_NAME);
        let flags = if are_long { flags | LONG_NAMES } else { flags };
        let header = header_bytes(flags, parts);
        let tables: Vec<Vec<u64>> = counts.iter().map(|&n| vec![0; n]).collect();
        let tables_at = header.len() as u64;
        let mut begin = || {
            let start = w.stream_position()?;
            w.write_all(&header)?;
            tables.iter().try_for_each(|table| write_table(w, table))?;
            Ok(start)
        };
        let start = begin().map_err(Error::io(target, "write"))?;
        Ok(ChunkSink {
            w,
            start,
            tables_at,
            position: tables_at + 8 * counts.iter().sum::<usize>() as u64,
            tables,
            multi_part: flags & MULTI_PART != 0,
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
