//! Whole command lines, on a desk of small files.
//!
//! The input is text: the words of a command line, one a line (`''` is an empty word), then an empty line, then the
//! bytes of the file `extra`, which the words may use as a camera, a recipe, a picture or anything else.

use super::desk::Desk;

/// Words and the bytes of `extra`.
pub(super) fn parts(data: &[u8]) -> (Vec<&[u8]>, &[u8]) {
    let (words, extra) = match data.windows(2).position(|pair| pair == b"\n\n") {
        Some(end) => (&data[..end], &data[end + 2..]),
        None => (data.strip_suffix(b"\n").unwrap_or(data), &[][..]),
    };
    let word = |line| if line == b"''" { &[][..] } else { line };
    (words.split(|&b| b == b'\n').map(word).collect(), extra)
}

/// Runs the command line in `data`.
pub(super) fn run(data: &[u8]) {
    let (words, extra) = parts(data);
    Desk::shared().run(&words, extra);
}
