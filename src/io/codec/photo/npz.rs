//! NumPy archives: ZIP files of arrays, as they are or deflated.
//!
//! A path into one names an array: `out.npz/depth`.

use super::faults::{damaged, unsupported};
use super::npy::NpyHeader;
use crate::error::{Error, Result};
use crate::io::open::open_buffered;
use crate::untrusted::{Untrusted, listed};
use flate2::bufread::DeflateDecoder;
use std::io::{BufRead, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// An array of an archive.
struct Member {
    /// Without `.npy`.
    name: String,
    is_deflated: bool,
    /// Bytes in the archive.
    bytes: u64,
    /// Where its local header is.
    at: u64,
}

/// The end of an archive: its mark, its length without a comment, and the longest comment.
const END: (&[u8], usize, u64) = (b"PK\x05\x06", 22, 1 << 16);
/// An entry of the directory, and the header of a file: their marks, and their lengths without names.
const ENTRY: (&[u8], usize) = (b"PK\x01\x02", 46);
const LOCAL: (&[u8], usize) = (b"PK\x03\x04", 30);
/// The largest directory that is read, in bytes.
const MOST_BYTES: u64 = 1 << 20;
/// Longest side of what is a matrix rather than a picture, where there are several arrays.
const MATRIX: usize = 4;

/// The archive and the name of the array of a path into one.
pub(super) fn split(path: &Path) -> Option<(&Path, &str)> {
    let (archive, name) = (path.parent()?, path.file_name()?.to_str()?);
    let is_archive = archive
        .extension()
        .is_some_and(|own| own.eq_ignore_ascii_case("npz"));
    let name = name.strip_suffix(".npy").unwrap_or(name);
    (is_archive && archive.is_file()).then_some((archive, name))
}

/// Whether a path leads into an archive, whether or not there is an array of that name.
pub(in crate::io) fn is_inside(path: &Path) -> bool {
    split(path).is_some()
}

/// The paths to the arrays of an archive that could be pictures; `None` for another file.
///
/// # Errors
/// [`Error::Damaged`], [`Error::Unsupported`] and [`Error::Io`].
pub(in crate::io) fn pictures_in(path: &Path) -> Result<Option<Vec<PathBuf>>> {
    let mut file = open_buffered(path)?;
    let start = file.fill_buf().map_err(Error::io(path, "read"))?;
    if !start.starts_with(LOCAL.0) {
        return Ok(None);
    }
    let members = members(path, &mut file)?;
    let pictures = pictures(path, &members)?;
    let inside = pictures.iter().map(|member| path.join(&member.name));
    Ok(Some(inside.collect()))
}

/// The bytes of the array `name` of an archive, or of the only one that could be a picture.
pub(super) fn open(path: &Path, name: Option<&str>) -> Result<Box<dyn Read>> {
    let mut file = open_buffered(path)?;
    let members = members(path, &mut file)?;
    let names: Vec<_> = members.iter().map(|member| member.name.clone()).collect();
    let refused = |found: String| Error::Unsupported {
        path: path.to_path_buf(),
        found,
        remedy: format!(
            "name an array, as in {}",
            Untrusted(
                &path
                    .join(names.first().map_or("", |name| name))
                    .to_string_lossy()
            )
        ),
    };
    let holds = listed(&names);
    let one = match name {
        Some(name) => members.iter().find(|member| member.name == name),
        None => match pictures(path, &members)?[..] {
            [one] => Some(one),
            [] => return Err(refused(format!("holds no picture (found {holds})"))),
            _ => return Err(refused(format!("holds several arrays ({holds})"))),
        },
    };
    match one {
        Some(member) => member.open(path),
        None => Err(refused(format!("has no such array (found {holds})"))),
    }
}

/// The arrays that could be pictures, but for matrices.
fn pictures<'m>(path: &Path, members: &'m [Member]) -> Result<Vec<&'m Member>> {
    let mut found = Vec::new();
    for member in members {
        // An array of a kind that is not read is no picture.
        let header = NpyHeader::read(path, &mut member.open(path)?);
        let axes = header.ok().and_then(|header| header.picture());
        if axes.is_some_and(|[rows, columns, _]| rows.0.max(columns.0) > MATRIX) {
            found.push(member);
        }
    }
    Ok(found)
}

