//! Reading a custom tonal art map: a folder of pictures of strokes.

use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Plane, luminance};
use crate::io::environment::{color_size, read_color};
use crate::io::open::files_in;
use crate::io::picture::is_picture_name;
use crate::untrusted::shown;
use std::path::{Path, PathBuf};

/// Bytes per pixel of all pictures: its ink, and the texture made from it.
const INK_BYTES: u64 = 8;

/// Most pictures of a tonal art map: beyond it a step between two is invisible.
const MAX_PICTURES: usize = 256;

/// The ink, 0 paper to 1 black, of every picture in the folder at `path`, in the order of their names.
/// Other files are passed over.
///
/// # Errors
/// [`Error::Unsupported`] where there is no picture, too many, or more than fits in `most_bytes`;
/// [`Error::SizeMismatch`] for one whose size, by its header, is not that of the first; otherwise as for any picture.
pub fn read_art_map(path: &Path, most_bytes: u64) -> Result<Vec<Plane>> {
    let refused = |found: String, remedy: &str| Error::Unsupported {
        path: path.to_path_buf(),
        found,
        remedy: remedy.into(),
    };
    let files = pictures_in(path)?;
    if files.is_empty() || files.len() > MAX_PICTURES {
        return Err(refused(
            format!("holds {} pictures of strokes", files.len()),
            "give a folder of 1 to 256 pictures of one texture, from light to dark",
        ));
    }
    let [width, height] = color_size(&files[0])?;
    for file in &files[1..] {
        let size = color_size(file)?;
        if size != [width, height] {
            return Err(Error::SizeMismatch {
                path: file.clone(),
                found: format!("{}x{}", size[0], size[1]),
                expected: format!("{} is {width}x{height}", shown(&files[0])),
            });
        }
    }
    let bytes = (width as u64 * height as u64).saturating_mul(INK_BYTES * files.len() as u64);
    if bytes > most_bytes {
        return Err(refused(
            format!(
                "takes {} MiB, and {} may be used",
                bytes.div_ceil(1 << 20),
                most_bytes >> 20
            ),
            "make its pictures smaller, or allow more memory",
        ));
    }
    files
        .iter()
        .map(|file| Ok(ink(&read_color(file)?)))
        .collect()
}

fn pictures_in(path: &Path) -> Result<Vec<PathBuf>> {
    let mut files = files_in(path)?;
    files.retain(|file| file.is_file() && is_picture_name(file));
    Ok(files)
}

/// Darkness of a picture: 1 minus its luminance.
fn ink(color: &ColorPlanes) -> Plane {
    Plane::from_fn(color.r.width(), color.r.height(), |x, y| {
        1.0 - luminance(color.at(x, y), ColorPlanes::REC709_LUMINANCE)
    })
}
