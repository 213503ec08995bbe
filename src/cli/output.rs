//! From an outcome to the output file.

use super::args::{LayersArg, OutputArgs, RoleArgs, RunArgs, SampleArg};
use super::message;
use crate::backend::cpu::Outcome;
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::io::Loaded;
use crate::io::exr::{OutputChannel, OutputPart, OutputType, append_part, write_results};
use crate::io::output::{refuse_overwriting_input, write_atomically};
use crate::io::photo::{Picture, PictureFormat, ViewTransform, write_picture};
use crate::plan::Plan;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Name of the part that holds our results, and of the layer that holds the enhanced picture in it.
const PART: &str = "relievo";

/// What kind of file an output path stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Exr,
    Picture(PictureFormat),
}

impl Kind {
    pub(super) fn of(path: &Path) -> Result<Self> {
        let is_exr = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        match PictureFormat::of_path(path) {
            _ if is_exr => Ok(Self::Exr),
            Some(format) => Ok(Self::Picture(format)),
            None => Err(Error::BadParameter {
                name: "-o",
                found: format!("{} has no known extension", path.display()),
                remedy: "end it in .exr, .png, .jpg, .tif or .hdr".into(),
            }),
        }
    }
}

/// One run from its arguments to its messages: what `shape` and `enhance` share.
pub(super) struct Job<'a> {
    pub(super) input: &'a Path,
    pub(super) output: &'a OutputArgs,
    pub(super) run: &'a RunArgs,
    pub(super) kind: Kind,
    started: Instant,
}

impl<'a> Job<'a> {
    /// Refuses what can be refused before any work is done.
    pub(super) fn new(
        input: &'a Path,
        roles: &'a RoleArgs,
        output: &'a OutputArgs,
        run: &'a RunArgs,
    ) -> Result<Self> {
        let kind = Kind::of(&output.output)?;
        let inputs = roles.files(input);
        let inputs = inputs.iter().map(PathBuf::as_path);
        refuse_overwriting_input("-o", &output.output, inputs.clone())?;
        if let Some(timings) = &run.timings {
            refuse_overwriting_input("--timings", timings, inputs)?;
            if *timings == output.output {
                return Err(Error::BadParameter {
                    name: "--timings",
                    found: format!("{} is the output too", timings.display()),
                    remedy: "write to another file".into(),
                });
            }
        }
        if output.no_clobber && output.output.exists() {
            return Err(Error::BadParameter {
                name: "-o",
                found: format!("{} exists already", output.output.display()),
                remedy: "choose another name or leave out --no-clobber".into(),
            });
        }
        if let Some(threads) = run.threads {
            // A pool that exists already, in a program that calls this twice, keeps its size.
            let _ = rayon::ThreadPoolBuilder::new()
                .num_threads(threads.into())
                .build_global();
        }
        Ok(Self {
            input,
            output,
            run,
            kind,
            started: Instant::now(),
        })
    }

    /// Says what was found in the input, as loudly as asked for.
    pub(super) fn tell_findings(&self, loaded: &Loaded) {
        if self.run.verbose {
            for finding in &loaded.findings {
                eprintln!("{}", message::finding_line(finding));
            }
        }
        for warning in &loaded.warnings {
            message::warning(
                self.run.quiet,
                &format!("{}: {warning}", self.input.display()),
            );
        }
    }

    pub(super) fn tell_plan(&self, plan: &Plan) {
        if self.run.explain {
            let lines = plan
                .decisions()
                .iter()
                .map(|decision| format!("{decision}\n"));
            message::result(&lines.collect::<String>());
        }
    }

    /// Writes colours that go to a display file.
    pub(super) fn write_picture(
        &self,
        format: PictureFormat,
        picture: &Picture,
    ) -> Result<Duration> {
        let path = &self.output.output;
        let start = Instant::now();
        write_atomically(path, !self.output.no_clobber, |w| {
            write_picture(w, path, format, picture)
        })?;
        Ok(start.elapsed())
    }

