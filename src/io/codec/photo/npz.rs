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
use zip::{CompressionMethod, ZipArchive};

/// An array of an archive.
struct Member {
    /// Without `.npy`.
    name: String,
    is_deflated: bool,
    /// Bytes in the archive, and where they are.
    bytes: u64,
    at: u64,
}

/// What every archive begins with.
const START: &[u8] = b"PK\x03\x04";
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
    if !start.starts_with(START) {
        return Ok(None);
    }
    let members = members(path, file)?;
    let pictures = pictures(path, &members)?;
    let inside = pictures.iter().map(|member| path.join(&member.name));
    Ok(Some(inside.collect()))
}

/// The bytes of the array `name` of an archive, or of the only one that could be a picture.
pub(super) fn open(path: &Path, name: Option<&str>) -> Result<Box<dyn Read>> {
    let members = members(path, open_buffered(path)?)?;
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

/// The arrays of an archive.
fn members(path: &Path, file: impl Read + Seek) -> Result<Vec<Member>> {
    let broken = |error| damaged(path, &error);
    let mut archive = ZipArchive::new(file).map_err(broken)?;
    let mut members = Vec::new();
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(broken)?;
        let name = entry.name().map_err(broken)?;
        let (Some(name), Some(at)) = (name.strip_suffix(".npy"), entry.data_start()) else {
            continue;
        };
        let method = entry.compression();
        let is_known = [CompressionMethod::Stored, CompressionMethod::Deflated].contains(&method);
        if entry.encrypted() || !is_known {
            let found = "is encrypted, or compressed in a rare way";
            return Err(unsupported(path, found));
        }
        members.push(Member {
            name: name.into(),
            is_deflated: method == CompressionMethod::Deflated,
            bytes: entry.compressed_size(),
            at,
        });
    }
    Ok(members)
}

impl Member {
    fn open(&self, path: &Path) -> Result<Box<dyn Read>> {
        let mut file = open_buffered(path)?;
        file.seek(SeekFrom::Start(self.at))
            .map_err(|error| damaged(path, &error))?;
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
    use std::io::{Cursor, Write};
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    /// A NumPy array of floats, each its index.
    fn npy(shape: &str, count: usize) -> Vec<u8> {
        let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut file = b"\x93NUMPY\x01\x00".to_vec();
        file.extend((header.len() as u16).to_le_bytes());
        file.extend(header.bytes());
        file.extend((0..count).flat_map(|i| (i as f32).to_le_bytes()));
        file
    }

    /// An archive, as `numpy.savez` or `savez_compressed` writes one.
    fn npz(arrays: &[(&str, Vec<u8>)], is_deflated: bool) -> Vec<u8> {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let method = match is_deflated {
            true => CompressionMethod::Deflated,
            false => CompressionMethod::Stored,
        };
        // NumPy asks for sizes in 64 bits.
        let options = SimpleFileOptions::default().large_file(true);
        for (name, array) in arrays {
            let started =
                archive.start_file(format!("{name}.npy"), options.compression_method(method));
            started.unwrap();
            archive.write_all(array).unwrap();
        }
        archive.finish().unwrap().into_inner()
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
