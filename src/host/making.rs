//! What a command makes of a scene: the steps of the command line between reading and writing.

use super::made::Made;
use super::scene::{File, Scene};
use super::work::{LINES, Work};
use crate::command::chosen::Chosen;
use crate::command::commands::Command;
use crate::command::enhance::{self, idle_magnitudes};
use crate::command::hatch::{Drawn, is_svg, page};
use crate::command::line_args::HatchArgs;
use crate::command::map::{MapArgs, Samples};
use crate::command::reading::{Source, plan_of, work_of};
use crate::command::relight::lit;
use crate::engine::outcome::Outcome;
use crate::engine::{Engine, Inputs, Run};
use crate::error::Result;
use crate::frame::{Frame, Mask, Plane};
use crate::io::picture::pixels;
use crate::io::svg::write_svg;
use crate::io::wrapped;
use std::path::Path;
use std::sync::Arc;

impl Work {
    /// Reads `file` as far as the command needs it; `held` is returned if the same was read for it.
    ///
    /// # Errors
    /// As [`crate::io::load`].
    pub fn load(&self, file: &File, held: Option<Arc<Scene>>) -> Result<Arc<Scene>> {
        let source = Source::of(&self.command, &self.light, file.number)?;
        if let Some(held) = held.filter(|held| held.source.as_ref() == Some(&source)) {
            return Ok(held);
        }
        let (loaded, specular) = source.load(&self.command)?;
        Ok(Arc::new(Scene {
            specular,
            chosen: Chosen::in_loading(&loaded),
            primaries: loaded.chromaticities,
            findings: loaded.findings,
            warnings: loaded.warnings,
            source: Some(source),
            ..Scene::of_frame(loaded.frame)
        }))
    }

    /// What the command makes of a scene.
    ///
    /// # Errors
    /// As [`Engine::run`]; [`Error::BadParameter`] for settings that the frame does not allow;
    /// [`Error::Arguments`](crate::Error::Arguments) for settings that name layers, which scenes of arrays have none of.
    pub fn run(&self, engine: &Engine, scene: &Scene, run: &Run) -> Result<Made> {
        if scene.source.is_none() {
            self.refuse_names()?;
        }
        let fitted = self.fitted(scene);
        let frame = fitted.as_ref().unwrap_or(&scene.frame);
        let made = match &self.command {
            Command::Map(args) => maps(args, engine, frame, run)?,
            Command::Hatch(args) => self.draw(args, engine, scene, frame, run)?,
            _ => self.picture(engine, scene, frame, run)?,
        };
        let mut warnings = self.warnings.clone();
        if let Command::Enhance(args) = &self.command {
            let scaling = &args.work.flags.params.scaling;
            warnings.extend(idle_magnitudes(scaling, &frame.light));
        }
        Ok(Made {
            command: self.recipe.command().into(),
            chosen: scene.chosen.clone().running(&made.outcome),
            warnings,
            ..made
        })
    }

    /// Layers or a picture.
    fn picture(&self, engine: &Engine, scene: &Scene, frame: &Frame, run: &Run) -> Result<Made> {
        let (plan, light) = plan_of(&self.command, frame, self.light.clone(), drawn(1.0, scene))?;
        let inputs = Inputs {
            specular: scene.specular.as_ref(),
            ..Inputs::lit_by(&light)
        };
        let mut outcome = engine.execute(&plan, frame, inputs, run)?;
        work_of(&self.command).mix(frame, &mut outcome);
        if let Command::Enhance(_) = self.command {
            // A plan with nothing to do leaves the picture as it is.
            outcome.color = outcome.color.take().or_else(|| frame.color.clone());
        }
        Ok(Made {
            outcome,
            ..Made::default()
        })
    }

