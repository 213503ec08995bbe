//! What a command makes of a frame in memory: the steps of the command line between reading and writing.

use super::commands::Command;
use super::enhance;
use super::hatch::{Drawn, is_svg, page};
use super::line_args::HatchArgs;
use super::map::{MapArgs, Samples};
use super::output::MadePicture;
use super::reading::{plan_of, work_of};
use super::relight::lit;
use super::shape::display;
use crate::engine::outcome::Outcome;
use crate::engine::{Engine, Inputs, Run};
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, Plane, SpecularScene};
use crate::io::colorspace::Chromaticities;
use crate::io::picture::Picture;
use crate::io::svg::write_svg;
use crate::light::lights::Illumination;
use std::path::Path;

/// Stands for the file that a drawing in lines would go to.
pub(crate) const LINES: &str = "made.svg";

/// A command and all that it is run on.
#[derive(Clone, Copy)]
pub(crate) struct Making<'a> {
    pub(crate) command: &'a Command,
    pub(crate) light: &'a Illumination,
    pub(crate) frame: &'a Frame,
    /// The scene seen in mirrors and lenses.
    pub(crate) specular: Option<&'a SpecularScene>,
    pub(crate) is_in_sequence: bool,
}

/// What a command has made of a frame.
#[derive(Debug, Default)]
pub(crate) struct Made {
    pub(crate) outcome: Outcome,
    /// A drawing on its paper.
    pub(crate) printed: Option<ColorPlanes>,
    /// Maps by name.
    pub(crate) maps: Vec<(String, Plane)>,
    /// A drawing as the text of an SVG, if lines were asked for.
    #[cfg_attr(
        not(feature = "host"),
        expect(dead_code, reason = "hosts alone ask for lines")
    )]
    pub(crate) svg: Option<String>,
}

impl Made {
    /// The picture, scene-linear: enhanced, in new light, or a drawing on its paper.
    pub(crate) fn picture(&self) -> Option<&ColorPlanes> {
        self.printed.as_ref().or(self.outcome.color.as_ref())
    }
}

impl Making<'_> {
    /// Runs the command.
    ///
    /// # Errors
    /// As [`Engine::run`]; [`crate::Error::BadParameter`] for settings that the frame does not allow.
    pub(crate) fn run(&self, engine: &Engine, run: &Run) -> Result<Made> {
        match self.command {
            Command::Map(args) | Command::Normals(args) => maps(args, engine, self.frame, run),
            Command::Hatch(args) => self.draw(args, engine, run),
            _ => self.picture(engine, run),
        }
    }

    fn drawn(&self, times: f64) -> Drawn {
        Drawn {
            times,
            is_in_sequence: self.is_in_sequence,
            moves: false,
            is_specular: self.specular.is_some(),
        }
    }

    /// Layers or a picture.
    fn picture(&self, engine: &Engine, run: &Run) -> Result<Made> {
        let (frame, light) = (self.frame, self.light.clone());
        let (plan, light) = plan_of(self.command, frame, light, self.drawn(1.0))?;
        let inputs = Inputs {
            specular: self.specular,
            ..Inputs::lit_by(&light)
        };
        let mut outcome = engine.execute(&plan, frame, inputs, run)?;
        work_of(self.command).mix(frame, &mut outcome);
        if let Command::Enhance(_) = self.command {
            // A plan with nothing to do leaves the picture as it is.
            outcome.color = outcome.color.take().or_else(|| frame.color.clone());
        }
        Ok(Made {
            outcome,
            ..Made::default()
        })
    }

    fn draw(&self, args: &HatchArgs, engine: &Engine, run: &Run) -> Result<Made> {
        let looks = args.looks()?;
        let art_map = args.art_map(&looks)?;
        let times = args.times(self.frame)?;
        let enlarges = times != 1.0;
        if enlarges {
            args.refuse_enlarged(self.frame, times, self.specular)?;
        }
        let seen = self.specular.filter(|_| enlarges);
        let seen = seen.map(|seen| run.install(|| seen.enlarged(self.frame, times)));
        let enlarged = enlarges.then(|| run.enlarged(self.frame, times));
        let enlarged = enlarged.transpose()?;
        let frame = enlarged.as_ref().unwrap_or(self.frame);
        let drawn = self.drawn(times);
        let (mut plan, light) = plan_of(self.command, frame, self.light.clone(), drawn)?;
        let in_lines = is_svg(&args.relight.work);
        (plan.inks_strokes, plan.keeps_tone) = (!in_lines, !in_lines);
        let inputs = Inputs {
            specular: seen.as_ref().or(self.specular),
            art_map: art_map.as_ref(),
            ..Inputs::lit_by(&light)
        };
        let mut outcome = engine.execute(&plan, frame, inputs, run)?;
        let drawing = outcome.drawing.as_mut().expect("a drawing was planned");
        if in_lines {
            let mut text = Vec::new();
            let drawn = page(frame, drawing, &looks.line.strokes);
            write_svg(&mut text, Path::new(LINES), &drawn)?;
            return Ok(Made {
                svg: Some(String::from_utf8(text).expect("an SVG is text")),
                outcome,
                ..Made::default()
            });
        }
        args.mix(drawing, frame, times);
        Ok(Made {
            printed: Some(args.printed(drawing)),
            outcome,
            ..Made::default()
        })
    }

    /// Calls `then` with the picture as a PNG would hold it, and with the exposure that was chosen for it; `None` where
    /// layers were made.
    pub(crate) fn shown<T>(
        &self,
        made: &Made,
        primaries: Option<Chromaticities>,
        then: impl FnOnce(&Picture, Option<f32>) -> T,
    ) -> Option<T> {
        let (work, frame) = (work_of(self.command), self.frame);
        let color = made.picture()?;
        let picture: MadePicture = match self.command {
            Command::Enhance(_) => enhance::made(frame, &made.outcome),
            Command::Relight(_) => lit(frame, &made.outcome, work.flags.params.mix),
            Command::Hatch(args) => {
                return Some(then(&args.on_a_page(color, frame.pixel_aspect), None));
            }
            Command::Shape(_) => return Some(then(&display(&made.outcome), None)),
            _ => return None,
        };
        let exposure = picture.exposure(work, &frame.mask);
        let displayed = work.displayed(frame, primaries, picture, exposure);
        Some(then(&displayed.picture(), exposure))
    }
}

fn maps(args: &MapArgs, engine: &Engine, frame: &Frame, run: &Run) -> Result<Made> {
    let (mut samples, mut outcome) = (Samples::default(), Outcome::default());
    for pass in args.passes(frame)? {
        let mut of_pass = engine.execute(&pass.plan, frame, Inputs::default(), run)?;
        outcome.gain = outcome.gain.or(of_pass.gain);
        outcome.timings.append(&mut of_pass.timings);
        samples.take(&pass, &mut of_pass);
        engine.recycle(of_pass);
    }
    let detail = args.detail(&args.reading(None).0, frame)?;
    let detail = detail.as_ref().map(|loaded| &loaded.frame);
    let (normal, _) = args.normals(frame, detail)?;
    let mut maps = Vec::new();
    for part in args.parts() {
        let made = args.made(&part, &samples, frame, &normal)?;
        maps.extend(made.named(&part.name));
    }
    Ok(Made {
        maps,
        outcome,
        ..Made::default()
    })
}
