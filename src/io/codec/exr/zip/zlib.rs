//! zlib by zlib-rs, in Rust alone.

use super::smooth::{Coding, LEVEL, WINDOW_BITS, compressed, deflate_by};
use std::cell::RefCell;
use zlib_rs::{Deflate, Inflate, InflateFlush, Status, Strategy};

/// Ways that take less time than [`deflate`], the quickest first. The last makes 20 layers of shape of a noisy picture of
/// 1920x1080 2 % larger than it does, and `shape` takes nine tenths of the time.
pub(super) const QUICKER: [Coding; 3] = [Coding::Runs, Coding::First, Coding::Coded];

thread_local! {
    /// zlib's working state: costly to make, and reused by all blocks of a thread.
    static INFLATE: RefCell<Inflate> = RefCell::new(Inflate::new(true, WINDOW_BITS as u8));
    static DEFLATE: RefCell<Deflate> = RefCell::new(deflate_by(LEVEL, Strategy::Default, WINDOW_BITS));
}

/// Decompresses `compressed` into `into`; returns the number of bytes, `None` for damaged data or more bytes than fit.
pub(super) fn inflate(compressed: &[u8], into: &mut [u8]) -> Option<usize> {
    INFLATE.with_borrow_mut(|inflate| {
        inflate.reset(true);
        match inflate.decompress(compressed, into, InflateFlush::Finish) {
            Ok(Status::StreamEnd) => Some(inflate.total_out() as usize),
            _ => None,
        }
    })
}

/// Compresses `bytes` into `into`; returns the number of compressed bytes, `None` if they do not fit.
pub(super) fn deflate(bytes: &[u8], into: &mut [u8]) -> Option<usize> {
    DEFLATE.with_borrow_mut(|deflate| compressed(deflate, bytes, into))
}