/// The arrays of an archive, by the directory at its end.
fn members(path: &Path, file: &mut (impl Read + Seek)) -> Result<Vec<Member>> {
    let none = || damaged(path, &"an archive without a directory");
    let (mark, length, comment) = END;
    let size = file.seek(SeekFrom::End(0));
    let size = size.map_err(Error::io(path, "read"))?;
    let mut read = |at: u64, count: u64| -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let found = file.seek(SeekFrom::Start(at));
        let read = found.and_then(|_| file.take(count).read_to_end(&mut bytes));
        read.map_err(Error::io(path, "read")).map(|_| bytes)
    };
    let from = size.saturating_sub(length as u64 + comment);
    let tail = read(from, size - from)?;
    let mut windows = tail.windows(length);
    let end = windows.rfind(|end| end.starts_with(mark));
    let end = end.ok_or_else(none)?;
    let (count, bytes, at) = (number(end, 10, 2), number(end, 12, 4), number(end, 16, 4));
    if bytes > MOST_BYTES || at > size {
        return Err(none());
    }
    let directory = read(at, bytes)?;
    let (mut rest, mut members) = (&directory[..], Vec::new());
    let (mark, length) = ENTRY;
    for _ in 0..count {
        let entry = rest.get(..length).filter(|entry| entry.starts_with(mark));
        let entry = entry.ok_or_else(none)?;
        let [name, extra, comment] = [28, 30, 32].map(|at| number(entry, at, 2) as usize);
        let name = rest.get(length..length + name).ok_or_else(none)?;
        let name = String::from_utf8_lossy(name);
        rest = rest
            .get(length + name.len() + extra + comment..)
            .ok_or_else(none)?;
        let (flags, method) = (number(entry, 8, 2), number(entry, 10, 2));
        let Some(name) = name.strip_suffix(".npy") else {
            continue;
        };
        if flags & 1 != 0 || ![0, 8].contains(&method) {
            return Err(unsupported(
                path,
                "is encrypted, or compressed in a rare way",
            ));
        }
        members.push(Member {
            name: name.into(),
            is_deflated: method == 8,
            bytes: number(entry, 20, 4),
            at: number(entry, 42, 4),
        });
    }
    Ok(members)
}

/// The number of so many bytes at a place.
fn number(bytes: &[u8], at: usize, count: usize) -> u64 {
    let bytes = bytes[at..at + count].iter().rev();
    bytes.fold(0, |number, &byte| 256 * number + u64::from(byte))
}

