//! Any camera file, for a frame relit with any light, materials and settings.
//!
//! The input is that of `command_line`: flags of `relight`, an empty line, and the bytes of the camera file.

use super::command_line::parts;
use super::desk::Desk;

/// The start of every command line.
const RELIGHT: &str = "relight frame.exr -o lit.exr --layers results --camera extra";

/// Lights the frame as specified by `data`.
pub(super) fn run(data: &[u8]) {
    let (flags, camera) = parts(data);
    let begin = RELIGHT.split(' ').map(str::as_bytes);
    let words: Vec<_> = begin.chain(flags).collect();
    Desk::shared().run(&words, camera);
}