    /// A picture or a drawing as a PNG of 8 bits would hold it: columns and rows, and red, green, blue and alpha, not
    /// premultiplied; `None` for other commands. An exposure that is chosen for it is one of the choices from then on.
    pub fn shown(&self, scene: &Scene, made: &mut Made) -> Option<([usize; 2], Vec<[u8; 4]>)> {
        let (work, frame) = (work_of(&self.command), &scene.frame);
        let chosen = made.chosen.clone();
        let color = made.picture()?;
        let picture = match &self.command {
            Command::Enhance(_) => enhance::made(frame, &made.outcome),
            Command::Relight(_) => lit(frame, &made.outcome, work.flags.params.mix),
            Command::Hatch(args) => {
                let page = args.on_a_page(color, frame.pixel_aspect);
                return Some(([color.r.width(), color.r.height()], pixels(&page)));
            }
            _ => return None,
        };
        let exposure = picture.exposure(work, &frame.mask);
        let displayed = work.displayed(frame, scene.primaries, picture, exposure);
        let size = [color.r.width(), color.r.height()];
        let shown = pixels(&displayed.picture());
        made.chosen = chosen.exposed(exposure);
        Some((size, shown))
    }

    /// The frame of a scene of arrays, with its mask and its borders as the command has them; `None` where it is as it
    /// is, as all frames of files are.
    fn fitted(&self, scene: &Scene) -> Option<Frame> {
        if scene.source.is_some() {
            return None;
        }
        let wraps = wrapped(&scene.frame.normal, self.inputs().wrap);
        if scene.mask.is_none() && wraps == scene.frame.wraps {
            return None;
        }
        let mut frame = scene.frame.clone();
        frame.wraps = wraps;
        let changes_picture = match &self.command {
            Command::Hatch(args) => !is_svg(&args.relight.work),
            Command::Enhance(_) | Command::Relight(_) => true,
            _ => false,
        };
        match (&scene.mask, changes_picture) {
            (Some(given), true) => frame.strength = Some(given.clone()),
            (Some(given), false) => {
                let (width, height) = (given.width(), given.height());
                let is_in = |x: usize, y: usize| frame.mask.at(x, y) && given.row(y)[x] > 0.5;
                frame.mask = Mask::new(Plane::from_fn(width, height, is_in));
            }
            (None, _) => {}
        }
        Some(frame)
    }

    fn draw(
        &self,
        args: &HatchArgs,
        engine: &Engine,
        scene: &Scene,
        frame: &Frame,
        run: &Run,
    ) -> Result<Made> {
        let looks = args.looks()?;
        let art_map = args.art_map(&looks)?;
        let times = args.times(frame)?;
        let is_specular = scene.specular.is_some();
        if times != 1.0 {
            args.refuse_enlarged(frame, times, is_specular)?;
        }
        let enlarged = (times != 1.0).then(|| run.enlarged(frame, times));
        let enlarged = enlarged.transpose()?;
        let frame = enlarged.as_ref().unwrap_or(frame);
        let drawn = drawn(times, scene);
        let (mut plan, light) = plan_of(&self.command, frame, self.light.clone(), drawn)?;
        let in_lines = is_svg(&args.relight.work);
        (plan.inks_strokes, plan.keeps_tone) = (!in_lines, !in_lines);
        let inputs = Inputs {
            specular: scene.specular.as_ref(),
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
}

fn maps(args: &MapArgs, engine: &Engine, frame: &Frame, run: &Run) -> Result<Made> {
    let (mut samples, mut outcome) = (Samples::default(), Outcome::default());
    for pass in args.passes(frame)? {
        let mut of_pass = engine.execute(&pass.plan, frame, Inputs::default(), run)?;
        outcome.gain = outcome.gain.or(of_pass.gain);
        samples.take(&pass, &mut of_pass);
        engine.recycle(of_pass);
    }
    let parts = args.parts().into_iter();
    let maps = parts.map(|part| {
        let made = args.made(&part, &samples, &frame.mask);
        (part.name, made.plane)
    });
    Ok(Made {
        maps: maps.collect(),
        outcome,
        ..Made::default()
    })
}

fn drawn(times: f64, scene: &Scene) -> Drawn {
    Drawn {
        times,
        is_in_sequence: (scene.source.as_ref()).is_some_and(|source| source.is_in_sequence),
        moves: false,
        is_specular: scene.specular.is_some(),
    }
}
