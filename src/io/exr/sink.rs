//! Writing of chunks and their offset tables.

use super::header::MULTI_PART;
use std::io::{Seek, SeekFrom, Write};

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
    /// Writes the header and reserves tables of the given sizes, one for each part.
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
