//! Pictures that light may come from: environments and lit spheres beside the open picture.

use super::ViewPixels;
use crate::frame::ColorPlanes;
use crate::io::environment::{color_size, read_color};
use crate::io::picture::{Picture, PictureFormat, ViewTransform, is_picture_name, small};
use std::path::{Path, PathBuf};

/// Size limit of a file that is shown small, in bytes: it is read whole for that.
const MOST_BYTES: u64 = 32 << 20;

/// Number of files looked for.
const MOST_FILES: usize = 200;

/// Longest side of a picture taken for a lit sphere.
const LARGEST_SPHERE: usize = 2048;

/// Largest mean difference between neighbouring pixels of a lit sphere, linear and made small: balls shade smoothly, and
/// textures, square as well, do not.
const SMOOTH: f32 = 0.02;

/// Mean of an environment that is shown small.
const MEAN: f32 = 0.25;

/// A picture that light may come from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LightFile {
    /// The setting that takes it.
    pub(crate) setting: &'static str,
    pub(crate) path: PathBuf,
}

/// The setting for environments.
pub(crate) const ENVIRONMENT: &str = "environment";

/// The setting for lit spheres.
pub(crate) const LIT_SPHERE: &str = "lit-sphere";

/// What may be light in the folder of `input`, by name; the headers of files decide, and whether they are shown small.
pub(crate) fn light_files(input: &Path) -> Vec<LightFile> {
    let folder = input.parent().unwrap_or(Path::new(""));
    let read = match folder.as_os_str().is_empty() {
        true => Path::new(".").read_dir(),
        false => folder.read_dir(),
    };
    let entries = read.into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries
        .filter(|entry| {
            let size = entry.metadata().map_or(0, |about| about.len());
            (1..=MOST_BYTES).contains(&size)
        })
        // As the picture is named: relative paths stay relative.
        .map(|entry| folder.join(entry.file_name()))
        .filter(|path| path != input)
        .collect();
    paths.sort();
    let named = paths.into_iter().filter_map(|path| {
        let setting = setting_for(&path)?;
        Some(LightFile { setting, path })
    });
    named.take(MOST_FILES).collect()
}

/// The setting that a file is likely for.
fn setting_for(path: &Path) -> Option<&'static str> {
    if !is_picture_name(path) {
        return None;
    }
    let [width, height] = color_size(path).ok()?;
    match PictureFormat::of_path(path) {
        Some(PictureFormat::Hdr) => Some(ENVIRONMENT),
        Some(_) if width == height && width <= LARGEST_SPHERE => Some(LIT_SPHERE),
        // An EXR.
        None if width == 2 * height => Some(ENVIRONMENT),
        _ => None,
    }
}

impl LightFile {
    /// It with no side longer than `longest`; `None` if it cannot be read, or is no lit sphere after all.
    pub(crate) fn small(&self, longest: usize) -> Option<ViewPixels> {
        let whole = read_color(&self.path).ok()?;
        let size = [whole.r.width(), whole.r.height()];
        let channels = [&whole.r, &whole.g, &whole.b];
        let at = |x: usize, y: usize, c: usize| channels[c].at(x, y);
        let gain = match self.setting {
            ENVIRONMENT => {
                let samples = whole.g.samples();
                let sum: f64 = samples
                    .iter()
                    .map(|&v| f64::from(v.clamp(0.0, 65504.0)))
                    .sum();
                MEAN / (sum / samples.len() as f64).max(1e-6) as f32
            }
            _ => 1.0,
        };
        let color = small(size, longest, |x, y, c| gain * at(x, y, c));
        if self.setting == LIT_SPHERE && roughness(&color) > SMOOTH {
            return None;
        }
        Some(ViewPixels::of(&Picture::of(&color, ViewTransform::Srgb)))
    }
}

/// Mean difference between pixels side by side.
fn roughness(color: &ColorPlanes) -> f32 {
    let (width, height) = (color.g.width(), color.g.height());
    let pairs = (0..height).flat_map(|y| (1..width).map(move |x| (x, y)));
    let sum: f32 = pairs
        .map(|(x, y)| (color.g.at(x, y) - color.g.at(x - 1, y)).abs())
        .sum();
    sum / ((width - 1).max(1) * height) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn environments_and_lit_spheres_are_told_from_other_pictures() {
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
        let found = light_files(&fixtures.join("bust.exr"));
        let shown = found.iter().filter(|file| file.small(64).is_some());
        let names = shown.map(|file| (file.setting, file.path.strip_prefix(&fixtures).unwrap()));
        let names: Vec<_> = names
            .map(|(setting, name)| (setting, name.to_str().unwrap()))
            .collect();
        // Not the square colour and normals of a tablet, nor renders.
        assert_eq!(
            names,
            [
                (LIT_SPHERE, "clay.png"),
                (ENVIRONMENT, "mirror.surroundings.exr"),
                (ENVIRONMENT, "room.hdr"),
                (LIT_SPHERE, "slate.png"),
            ]
        );
    }
}
