//! From planes to the output file.

use crate::command::args::{LayersArg, OutputArgs, WorkArgs};
use crate::command::output::MOST_PLANES;
use crate::error::{Error, Result, bad};
use crate::frame::{Plane, Window};
use crate::io::Loaded;
use crate::io::exr::{OutputChannel, PartDescription, PartWriter, X_DENSITY};
use crate::io::likest;
use crate::io::output::OutputKind;
use crate::io::output::{Replace, names_of, software, write_atomically};
use crate::io::picture::{Array, ArrayFormat, Encoding};
use crate::params::{Params, PixelSize};
use crate::product::PART;
use crate::untrusted::{Untrusted, shown};
use std::io::{Seek, Write};
use std::ops::Range;
use std::path::Path;
use wildmatch::WildMatch;

/// The attribute that names the program.
const SOFTWARE_ATTRIBUTE: &str = "software";
/// The attribute that holds the recipe.
const RECIPE_ATTRIBUTE: &str = "relievo.recipe";

/// Where a result goes.
pub(super) struct ReadyOutput<'a> {
    pub(super) path: &'a Path,
    pub(super) replace: Replace,
}

/// Writes rows of planes.
pub(super) type NextRows<'w> =
    dyn FnMut(&[&Plane], Range<usize>, &mut (dyn FnMut() + Send)) -> Result<()> + Send + 'w;

/// The attributes of the part with our results: the program, the recipe, and pixels per inch if a flag gives them or the
/// size of a pixel on the subject.
pub(super) fn attributes(
    work: &WorkArgs,
    loaded: &Loaded,
    recipe: String,
) -> Vec<(String, String)> {
    let of_pixels = |size: PixelSize| size.dpi() * loaded.enlarged as f32;
    let printed = work
        .flags
        .params
        .dpi(loaded.frame.pixel_aspect)
        .map(|[across, _]| across);
    let density = printed.or(work.flags.params.pixel_size.map(of_pixels));
    let density = density.map(|density| (X_DENSITY.into(), density.to_string()));
    [
        (SOFTWARE_ATTRIBUTE.into(), software()),
        (RECIPE_ATTRIBUTE.into(), recipe),
    ]
    .into_iter()
    .chain(density)
    .collect()
}

impl OutputArgs {
    /// Whether an older output may be replaced.
    pub(super) fn replace(&self) -> Replace {
        match self.no_clobber {
            true => Replace::Never,
            false => self.replace_beside(),
        }
    }

    /// Whether older files beside the output may be replaced: timings and recipes.
    pub(super) fn replace_beside(&self) -> Replace {
        match self.force {
            true => Replace::Always,
            false => Replace::IfWritable,
        }
    }

    /// How a picture made of `loaded` by this recipe is written.
    pub(super) fn encoding(
        &self,
        loaded: &Loaded,
        recipe: String,
        params: &Params,
    ) -> Result<Encoding> {
        let mut metadata = loaded.metadata()?;
        // Colours that were turned to other primaries are no longer those of the profile.
        metadata.profile = metadata.profile.filter(|_| loaded.chromaticities.is_none());
        let plain = Encoding::default();
        Ok(Encoding {
            quality: self.quality.unwrap_or(plain.quality),
            software: Some(software()),
            settings: Some(recipe),
            pixel_mm: params
                .pixel_size
                .map(|size| f64::from(size.mm) / loaded.enlarged),
            scale_bar: params.scale_bar,
            metadata,
        })
    }

