//! Check for truncated files: whether all blocks of pixels lie within the file.

use super::ExrFile;
use super::chunks::ChunkReader;
use super::fault::Parsed;

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
