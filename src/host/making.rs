//! What a command makes of a scene.

use super::made::Made;
use super::scene::{File, LoadedScene};
use super::work::Work;
use crate::command::chosen::Chosen;
use crate::engine::{Engine, Run};
use crate::error::Result;
use crate::frame::{Frame, Mask, Plane};
use crate::io::picture::pixels;
use crate::io::wrapped;
use crate::work::making::Making;
use crate::work::source::FrameSource;
use std::sync::Arc;

impl Work {
    /// Reads `file` as far as the command needs it; `held` is returned if the same was read for it.
    ///
    /// # Errors
    /// As [`crate::io::load`].
    pub fn load(&self, file: &File, held: Option<Arc<LoadedScene>>) -> Result<Arc<LoadedScene>> {
        let command = self.task.command.of_frame(file.number);
        let source = FrameSource::of(command.work(), &self.light, file.number.is_some())?;
        if let Some(held) = held.filter(|held| held.source.as_ref() == Some(&source)) {
            return Ok(held);
        }
        let (loaded, specular) = source.load(command.work())?;
        Ok(Arc::new(LoadedScene {
            specular,
            chosen: Chosen::in_loading(&loaded),
            primaries: loaded.chromaticities,
            findings: loaded.findings,
            warnings: loaded.warnings,
            source: Some(source),
            ..LoadedScene::of_frame(loaded.frame)
        }))
    }

    /// What the command makes of a scene.
    ///
    /// # Errors
    /// As [`Engine::run`]; [`Error::BadParameter`] for settings that the frame does not allow;
    /// [`Error::Arguments`](crate::Error::Arguments) for settings that name layers, which scenes of arrays have none of.
    pub fn run(&self, engine: &Engine, scene: &LoadedScene, run: &Run) -> Result<Made> {
        if scene.source.is_none() {
            self.refuse_names()?;
        }
        let fitted = self.fitted(scene)?;
        let frame = fitted.as_ref().unwrap_or(&scene.frame);
        let mut made = self.making(scene, frame).run(engine, run)?;
        let mut warnings = [&scene.warnings[..], &self.warnings].concat();
        warnings.extend(self.work().warnings_on(frame));
        warnings.append(&mut made.warnings);
        Ok(Made {
            command: self.task.recipe.command().into(),
            chosen: scene.chosen.clone().running(&made.outcome),
            warnings,
            svg: made.svg.take(),
            made,
        })
    }

    fn making<'a>(&'a self, scene: &'a LoadedScene, frame: &'a Frame) -> Making<'a> {
        Making {
            work: self.work(),
            light: &self.light,
            frame,
            specular: scene.specular.as_ref(),
            is_in_sequence: (scene.source.as_ref()).is_some_and(|source| source.is_in_sequence),
        }
    }

    /// A picture or a drawing as a PNG of 8 bits would hold it: columns and rows, and red, green, blue and alpha, not
    /// premultiplied; `None` for other commands. An exposure that is chosen for it is one of the choices from then on.
    pub fn shown(
        &self,
        scene: &LoadedScene,
        made: &mut Made,
    ) -> Option<([usize; 2], Vec<[u8; 4]>)> {
        let making = self.making(scene, &scene.frame);
        let (shown, exposure) = making.shown(&made.made, scene.primaries)?;
        let picture = shown.picture();
        let size = [picture.color.r.width(), picture.color.r.height()];
        let shown = pixels(&picture);
        made.chosen = made.chosen.clone().exposed(exposure);
        Some((size, shown))
    }

    /// The frame of a scene of arrays, with its mask and its borders as the command has them; `None` where it is as it
    /// is, as all frames of files are.
    fn fitted(&self, scene: &LoadedScene) -> Result<Option<Frame>> {
        if scene.source.is_some() {
            return Ok(None);
        }
        let wraps = wrapped(&scene.frame.normal, self.inputs().wrap);
        if scene.mask.is_none() && wraps == scene.frame.wraps {
            return Ok(None);
        }
        let mut frame = scene.frame.clone();
        frame.wraps = wraps;
        let needs = self.work().reading(&self.light)?.1;
        match (&scene.mask, needs.strength) {
            (Some(given), true) => frame.strength = Some(given.clone()),
            (Some(given), false) => {
                let (width, height) = (given.width(), given.height());
                let is_in = |x: usize, y: usize| frame.mask.at(x, y) && given.row(y)[x] > 0.5;
                frame.mask = Mask::new(Plane::from_fn(width, height, is_in));
            }
            (None, _) => {}
        }
        Ok(Some(frame))
    }
}
