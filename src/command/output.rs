//! The kind of output that a path names, and the names of files.

use super::args::{LayersArg, OutputArgs};
use crate::error::{Result, bad};
use crate::io::Loaded;
use crate::io::output::OutputKind;
use crate::io::picture::{ArrayFormat, PictureFormat};
use crate::params::Params;
use crate::product::PART;
use crate::untrusted::shown;
use std::path::{Path, PathBuf};

/// Placeholder in file names for the input's name without folder and extension.
pub(crate) const NAME: &str = "{name}";

/// Placeholder in the output's name for the map.
const MAP: &str = "{map}";

impl OutputArgs {
    /// The kind of the output, but for lines; a picture if no output is given. A TIFF of maps or of chosen layers holds
    /// their numbers.
    pub(crate) fn kind(&self) -> Result<OutputKind> {
        let Some(path) = self.output.as_deref() else {
            return Ok(OutputKind::Picture(PictureFormat::Png));
        };
        let is_of_numbers = self.tiff_holds_numbers || !self.write.is_empty();
        match OutputKind::of(path)? {
            OutputKind::Picture(PictureFormat::Tiff) if is_of_numbers => {
                Ok(OutputKind::Numbers(ArrayFormat::Tiff))
            }
            OutputKind::Svg => Err(OutputKind::unknown(path)),
            kind => Ok(kind),
        }
    }

    /// Refuses a file of numbers for a command that makes a picture.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the output.
    pub(crate) fn refuse_numbers(&self) -> Result<()> {
        let (Ok(OutputKind::Numbers(_)), Some(path)) = (self.kind(), &self.output) else {
            return Ok(());
        };
        Err(bad(
            "-o",
            format!(
                "{} is to hold planes of numbers, and this command makes a picture",
                shown(path)
            ),
            "write an .exr; normals, map and shape write numbers",
        ))
    }

    /// The files it names: one, or one for each map.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let Some(output) = &self.output else {
            return Vec::new();
        };
        match self.pattern().and_then(Path::to_str) {
            Some(pattern) if pattern.contains(MAP) && !self.parts.is_empty() => {
                let name = self.named.as_ref().map_or(NAME, |(_, name)| name);
                let parts = self.parts.iter();
                let file = |part: &String| filled(pattern, &[(NAME, name), (MAP, part)]).into();
                parts.map(file).collect()
            }
            _ => vec![output.clone()],
        }
    }

    /// Whether its name has a place for the map.
    pub(crate) fn is_per_map(&self) -> bool {
        let pattern = self.pattern().map(Path::to_string_lossy);
        pattern.is_some_and(|pattern| pattern.contains(MAP))
    }

    /// Its name as given.
    fn pattern(&self) -> Option<&Path> {
        let named = self.named.as_ref().map(|(pattern, _)| pattern.as_path());
        named.or(self.output.as_deref())
    }

    /// The prefix of our colour channels: none in a file of our own, where they are the picture.
    pub(crate) fn color_layer(&self, loaded: &Loaded) -> Option<&'static str> {
        let beside = loaded.exr().is_some() && self.layers != LayersArg::Results;
        beside.then_some(PART)
    }

    /// Whether it is an SVG.
    pub(crate) fn is_svg(&self) -> bool {
        let kind = self.output.as_deref().map(OutputKind::of);
        matches!(kind, Some(Ok(OutputKind::Svg)))
    }

    /// Refuses --quality for files that are not JPEG, a choice of channels for pictures, and a page for all but SVG.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the output.
    pub(crate) fn refuse_idle(&self, params: &Params) -> Result<()> {
        let Some(path) = &self.output else {
            return Ok(());
        };
        let is_jpeg = PictureFormat::of_path(path) == Some(PictureFormat::Jpeg);
        let holds_layers = matches!(self.kind(), Ok(OutputKind::Exr | OutputKind::Numbers(_)));
        let of = |name, format: &str, extension: &str| {
            Err(bad(
                name,
                format!("is of {format} alone, and {} is none", shown(path)),
                format!("write a {extension} or leave it out"),
            ))
        };
        if self.quality.is_some() && !is_jpeg {
            return of("--quality", "JPEG", ".jpg");
        }
        if !self.write.is_empty() && !holds_layers {
            return of("--write", "EXR, NPY and TIFF", ".exr");
        }
        if params.page.is_some() && !self.is_svg() {
            return of("--page", "SVG", ".svg");
        }
        Ok(())
    }
}

/// Most planes in a file of numbers, which are read again as a picture's channels.
pub(crate) const MOST_PLANES: usize = 4;

/// `pattern` with each placeholder replaced by its text, which may look like another one.
fn filled(pattern: &str, texts: &[(&str, &str)]) -> String {
    let mut made = String::new();
    let mut rest = pattern;
    while let Some(next) = rest.chars().next() {
        let found = texts.iter().find(|(place, _)| rest.starts_with(place));
        let own = &rest[..next.len_utf8()];
        let &(place, text) = found.unwrap_or(&(own, own));
        made += text;
        rest = &rest[place.len()..];
    }
    made
}
