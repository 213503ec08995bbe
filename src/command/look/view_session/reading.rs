//! Inputs of a look: files, read again only when the names change.

use super::{Held, OpenFrame, Reading, ViewSession};
use crate::command::commands::Command;
use crate::command::hatch;
use crate::command::line_args::HatchArgs;
use crate::command::memory::MaxMemory;
use crate::command::reading::{Source, light_of, work_of};
use crate::command::relight;
use crate::engine::Session;
use crate::error::Result;
use crate::io::Loaded;
use crate::light::environment::Environment;
use crate::light::lights::Illumination;
use crate::light::lit_sphere::LitSphere;
use std::path::PathBuf;
use std::sync::Arc;

/// Light read from files, and their names.
#[derive(Default)]
pub(super) struct SurroundingFiles {
    files: (Option<PathBuf>, f32, Vec<PathBuf>),
    environment: Option<Arc<Environment>>,
    lit_spheres: Vec<LitSphere>,
}

impl ViewSession {
    /// Reads the command's inputs unless they are already open, here or `beside`.
    pub(super) fn read(
        &mut self,
        command: &Command,
        reading: &Reading,
        beside: Option<&ViewSession>,
    ) -> Result<()> {
        let work = work_of(command);
        work.flags.validate()?;
        work.flags.refuse_more_scales()?;
        let (light, _) = self.illumination(command)?;
        let source = Source::of(command, &light, reading.frame)?;
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
                let (loaded, scene) = source.load(command)?;
                (small(&loaded, longest), scene)
            }
            (_, None) => source.load(command)?,
        };
        let whole = Session::new(self.engine.clone(), Held::Whole(Box::new(loaded)));
        self.sitter = Some(OpenFrame {
            source,
            scene,
            sessions: [(1, whole)].into(),
        });
        Ok(())
    }

    /// The light of a command, and what is to be said of it; files are read once.
    pub(super) fn illumination(
        &mut self,
        command: &Command,
    ) -> Result<(Illumination, Option<String>)> {
        let Some(args) = light_of(command) else {
            return Ok((Illumination::default(), None));
        };
        let files = (
            args.light.environment.clone(),
            args.work.flags.params.environment_rotate_deg,
            args.light.lit_sphere.clone(),
        );
        if self.around.files != files {
            self.around = SurroundingFiles {
                environment: relight::environment(args, MaxMemory::Auto.for_light())?,
                lit_spheres: relight::lit_spheres(&args.light, MaxMemory::Auto.for_light())?,
                files,
            };
        }
        let light = Illumination {
            environment: self.around.environment.clone(),
            lit_spheres: self.around.lit_spheres.clone(),
            ..relight::lights(args)?
        };
        Ok(match command {
            Command::Relight(args) => relight::light_or_lamp(args, light),
            // Drawings find a lamp for tones that need one.
            _ => (light, None),
        })
    }

    /// Reads the stroke texture from the given folder unless it is already loaded.
    pub(super) fn read_art_map(&mut self, args: &HatchArgs, looks: &hatch::Looks) -> Result<()> {
        let Some(folder) = args.pictures() else {
            return Ok(());
        };
        let scale = looks.line.strokes.scale;
        let is_known = self.art_map.as_ref();
        if is_known.is_some_and(|(known, at, _)| known == folder && *at == scale) {
            return Ok(());
        }
        let map = args.art_map(looks)?;
        self.art_map = map.map(|map| (folder.to_path_buf(), scale, map));
        Ok(())
    }
}

/// A frame reduced to sides of at most `longest` pixels.
fn small(loaded: &Loaded, longest: usize) -> Loaded {
    let mask = &loaded.frame.mask;
    let longer = mask.width().max(mask.height());
    loaded.reduced(longer.div_ceil(longest).max(1))
}
