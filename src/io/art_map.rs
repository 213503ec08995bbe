//! Reading a tonal art map of one's own: a folder of pictures of strokes.

use super::environment::read_color;
use super::picture::PictureFormat;
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Plane, REC709_LUMINANCE};
use std::fs;
use std::path::{Path, PathBuf};

/// Most pictures of a tonal art map: past this a step between two is not seen.
const MAX_PICTURES: usize = 256;

/// The ink, 0 paper to 1 black, of every picture in the folder at `path`, in the order of their names.
/// Other files are passed over.
///
/// # Errors
/// [`Error::Unsupported`] where there is no picture, too many, or one whose size is not that of the first;
/// otherwise as for any picture.
pub fn read_art_map(path: &Path) -> Result<Vec<Plane>> {
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
    let inks = files.iter().map(|file| Ok(ink(&read_color(file)?)));
    let inks = inks.collect::<Result<Vec<Plane>>>()?;
    let size = |plane: &Plane| (plane.width(), plane.height());
    let expected = size(&inks[0]);
    match inks
        .iter()
        .zip(&files)
        .find(|(ink, _)| size(ink) != expected)
    {
        None => Ok(inks),
        Some((other, file)) => Err(Error::SizeMismatch {
            path: file.clone(),
            found: format!("{}x{}", other.width(), other.height()),
            expected: format!("{} is {}x{}", files[0].display(), expected.0, expected.1),
        }),
    }
}

fn pictures_in(path: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(path).map_err(Error::io(path, "read"))?;
    let mut files = Vec::new();
    for entry in entries {
        let file = entry.map_err(Error::io(path, "read"))?.path();
        let is_exr = file
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        if file.is_file() && (is_exr || PictureFormat::of_path(&file).is_some()) {
            files.push(file);
        }
    }
    files.sort();
    Ok(files)
}

/// What a picture lacks of white.
fn ink(color: &ColorPlanes) -> Plane {
    let [r, g, b] = [&color.r, &color.g, &color.b].map(Plane::samples);
    let weights = REC709_LUMINANCE;
    let ink =
        (0..r.len()).map(|i| 1.0 - (r[i] * weights[0] + g[i] * weights[1] + b[i] * weights[2]));
    Plane::from_samples(color.r.width(), color.r.height(), ink.collect())
}
