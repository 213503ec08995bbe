//! Inputs of a look: files, read again only when the names change.

use super::{A_COMMAND, Held, OpenFrame, Reading, ViewSession, work_of};
use crate::command::commands::Command;
use crate::command::hatch;
use crate::command::line_args::HatchArgs;
use crate::command::memory::MaxMemory;
use crate::command::relight;
use crate::command::relight_args::RelightArgs;
use crate::engine::Session;
use crate::error::Result;
use crate::io::inputs::Inputs;
use crate::io::{self, Needs, SpecularInputs, load_specular};
use crate::light::environment::Environment;
use crate::light::lights::Illumination;
use crate::light::lit_sphere::LitSphere;
use crate::params::Material;
use crate::plan::Goal;
use std::path::PathBuf;
use std::sync::Arc;

/// Everything that is read for a picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Source {
    inputs: Inputs,
    needs: Needs,
    /// Whether it belongs to a sequence.
    pub(super) is_in_sequence: bool,
    specular: Option<(SpecularInputs, Material)>,
}

/// Light read from files, and their names.
#[derive(Default)]
pub(super) struct SurroundingFiles {
    files: (Option<PathBuf>, f32, Vec<PathBuf>),
    environment: Option<Arc<Environment>>,
    lit_spheres: Vec<LitSphere>,
}

impl ViewSession {
    /// Reads the command's inputs unless they are already open.
    pub(super) fn read(&mut self, command: &Command, reading: &Reading) -> Result<()> {
        let work = work_of(command);
        work.flags.validate()?;
        work.flags.refuse_more_scales()?;
        let source = self.source(command, reading.frame)?;
        if self.sitter.as_ref().is_some_and(|s| s.source == source) {
            return Ok(());
        }
        work.refuse_too_large(&source.inputs.picture)?;
        // Frees the last frame before reading the next one.
        self.sitter = None;
        let mut loaded = io::load(&source.inputs, source.needs)?;
        let scene = match (&source.specular, command) {
            (Some((inputs, _)), Command::Relight(args)) => {
                let scene = relight::specular_scene(inputs, &args.params(), &mut loaded)?;
                Some(scene)
            }
            (Some((inputs, _)), _) => {
                let mut scene = load_specular(inputs, &loaded, None)?;
                scene.fill_from_behind(&mut loaded.frame);
                Some(scene)
            }
            (None, _) => None,
        };
        let whole = Session::new(self.engine.clone(), Held::Whole(Box::new(loaded)));
        self.sitter = Some(OpenFrame {
            source,
            scene,
            sessions: [(1, whole)].into(),
        });
        Ok(())
    }

    fn source(&mut self, command: &Command, frame: Option<i32>) -> Result<Source> {
        let specular = |args: &RelightArgs| {
            let inputs = args.specular.of_frame(frame).inputs();
            let material = args.params().material.material;
            (!inputs.is_empty()).then_some((inputs, material))
        };
        let ((inputs, needs), specular) = match command {
            Command::Shape(args) => (args.work.reading(Goal::Display, frame), None),
            Command::Enhance(args) => (args.reading(frame), None),
            Command::Relight(args) => {
                let illumination = self.illumination(args)?;
                let foreshortening = args.work.flags.params.shape.foreshortening;
                let needs = relight::needs(&args.params(), foreshortening, &illumination);
                ((args.inputs(frame), needs), specular(args))
            }
            Command::Hatch(args) => {
                let illumination = self.illumination(&args.relight)?;
                let reading = args.reading(&args.looks()?, &illumination, frame);
                (reading, specular(&args.relight))
            }
            _ => unreachable!("{A_COMMAND}"),
        };
        Ok(Source {
            inputs,
            needs,
            is_in_sequence: frame.is_some(),
            specular,
        })
    }

    /// All light given by flags; files are read once.
    pub(super) fn illumination(&mut self, args: &RelightArgs) -> Result<Illumination> {
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
        Ok(Illumination {
            environment: self.around.environment.clone(),
            lit_spheres: self.around.lit_spheres.clone(),
            ..relight::lights(args)?
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
