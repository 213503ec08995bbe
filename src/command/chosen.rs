//! Automatic choices, as the flags that would choose the same.

use super::flags::Flag;
use super::role_args;
use super::still_camera::{self, StillCamera};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::io::Loaded;
use crate::io::inputs::{Conventions, KnownCamera};
use crate::kernel::quantile::quantile;
use crate::light::lights::LightChoice;
use crate::params::{LineLevels, ToneLevels};
use crate::plan::outcome::Outcome;

/// Pixels looked at for the distance of a frame's surface.
const WANTED_DISTANCES: usize = 4_000;

/// Automatic choices for one frame. Settings that were given or not needed are left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Chosen {
    /// Numbers by their flag; those of a kind of light also by the light's name.
    numbers: Vec<(&'static str, &'static str, f32)>,
    /// Levels that shape-showing tones were fitted to; for a sequence the median over its frames.
    tone_levels: Option<[f32; ToneLevels::COUNT]>,
    /// Levels that widths of interior lines were fitted to; for a sequence the median over its frames.
    line_levels: Option<[f32; LineLevels::COUNT]>,
    /// How the layers were read, for frames that show a surface.
    conventions: Option<Conventions>,
    /// The recovered camera of one frame and the distance of the surface; a sequence has `still_camera` instead.
    recovered: Option<(KnownCamera, f64)>,
    still_camera: Option<StillCamera>,
    /// What stands for an environment. No flag chooses it.
    light: Option<LightChoice>,
    /// Which [`SHADOWS`] are cast; in a sequence those of its first frame.
    shadows: [Option<bool>; 2],
}

impl Chosen {
    /// Choices made while loading `loaded` and running to `outcome`.
    pub(crate) fn made(loaded: &Loaded, outcome: &Outcome) -> Self {
        Self::in_loading(loaded).running(outcome)
    }

    /// Choices made while loading `loaded`.
    pub(crate) fn in_loading(loaded: &Loaded) -> Self {
        Self {
            conventions: conventions_of(loaded),
            recovered: recovered(loaded),
            ..Self::default()
        }
    }

    /// Adds the choices made while running to `outcome`.
    pub(crate) fn running(self, outcome: &Outcome) -> Self {
        let single = [
            ("curvature-gain", outcome.gain),
            ("white-level", outcome.white_level),
            ("environment-gain", outcome.environment_gain),
            ("middle-light", outcome.middle_light),
            (
                "white-point",
                outcome.drawing.as_ref().map(|d| d.white_point),
            ),
        ];
        Self {
            numbers: numbers(&single, &outcome.term_white_levels),
            tone_levels: outcome.tone_levels,
            line_levels: outcome.line_levels,
            light: outcome.light_choice,
            shadows: outcome.casts_shadows,
            ..self
        }
    }

    /// How the layers were read, before anything has run.
    pub(crate) fn of_reading(loaded: &Loaded) -> Self {
        Self {
            conventions: conventions_of(loaded),
            ..Self::default()
        }
    }

    /// Adds the exposure chosen for the picture, in stops.
    pub(crate) fn exposed(mut self, stops: Option<f32>) -> Self {
        self.numbers
            .extend(stops.map(|stops| ("exposure", "", stops)));
        self
    }

    /// Choices that suit all frames: the median of each number, the most frequent conventions. Frames that failed are left
    /// out.
    ///
    /// # Errors
    /// That of the first frame if all failed; [`Error::Cancelled`].
    pub(crate) fn for_all(frames: impl Iterator<Item = Result<Self>>) -> Result<Self> {
        let (mut each, mut first_error) = (Vec::new(), None);
        for chosen in frames {
            match chosen {
                Ok(chosen) => each.push(chosen),
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) => first_error = first_error.or(Some(error)),
            }
        }
        match first_error {
            Some(error) if each.is_empty() => Err(error),
            _ => Ok(Self::of_several(&each)),
        }
    }

    fn of_several(each: &[Self]) -> Self {
        let mut kinds: Vec<_> = each.iter().flat_map(|chosen| &chosen.numbers).collect();
        kinds.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
        let cameras: Option<Vec<_>> = each.iter().map(|chosen| chosen.recovered).collect();
        let groups = kinds.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        Self {
            numbers: groups.map(|group| *group[group.len() / 2]).collect(),
            tone_levels: median(each.iter().filter_map(|chosen| chosen.tone_levels)),
            line_levels: median(each.iter().filter_map(|chosen| chosen.line_levels)),
            conventions: most_frequent(each.iter().filter_map(|chosen| chosen.conventions)),
            light: each.iter().find_map(|chosen| chosen.light),
            shadows: [0, 1].map(|i| each.iter().find_map(|chosen| chosen.shadows[i])),
            recovered: None,
            still_camera: cameras.and_then(|cameras| still_camera::of_all(&cameras)),
        }
    }

    pub(crate) fn flags(&self) -> Vec<Flag> {
        let flag = |&(name, term, number): &(&str, &str, f32)| match term {
            "" => Flag::new(name, number),
            term => Flag::new(name, format_args!("{term}={number}")),
        };
        let conventions = self.conventions.iter().flat_map(role_args::flags_of);
        let camera = self
            .still_camera
            .map(|still| Flag::new("still-camera", still));
        let numbers = self.numbers.iter().map(flag);
        let listed = |levels: &[f32]| -> String {
            let levels: Vec<_> = levels.iter().map(f32::to_string).collect();
            levels.join(",")
        };
        let tones = self.tone_levels.iter();
        let tones = tones.map(|levels| Flag::new("tone-levels", listed(levels)));
        let lines = self.line_levels.iter();
        let lines = lines.map(|levels| Flag::new("line-levels", listed(levels)));
        let shadows = self.shadows().map(|(flag, is)| Flag::new(flag, is));
        numbers
            .chain(shadows)
            .chain(tones)
            .chain(lines)
            .chain(conventions)
            .chain(camera)
            .collect()
    }

    /// The numbers chosen, by the names of their settings.
    #[cfg(feature = "view")]
    pub(crate) fn numbers(&self) -> Vec<(String, String)> {
        let numbers = self.numbers.iter().filter(|(_, term, _)| term.is_empty());
        numbers
            .map(|(name, _, number)| (name.to_string(), number.to_string()))
            .collect()
    }

    /// The choices in words: `curvature gain 2.140, white level 0.8812`.
    pub(crate) fn in_words(&self) -> String {
        let changes =
            |(name, _, number): &&(&str, &str, f32)| *name != "exposure" || *number != 0.0;
        let words = self
            .numbers
            .iter()
            .filter(changes)
            .map(|(name, term, number)| {
                let name = name.trim_start_matches("term-").replace('-', " ");
                let space = if term.is_empty() { "" } else { " " };
                let digits = match &name[..] {
                    "exposure" => 2,
                    "curvature gain" => 3,
                    _ => 4,
                };
                format!("{name}{space}{term} {number:.digits$}")
            });
        let light = self.light.iter().map(LightChoice::to_string);
        let shadows = self.shadows().map(|(name, is)| format!("{name} {is}"));
        shadows
            .chain(words)
            .chain(light)
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// The flags of shadows, and whether they are on.
    fn shadows(&self) -> impl Iterator<Item = (&'static str, &'static str)> + '_ {
        let cast = SHADOWS.into_iter().zip(self.shadows);
        cast.filter_map(|(flag, cast)| Some((flag, if cast? { "on" } else { "off" })))
    }
}