    /// Writes planes to an EXR: beside the input's own where there are any to keep, else alone.
    pub(super) fn write_exr(
        &self,
        loaded: &Loaded,
        channels: Vec<OutputChannel>,
    ) -> Result<Duration> {
        let path = &self.output.output;
        let start = Instant::now();
        let frame = &loaded.frame;
        let part = OutputPart {
            name: PART.into(),
            data_window: frame.data_window,
            display_window: frame.display_window,
            pixel_aspect: frame.pixel_aspect,
            channels,
            attributes: vec![(
                "software".into(),
                format!("relievo {}", env!("CARGO_PKG_VERSION")),
            )],
            chromaticities: loaded.exr().and_then(|file| file.chromaticities),
        };
        let kept = loaded
            .exr()
            .filter(|_| self.output.layers == LayersArg::Keep);
        write_atomically(path, !self.output.no_clobber, |w| match kept {
            Some(input) => append_part(input, w, path, &part),
            None => write_results(w, path, &part),
        })?;
        Ok(start.elapsed())
    }

    /// The prefix of our colour channels: none in a file of our own, where they are the picture.
    pub(super) fn color_layer(&self, loaded: &Loaded) -> Option<&'static str> {
        let beside = loaded.exr().is_some() && self.output.layers == LayersArg::Keep;
        beside.then_some(PART)
    }

    /// Writes the timings and says what was done.
    pub(super) fn finish(
        &self,
        frame: &Frame,
        outcome: &Outcome,
        read: Duration,
        write: Duration,
    ) -> Result<()> {
        let total = self.started.elapsed();
        if let Some(path) = &self.run.timings {
            let text = timings_json(frame, outcome, read, write, total);
            write_atomically(path, true, |w| {
                std::io::Write::write_all(w, text.as_bytes()).map_err(Error::io(path, "write"))
            })?;
        }
        if !self.run.quiet {
            let chosen = [
                outcome
                    .gain
                    .map(|gain| format!("curvature gain {gain:.3}, ")),
                outcome
                    .white_level
                    .map(|white| format!("white level {white:.4}, ")),
            ];
            let chosen: String = chosen.into_iter().flatten().collect();
            eprintln!(
                "{}: {chosen}{:.2} s",
                self.output.output.display(),
                total.as_secs_f64()
            );
        }
        Ok(())
    }
}

fn timings_json(
    frame: &Frame,
    outcome: &Outcome,
    read: Duration,
    write: Duration,
    total: Duration,
) -> String {
    let seconds = |d: Duration| d.as_secs_f64();
    let stages = std::iter::once(("read", read))
        .chain(outcome.timings.iter().copied())
        .chain(std::iter::once(("write", write)));
    let stages: Vec<_> = stages
        .map(|(name, time)| serde_json::json!({ "stage": name, "seconds": seconds(time) }))
        .collect();
    let summary = serde_json::json!({
        "width": frame.data_window.width(),
        "height": frame.data_window.height(),
        "covered_pixels": frame.mask.count(),
        "threads": rayon::current_num_threads(),
        "stages": stages,
        "total_seconds": seconds(total),
    });
    format!("{summary:#}\n")
}

/// Colour planes as channels, with alpha where the picture has one.
pub(super) fn color_channels<'a>(
    layer: Option<&str>,
    color: &'a ColorPlanes,
    alpha: Option<&'a Plane>,
    sample_type: OutputType,
) -> Vec<OutputChannel<'a>> {
    let planes = [
        ("R", Some(&color.r)),
        ("G", Some(&color.g)),
        ("B", Some(&color.b)),
        ("A", alpha),
    ];
    let name = |component: &str| match layer {
        Some(layer) => format!("{layer}.{component}"),
        None => component.to_string(),
    };
    planes
        .into_iter()
        .filter_map(|(component, plane)| plane.map(|plane| (name(component), plane)))
        .map(|(name, plane)| OutputChannel {
            name,
            plane,
            sample_type,
        })
        .collect()
}

impl From<SampleArg> for OutputType {
    fn from(arg: SampleArg) -> Self {
        match arg {
            SampleArg::Half => Self::Half,
            SampleArg::Float => Self::Float,
        }
    }
}

/// The transform for values that are display-referred already.
pub(super) const DISPLAY_REFERRED: ViewTransform = ViewTransform::None;
