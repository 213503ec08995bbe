//! Memory that reading and writing take.

use super::ExrFile;
use super::encode::BATCH_BYTES;
use super::read::decoding_bytes;
use ::exr::compression::Compression;

impl ExrFile {
    /// Most bytes of blocks that are there while channels of any part are read.
    pub(in crate::io) fn decoding_bytes(&self) -> u64 {
        let parts = self.header.meta.headers.iter();
        let most = parts.map(decoding_bytes).max();
        most.map_or(0, |bytes| bytes.try_into().unwrap_or(u64::MAX))
    }
}

/// Most memory that blocks take while a strip of `bytes`, `row_bytes` in each row, is written: compressed ones of the
/// strip, and for each thread one of ZIP as laid out, as differences, and compressed.
pub(crate) fn encoding_bytes(bytes: u64, row_bytes: u64) -> u64 {
    let block_rows = 3 * Compression::ZIP16.scan_lines_per_block() * rayon::current_num_threads();
    let working = row_bytes.saturating_mul(block_rows as u64);
    working.saturating_add(bytes.min(BATCH_BYTES as u64))
}
