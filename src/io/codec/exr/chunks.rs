//! Chunks: the compressed blocks of pixels in a file.

use super::ExrFile;
use super::fault::{Fault, Parsed};
use crate::io::open::open_input;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};

/// A compressed block of pixels.
#[derive(Debug)]
pub(super) struct RawChunk {
    pub(super) part: i32,
    /// What it claims to hold: the first row of a block of rows, or column and row of a tile and of its resolution level.
    pub(super) place: Vec<i32>,
    pub(super) bytes: Vec<u8>,
}

/// Reads chunks of one file.
pub(super) struct ChunkReader<'a> {
    pub(super) exr: &'a ExrFile,
    file: BufReader<File>,
    pub(super) position: u64,
}

impl ExrFile {
    /// Whether all blocks of pixels are there, without decoding them.
    pub fn is_whole(&self) -> bool {
        self.ends_within().unwrap_or(false)
    }

    /// Whether the last block ends within the file; an error if others are missing.
    fn ends_within(&self) -> Parsed<bool> {
        let mut chunks = ChunkReader::open(self)?;
        let mut last = 0;
        for (part, header) in self.header.meta.headers.iter().enumerate() {
            let offsets = chunks.offsets(part, header.chunk_count)?;
            last = offsets.into_iter().fold(last, u64::max);
        }
        // A block that the file ends in is refused.
        Ok(chunks.chunk(last, i32::MAX as u64).is_ok())
    }
}

impl<'a> ChunkReader<'a> {
    pub(super) fn open(exr: &'a ExrFile) -> Parsed<Self> {
        Ok(ChunkReader {
            exr,
            file: BufReader::new(open_input(&exr.path)?),
            position: 0,
        })
    }

    /// Offsets of the first `count` chunks of `part`.
    pub(super) fn offsets(&mut self, part: usize, count: usize) -> Parsed<Vec<u64>> {
        let header = &self.exr.header;
        let counts = header.chunk_counts();
        let stored = counts[part];
        if count > stored {
            return Err(Fault::damaged(format!(
                "its size calls for {count} blocks of pixels, but it has {stored}"
            )));
        }
        let (before, all): (usize, usize) = (counts[..part].iter().sum(), counts.iter().sum());
        self.seek(header.end + 8 * before as u64)?;
        let mut bytes = vec![0; 8 * count];
        self.read_exact(&mut bytes)?;
        let offsets: Vec<u64> = bytes
            .as_chunks()
            .0
            .iter()
            .map(|&b| u64::from_le_bytes(b))
            .collect();

        let pixels = header.end + 8 * all as u64..self.exr.file_len;
        let missing = offsets.iter().filter(|o| !pixels.contains(o)).count();
        match missing {
            0 => Ok(offsets),
            _ => Err(Fault::damaged(format!(
                "is not complete: {missing} of {count} blocks of pixels are missing"
            ))),
        }
    }

    /// The chunk at `offset`, if it has no more than `max_bytes`.
    pub(super) fn chunk(&mut self, offset: u64, max_bytes: u64) -> Parsed<RawChunk> {
        self.seek(offset)?;
        let part = match self.exr.header.is_multi_part() {
            true => self.int()?,
            false => 0,
        };
        let parts = &self.exr.parts;
        let tiled = usize::try_from(part)
            .ok()
            .and_then(|p| parts.get(p))
            .ok_or_else(|| Fault::damaged(format!("a block of pixels claims part {part}")))?
            .tiled;
        let numbers = if tiled { 4 } else { 1 };
        let place = (0..numbers).map(|_| self.int()).collect::<Parsed<_>>()?;
        let bytes = self.sized_bytes(max_bytes)?;
        Ok(RawChunk { part, place, bytes })
    }

    fn sized_bytes(&mut self, max_bytes: u64) -> Parsed<Vec<u8>> {
        let size = self.int()?;
        let left = self.exr.file_len.saturating_sub(self.position);
        let most = max_bytes.min(left);
        let Some(size) = u64::try_from(size).ok().filter(|&s| s <= most) else {
            let found = match size {
                0.. if max_bytes > left => "the file ends within a block of pixels".to_owned(),
                _ => format!("a block of pixels claims {size} bytes"),
            };
            return Err(Fault::Damaged(found));
        };
        let mut bytes = vec![0; size as usize];
        self.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    fn int(&mut self) -> Parsed<i32> {
        let mut bytes = [0; 4];
        self.read_exact(&mut bytes)?;
        Ok(i32::from_le_bytes(bytes))
    }

    fn read_exact(&mut self, bytes: &mut [u8]) -> Parsed<()> {
        self.file.read_exact(bytes)?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    /// Moves to `position`, keeping the buffer if it is near.
    fn seek(&mut self, position: u64) -> Parsed<()> {
        let step = i128::from(position) - i128::from(self.position);
        match i64::try_from(step) {
            Ok(step) => self.file.seek_relative(step)?,
            Err(_) => _ = self.file.seek(SeekFrom::Start(position))?,
        }
        self.position = position;
        Ok(())
    }
}
