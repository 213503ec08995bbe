//! The header of a NumPy array.

use super::faults::{damaged, unsupported};
use crate::error::{Error, Result};
use crate::untrusted::Untrusted;
use half::f16;
use std::io::Read;
use std::path::Path;

/// How a number is stored.
#[derive(Clone, Copy)]
pub(super) struct NumberFormat {
    /// `f`, `u` or `i`, or `b` for truth values.
    pub(super) kind: char,
    pub(super) bytes: usize,
    pub(super) is_little: bool,
}

impl NumberFormat {
    /// The number in these bytes, 1 to 8.
    pub(super) fn read(self, bytes: &[u8]) -> f32 {
        let mut wide = [0_u8; 8];
        for (to, from) in wide.iter_mut().zip(bytes) {
            *to = *from;
        }
        if !self.is_little {
            wide[..bytes.len()].reverse();
        }
        let code = u64::from_le_bytes(wide);
        match (self.kind, bytes.len()) {
            ('f', 2) => f16::from_bits(code as u16).to_f32(),
            ('f', 4) => f32::from_bits(code as u32),
            ('f', _) => f64::from_bits(code) as f32,
            // The sign is that of the highest bit stored.
            ('i', count) => {
                let above = 64 - 8 * count as u32;
                ((code << above) as i64 >> above) as f32
            }
            _ => code as f32,
        }
    }
}

/// How an array of numbers is stored.
pub(super) struct NpyHeader {
    /// Of each axis its size, and how many numbers its neighbours are apart.
    axes: Vec<(usize, usize)>,
    pub(super) number: NumberFormat,
}

/// The longest header that is read.
const MOST_BYTES: usize = 1 << 16;

/// An array as a picture: sizes of the picture in rows, columns and channels, and how many numbers neighbours along each
/// are apart.
pub(super) type Axes = [(usize, usize); 3];

impl NpyHeader {
    /// Reads a version, the length of what follows, and a dictionary in Python's form: `{'descr': '<f4', 'fortran_order':
    /// False, 'shape': (480, 640), }`.
    pub(super) fn read(path: &Path, file: &mut impl Read) -> Result<Self> {
        let mut taken = |count: usize| -> Result<Vec<u8>> {
            let mut bytes = vec![0; count];
            file.read_exact(&mut bytes)
                .map_err(|error| damaged(path, &error))?;
            Ok(bytes)
        };
        let wide = taken(8)?[6] > 1;
        let length = taken(if wide { 4 } else { 2 })?;
        let length = length
            .iter()
            .rev()
            .fold(0, |length, &byte| 256 * length + usize::from(byte));
        let header = taken(length.min(MOST_BYTES))?;
        Self::of_text(path, &String::from_utf8_lossy(&header))
    }

    fn of_text(path: &Path, header: &str) -> Result<Self> {
        let value = |key: &str| {
            let (_, rest) = header.split_once(&format!("'{key}':"))?;
            Some(rest.trim_start())
        };
        let no_header = || damaged(path, &"its header is none");
        let descr = value("descr").and_then(|rest| rest.strip_prefix('\'')?.split('\'').next());
        let shape = value("shape").and_then(|rest| rest.strip_prefix('(')?.split(')').next());
        let (Some(descr), Some(shape)) = (descr, shape) else {
            return Err(no_header());
        };
        let sizes = shape
            .split(',')
            .map(str::trim)
            .filter(|size| !size.is_empty());
        let sizes: Option<Vec<usize>> = sizes.map(|size| size.parse().ok()).collect();
        let sizes = sizes.ok_or_else(no_header)?;
        let mut letters = descr.chars();
        let (order, kind) = (letters.next(), letters.next());
        let bytes: Option<usize> = letters.as_str().parse().ok();
        let (
            "<" | ">" | "|" | "=",
            Some(kind @ ('f' | 'u' | 'i' | 'b')),
            Some(bytes @ (1 | 2 | 4 | 8)),
        ) = (&descr[..order.map_or(0, char::len_utf8)], kind, bytes)
        else {
            return Err(unsupported(
                path,
                &format!("holds {} numbers", Untrusted(descr)),
            ));
        };
        let is_rows_last = value("fortran_order").is_some_and(|rest| rest.starts_with("True"));
        let (mut apart, count) = (1_usize, sizes.len());
        let mut axes = vec![(0, 0); count];
        for i in (0..count).map(|i| if is_rows_last { i } else { count - 1 - i }) {
            axes[i] = (sizes[i], apart);
            apart = apart.saturating_mul(sizes[i]);
        }
        Ok(Self {
            axes,
            number: NumberFormat {
                kind,
                bytes,
                is_little: order != Some('>'),
            },
        })
    }

    /// It as a picture, or one of a stack of one: grey or of up to four channels, which come first or last.
    pub(super) fn picture(&self) -> Option<Axes> {
        let mut axes = &self.axes[..];
        while axes.len() > 2 && axes[0].0 == 1 {
            axes = &axes[1..];
        }
        let is_channels = |(size, _): (usize, usize)| (1..=4).contains(&size);
        match *axes {
            [rows, columns] => Some([rows, columns, (1, 0)]),
            [rows, columns, channels] if is_channels(channels) => Some([rows, columns, channels]),
            [channels, rows, columns] if is_channels(channels) => Some([rows, columns, channels]),
            _ => None,
        }
    }

    pub(super) fn no_picture(&self, path: &Path) -> Error {
        let sizes: Vec<_> = self.axes.iter().map(|(size, _)| size).collect();
        unsupported(path, &format!("is an array of {sizes:?}, and no picture"))
    }
}
