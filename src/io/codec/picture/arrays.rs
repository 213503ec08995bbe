//! Planes as numbers: NumPy arrays, and TIFF of floats.

use super::encoding::Encoding;
use super::stored::{Storable, unwritten, write_tiff};
use crate::error::{Error, Result};
use crate::frame::Plane;
use std::io::{Seek, Write};
use std::ops::Range;
use std::path::Path;

/// The kinds of files that hold planes as numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ArrayFormat {
    /// NumPy: little-endian floats, by rows, columns and, of several planes, channels.
    Npy,
    /// TIFF of 32-bit floats.
    Tiff,
}

/// Planes whose samples are gathered, some rows at a time, those of a pixel side by side, before they are written.
pub(crate) struct Array {
    size: [usize; 2],
    channels: usize,
    /// In native byte order.
    samples: Vec<[u8; 4]>,
}

/// Bytes of the start of a NumPy file, of which its header is a multiple.
const NPY_ALIGNMENT: usize = 64;

impl Array {
    /// Room for so many planes of `size`, columns and rows.
    pub(crate) fn new(size: [usize; 2], channels: usize) -> Self {
        Self {
            size,
            channels,
            samples: Vec::with_capacity(size[0] * size[1] * channels),
        }
    }

    /// Adds the rows `rows` of planes, below those added before.
    pub(crate) fn push(&mut self, planes: &[&Plane], rows: Range<usize>) {
        for y in rows {
            let rows: Vec<_> = planes.iter().map(|plane| plane.row(y)).collect();
            let pixel = |x: usize| rows.iter().map(move |row| row[x].to_ne_bytes());
            self.samples.extend((0..self.size[0]).flat_map(pixel));
        }
    }

    /// Writes them; `target` is only named in errors. Only a TIFF holds what `encoding` says.
    ///
    /// # Errors
    /// Any [`Error`] of writing.
    pub(crate) fn write(
        &self,
        w: &mut (impl Write + Seek),
        target: &Path,
        format: ArrayFormat,
        encoding: &Encoding,
    ) -> Result<()> {
        match format {
            ArrayFormat::Npy => self.write_npy(w).map_err(Error::io(target, "write")),
            ArrayFormat::Tiff => self.write_floats(w, encoding).map_err(unwritten(target)),
        }
    }

    fn write_npy(&self, w: &mut impl Write) -> std::io::Result<()> {
        let ([width, height], channels) = (self.size, self.channels);
        let shape = match channels {
            1 => format!("({height}, {width})"),
            _ => format!("({height}, {width}, {channels})"),
        };
        let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
        // Ten bytes before it, a line feed at its end.
        let whole = (10 + header.len() + 1).next_multiple_of(NPY_ALIGNMENT);
        let length = whole - 10;
        w.write_all(b"\x93NUMPY\x01\x00")?;
        w.write_all(&(length as u16).to_le_bytes())?;
        writeln!(w, "{header:<0$}", length - 1)?;
        for row in self.samples.chunks((width * channels).max(1)) {
            let samples = row.iter().map(|&v| f32::from_ne_bytes(v));
            let bytes: Vec<u8> = samples.flat_map(f32::to_le_bytes).collect();
            w.write_all(&bytes)?;
        }
        Ok(())
    }

    fn write_floats(
        &self,
        w: &mut (impl Write + Seek),
        encoding: &Encoding,
    ) -> image::ImageResult<()> {
        let stored = Storable {
            size: self.size.map(|side| side as u32),
            channels: self.channels,
            bits: 32,
            dpi: encoding.dpi(self.size[0]),
            profile: None,
            samples: self.samples.as_flattened(),
        };
        write_tiff(w, &stored, encoding)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::photo::Photo;
    use std::io::Cursor;

    /// Numbers come back bit for bit, whatever they are. The header of `numpy.save` is a multiple of 64 bytes.
    #[test]
    fn numbers_are_read_back_as_they_were() {
        let odd = [-0.0, f32::MIN_POSITIVE / 8.0, f32::INFINITY, -1e30, 0.1];
        let plane = |k: usize| Plane::from_fn(3, 5, |x, y| odd[(x + 3 * y + k) % 5] * k as f32);
        let planes = [1, 2, 3].map(plane);
        for format in [ArrayFormat::Npy, ArrayFormat::Tiff] {
            for count in [1, 3] {
                let planes: Vec<_> = planes.iter().take(count).collect();
                let mut array = Array::new([3, 5], count);
                array.push(&planes, 0..2);
                array.push(&planes, 2..5);
                let mut file = Cursor::new(Vec::new());
                let target = Path::new("test");
                let encoding = Encoding::default();
                array.write(&mut file, target, format, &encoding).unwrap();
                let file = file.into_inner();
                if format == ArrayFormat::Npy {
                    assert_eq!(file.len() % 64, 4 * 3 * 5 * count % 64);
                }
                let desk = tempfile::tempdir().unwrap();
                let path = desk.path().join("numbers");
                std::fs::write(&path, file).unwrap();
                let read = Photo::read(&path).unwrap();
                assert!(read.is_float && read.alpha.is_none());
                for (own, read) in planes.iter().zip(&read.channels) {
                    let bits =
                        |plane: &Plane| plane.samples().iter().map(|v| v.to_bits()).collect();
                    let [own, read]: [Vec<u32>; 2] = [bits(own), bits(read)];
                    assert_eq!(own, read, "{format:?} {count}");
                }
            }
        }
    }
}