impl Member {
    fn open(&self, path: &Path) -> Result<Box<dyn Read>> {
        let mut file = open_buffered(path)?;
        let (mark, length) = LOCAL;
        let mut header = vec![0; length];
        let mut read = || {
            file.seek(SeekFrom::Start(self.at))?;
            file.read_exact(&mut header)?;
            let [name, extra] = [26, 28].map(|at| number(&header, at, 2) as i64);
            file.seek_relative(name + extra)
        };
        read().map_err(|error| damaged(path, &error))?;
        if !header.starts_with(mark) {
            return Err(damaged(path, &"its directory leads nowhere"));
        }
        let stored = file.take(self.bytes);
        Ok(match self.is_deflated {
            true => Box::new(DeflateDecoder::new(stored)),
            false => Box::new(stored),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::photo::Photo;
    use zlib_rs::{DeflateConfig, compress_slice};

    /// A NumPy array of floats, each its index.
    fn npy(shape: &str, count: usize) -> Vec<u8> {
        let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut file = b"\x93NUMPY\x01\x00".to_vec();
        file.extend((header.len() as u16).to_le_bytes());
        file.extend(header.bytes());
        file.extend((0..count).flat_map(|i| (i as f32).to_le_bytes()));
        file
    }

    /// An archive, as `numpy.savez` or `savez_compressed` writes one. zlib puts two bytes before what is deflated and four
    /// behind it.
    fn npz(arrays: &[(&str, Vec<u8>)], is_deflated: bool) -> Vec<u8> {
        let (mut file, mut directory) = (Vec::new(), Vec::new());
        for (name, array) in arrays {
            let mut room = vec![0; array.len() + 1000];
            let stored = match is_deflated {
                true => {
                    let (made, _) = compress_slice(&mut room, array, DeflateConfig::default());
                    made[2..made.len() - 4].to_vec()
                }
                false => array.clone(),
            };
            let name = format!("{name}.npy");
            let sizes = [stored.len() as u32, array.len() as u32].map(u32::to_le_bytes);
            let method = 8 * u16::from(is_deflated);
            let at = file.len() as u32;
            let common = |out: &mut Vec<u8>, extra: u16| {
                out.extend([20, 0, 0, 0]);
                out.extend(method.to_le_bytes());
                out.extend([0; 8]);
                out.extend(sizes.as_flattened());
                out.extend((name.len() as u16).to_le_bytes());
                out.extend(extra.to_le_bytes());
            };
            file.extend(LOCAL.0);
            // An extra field, as of sizes in 64 bits.
            common(&mut file, 4);
            file.extend(name.bytes());
            file.extend([1, 0, 0, 0]);
            file.extend(stored);
            directory.extend(ENTRY.0);
            directory.extend([20, 3]);
            common(&mut directory, 0);
            directory.extend([0; 10]);
            directory.extend(at.to_le_bytes());
            directory.extend(name.bytes());
        }
        let (at, bytes) = (file.len() as u32, directory.len() as u32);
        let count = (arrays.len() as u16).to_le_bytes();
        file.extend(directory);
        file.extend(END.0);
        file.extend([0; 4]);
        file.extend([count, count].as_flattened());
        file.extend([bytes, at].map(u32::to_le_bytes).as_flattened());
        file.extend([0; 2]);
        file
    }

    #[test]
    fn the_only_picture_is_taken_and_others_by_their_names() {
        let desk = tempfile::tempdir().unwrap();
        let path = desk.path().join("out.npz");
        for is_deflated in [false, true] {
            let matrix = ("k", npy("(3, 3)", 9));
            let depth = ("depth", npy("(20, 30)", 600));
            let arrays = [matrix, depth, ("normal", npy("(20, 30, 3)", 1800))];
            std::fs::write(&path, npz(&arrays[..2], is_deflated)).unwrap();
            let photo = Photo::read(&path).unwrap();
            assert_eq!((photo.width, photo.height), (30, 20));
            // Number 30 y + x.
            assert_eq!(photo.channels[0].at(29, 19), 599.0);
            std::fs::write(&path, npz(&arrays, is_deflated)).unwrap();
            let said = Photo::read(&path).map(drop).unwrap_err().to_string();
            assert!(said.contains("k, depth, normal"), "{said}");
            let photo = Photo::read(&path.join("normal")).unwrap();
            assert_eq!(photo.channels[2].at(29, 19), 1799.0);
            let inside = pictures_in(&path).unwrap().unwrap();
            assert_eq!(inside, [path.join("depth"), path.join("normal")]);
            let said = Photo::read(&path.join("mask")).map(drop).unwrap_err();
            assert!(said.to_string().contains("no such array"), "{said}");
        }
    }

    #[test]
    fn damage_is_told_in_one_line() {
        let desk = tempfile::tempdir().unwrap();
        let path = desk.path().join("out.npz");
        let whole = npz(&[("depth", npy("(20, 30)", 600))], true);
        for end in (0..whole.len()).step_by(5) {
            std::fs::write(&path, &whole[..end]).unwrap();
            let said = Photo::read(&path).map(drop).unwrap_err().to_string();
            assert!(!said.contains('\n'), "{said}");
        }
    }
}
