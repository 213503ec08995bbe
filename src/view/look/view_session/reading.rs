//! Inputs of a look: files, read again only when the names change.

use super::{OpenFrame, ShownFile, ViewSession};
use crate::command::commands::Command;
use crate::engine::Session;
use crate::error::Result;
use crate::io::Loaded;
use crate::light::lights::Illumination;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::StrokeScale;
use crate::work::source::FrameSource;
use crate::work::{FrameWork, illumination, lights};
use std::path::PathBuf;

/// An environment and its turn, lit spheres, and a folder of strokes with their scale.
type LookNames = (
    Option<PathBuf>,
    f32,
    Vec<PathBuf>,
    Option<(PathBuf, StrokeScale)>,
);

/// Light and strokes read from files.
#[derive(Default)]
pub(super) struct LookFiles {
    named: LookNames,
    light: Illumination,
    pub(super) art_map: Option<TonalArtMap>,
}

impl ViewSession {
    /// Reads the command's inputs unless they are already open, here or `beside`.
    pub(super) fn read(
        &mut self,
        command: &Command,
        reading: &ShownFile,
        beside: Option<&ViewSession>,
    ) -> Result<()> {
        let command = command.of_frame(reading.frame);
        let work = command.work();
        work.args().flags.validate()?;
        work.check()?;
        let (light, _) = self.illumination(work)?;
        let source = FrameSource::of(work, &light, reading.frame.is_some())?;
        if self.sitter.as_ref().is_some_and(|s| s.source == source) {
            return Ok(());
        }
        // Frees the last frame before reading the next one.
        self.sitter = None;
        let held = beside.and_then(|beside| beside.sitter.as_ref());
        let held = held.filter(|held| held.source == source && held.scene.is_none());
        let (loaded, scene) = match (held, self.longest) {
            (Some(held), Some(longest)) => (small(held.loaded(), longest), None),
            (None, Some(longest)) => {
                let (loaded, scene) = source.load(work)?;
                (small(&loaded, longest), scene)
            }
            (_, None) => source.load(work)?,
        };
        let whole = Session::new(self.engine.clone(), loaded);
        self.sitter = Some(OpenFrame {
            source,
            scene,
            sessions: [(1, whole)].into(),
        });
        Ok(())
    }

    /// The light of a command, and what is to be said of it; files of light and strokes are read once.
    pub(super) fn illumination(
        &mut self,
        work: &dyn FrameWork,
    ) -> Result<(Illumination, Option<String>)> {
        let Some(args) = work.light() else {
            return Ok((Illumination::default(), None));
        };
        let (params, flags) = (&args.work.flags.params, &args.light);
        let scale = params.line.strokes.scale;
        let named = (
            flags.environment.clone(),
            params.environment_rotate_deg,
            flags.lit_sphere.clone(),
            work.folder().map(|folder| (folder.to_path_buf(), scale)),
        );
        if self.around.named != named {
            let (light, art_map) = (illumination(args)?, work.art_map()?);
            self.around = LookFiles {
                named,
                light,
                art_map,
            };
        }
        let mut light = Illumination {
            environment: self.around.light.environment.clone(),
            lit_spheres: self.around.light.lit_spheres.clone(),
            ..lights(args)?
        };
        let said = work.add_lamp(&mut light);
        Ok((light, said))
    }
}

/// A frame reduced to sides of at most `longest` pixels.
fn small(loaded: &Loaded, longest: usize) -> Loaded {
    let mask = &loaded.frame.mask;
    let longer = mask.width().max(mask.height());
    loaded.reduced(longer.div_ceil(longest).max(1))
}