    /// Those of our channels that were asked for: by their names, or those of their layers or components.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for a name that no channel has.
    pub(super) fn picked<'a>(
        &self,
        mut channels: Vec<OutputChannel<'a>>,
    ) -> Result<Vec<OutputChannel<'a>>> {
        if self.write.is_empty() {
            return Ok(channels);
        }
        let is_it = |wanted: &str, channel: &OutputChannel| {
            let wanted = WildMatch::new(wanted);
            let full = self.layer_names.of(&channel.name);
            names_of(&channel.name).any(|name| wanted.matches(name))
                || names_of(&full).any(|name| wanted.matches(name))
        };
        for wanted in &self.write {
            if !channels.iter().any(|channel| is_it(wanted, channel)) {
                return Err(no_such_channel(wanted, &channels));
            }
        }
        channels.retain(|channel| self.write.iter().any(|wanted| is_it(wanted, channel)));
        Ok(channels)
    }

    /// The part that our results make, of the pixels `window`, with channels like these.
    pub(super) fn part(
        &self,
        loaded: &Loaded,
        window: Window,
        channels: &[OutputChannel],
        attributes: Vec<(String, String)>,
    ) -> PartDescription {
        let named = channels.iter();
        let channels = named
            .map(|channel| (self.layer_names.of(&channel.name), channel.sample_type))
            .collect();
        PartDescription {
            name: PART.into(),
            data_window: window,
            display_window: loaded.frame.display_window,
            pixel_aspect: loaded.frame.pixel_aspect,
            channels,
            attributes,
            chromaticities: loaded.chromaticities,
            compression: self.compression,
        }
    }

    /// Starts to write a part where the results go: beside the input's own parts, into its first one, or alone. What is
    /// not as it was in the input is said with it.
    fn part_writer<'w, W: Write + Seek>(
        &self,
        loaded: &'w Loaded,
        w: &'w mut W,
        path: &Path,
        part: &PartDescription,
    ) -> Result<(PartWriter<'w, W>, Vec<String>)> {
        let Some(input) = loaded.exr() else {
            return Ok((PartWriter::create(w, path, part)?, Vec::new()));
        };
        match self.layers {
            LayersArg::Results => Ok((PartWriter::create(w, path, part)?, Vec::new())),
            LayersArg::Keep => Ok((PartWriter::append(input, w, path, part)?, Vec::new())),
            LayersArg::Channels => {
                let window = input.parts[0].window;
                if window != part.data_window {
                    return Err(Error::SizeMismatch {
                        path: input.path.clone(),
                        found: format!("{window} in its first part"),
                        expected: format!("the results are {}", part.data_window),
                    });
                }
                let (writer, merged) = PartWriter::add_channels(input, 0, w, path, part)?;
                Ok((writer, merged.warnings))
            }
        }
    }

    /// Writes a part to an EXR or its planes as numbers, some rows at a time: `each` hands on the planes, one for each
    /// channel of the part, and the rows of them that come next. Returns what is not as it was in the input.
    pub(super) fn write_part(
        &self,
        output: ReadyOutput,
        loaded: &Loaded,
        part: &PartDescription,
        each: impl FnOnce(&mut NextRows) -> Result<()>,
    ) -> Result<Vec<String>> {
        if let OutputKind::Numbers(format) = self.kind()? {
            write_numbers(output, format, part, each)?;
            return Ok(Vec::new());
        }
        let ReadyOutput { path, replace } = output;
        let mut said = Vec::new();
        write_atomically(path, replace, |w| {
            let (mut writer, warnings) = self.part_writer(loaded, w, path, part)?;
            each(&mut |planes, rows, beside| writer.push_beside(planes, rows, beside))?;
            said = warnings;
            said.extend(self.clamped(writer.finish()?));
            Ok(())
        })?;
        Ok(said)
    }

    /// Warning that `count` samples were clamped; `None` for 0.
    fn clamped(&self, count: u64) -> Option<String> {
        let samples = if count == 1 {
            "sample is"
        } else {
            "samples are"
        };
        let lossless = match self.compression.is_lossy() && self.layers != LayersArg::Channels {
            true => " --compression zip",
            false => "",
        };
        (count > 0).then(|| {
            format!(
                "{count} {samples} too large for half floats and clamped; keep them with --depth-of-output float{lossless}"
            )
        })
    }
}

/// Writes the planes of a part as numbers. All are held until the last has come.
fn write_numbers(
    ReadyOutput { path, replace }: ReadyOutput,
    format: ArrayFormat,
    part: &PartDescription,
    each: impl FnOnce(&mut NextRows) -> Result<()>,
) -> Result<()> {
    let count = part.channels.len();
    if count > MOST_PLANES {
        let names = part.channels.iter().map(|(name, _)| name.as_str());
        return Err(bad(
            "--write",
            format!(
                "names {count} planes for {} ({})",
                shown(path),
                names.collect::<Vec<_>>().join(", ")
            ),
            format!("name up to {MOST_PLANES}, or write an .exr"),
        ));
    }
    let window = part.data_window;
    let mut array = Array::new([window.width(), window.height()], count);
    each(&mut |planes, rows, beside| {
        array.push(planes, rows);
        beside();
        Ok(())
    })?;
    let attribute = |name: &str| {
        let mut named = part.attributes.iter();
        named.find_map(|(own, text)| (own == name).then(|| text.clone()))
    };
    let encoding = Encoding {
        software: attribute(SOFTWARE_ATTRIBUTE),
        settings: attribute(RECIPE_ATTRIBUTE),
        ..Encoding::default()
    };
    write_atomically(path, replace, |w| array.write(w, path, format, &encoding))
}

fn no_such_channel(wanted: &str, channels: &[OutputChannel]) -> Error {
    let all: Vec<&str> = channels.iter().map(|channel| &*channel.name).collect();
    let every: Vec<&str> = all.iter().flat_map(|name| names_of(name)).collect();
    bad(
        "--write",
        format!(
            "no channel called {} (there are {})",
            Untrusted(wanted),
            all.join(", ")
        ),
        match likest(&every, wanted) {
            Some(meant) => format!("did you mean {meant}?"),
            None => "give their names, or those of their layers".into(),
        },
    )
}