/// The flags of shadows of lamps, and of light from all around.
const SHADOWS: [&str; 2] = ["shadows", "sky-shadows"];

/// The numbers present in `single`, and the white levels of kinds of light.
fn numbers(
    single: &[(&'static str, Option<f32>)],
    terms: &[(&'static str, f32)],
) -> Vec<(&'static str, &'static str, f32)> {
    let single = single.iter();
    let single = single.filter_map(|&(flag, number)| Some((flag, "", number?)));
    let terms = terms.iter();
    let terms = terms.map(|&(term, level)| ("term-white-level", term, level));
    single.chain(terms).collect()
}

/// The recovered camera of a frame, and the median distance of its surface (1 without depth).
fn recovered(loaded: &Loaded) -> Option<(KnownCamera, f64)> {
    let known = loaded
        .known_camera()
        .filter(|_| loaded.camera_is_recovered)?;
    let middle = loaded.distance.or_else(|| distance(&loaded.frame));
    Some((known, middle.unwrap_or(1.0).into()))
}

/// Finds out what is chosen by the depth of a frame, before a run that consumes it.
pub(crate) fn look_at_depth(loaded: &mut Loaded) {
    if loaded.camera_is_recovered {
        loaded.distance = distance(&loaded.frame);
    }
}

/// The median distance of a surface; `None` without depth.
fn distance(frame: &Frame) -> Option<f32> {
    let depth = frame.depth.as_ref()?;
    let sampled = frame.mask.sample(WANTED_DISTANCES);
    let distances = sampled.map(|(x, y)| depth.at(x, y));
    let mut distances: Vec<f32> = distances.filter(|&distance| distance > 0.0).collect();
    quantile(&mut distances, 0.5, f32::total_cmp)
}

/// `None` for a frame without a surface: it says nothing about its layers.
fn conventions_of(loaded: &Loaded) -> Option<Conventions> {
    let shows_surface = loaded.frame.mask.count() > 0;
    shows_surface.then_some(loaded.conventions)
}

/// The most frequent of `all`; the first of equals.
fn most_frequent(all: impl Iterator<Item = Conventions>) -> Option<Conventions> {
    let mut counts: Vec<(Conventions, usize)> = Vec::new();
    for one in all {
        match counts.iter_mut().find(|(known, _)| *known == one) {
            Some((_, count)) => *count += 1,
            None => counts.push((one, 1)),
        }
    }
    let best = counts.iter().rev().max_by_key(|(_, count)| *count);
    best.map(|(conventions, _)| *conventions)
}

/// The median of each level over several pictures.
fn median<const COUNT: usize>(each: impl Iterator<Item = [f32; COUNT]>) -> Option<[f32; COUNT]> {
    let each: Vec<_> = each.collect();
    let middle = |i: usize| {
        let mut levels: Vec<f32> = each.iter().map(|levels| levels[i]).collect();
        quantile(&mut levels, 0.5, f32::total_cmp).unwrap_or_default()
    };
    (!each.is_empty()).then(|| std::array::from_fn(middle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_frames_the_median_is_chosen() {
        let frame = |gain, white| Chosen {
            numbers: vec![
                ("curvature-gain", "", gain),
                ("term-white-level", "diffuse", white),
            ],
            ..Chosen::default()
        };
        // One frame is a flash, one is dark.
        let all = Chosen::of_several(&[frame(2.0, 0.5), frame(9.0, 70.0), frame(2.5, 0.01)]);
        assert_eq!(all, frame(2.5, 0.5));
        let words: Vec<_> = all.flags().iter().map(Flag::word).collect();
        assert_eq!(
            words,
            ["--curvature-gain=2.5", "--term-white-level=diffuse=0.5"]
        );
        assert_eq!(
            all.in_words(),
            "curvature gain 2.500, white level diffuse 0.5000"
        );
        assert_eq!(Chosen::of_several(&[]), Chosen::default());
    }
}
