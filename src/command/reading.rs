//! What a command reads, and its plan for a frame: for programs that keep frames in memory.

use super::args::WorkArgs;
use super::commands::Command;
use super::enhance::dark_rims;
use super::hatch::Drawn;
use super::relight::{needs, specular_scene};
use super::relight_args::RelightArgs;
use crate::engine::cpu::strips::StripChoice;
use crate::error::Result;
use crate::frame::{Frame, SpecularScene};
use crate::io::inputs::Inputs;
use crate::io::{self, Loaded, Needs, SpecularInputs, load_specular};
use crate::light::lights::Illumination;
use crate::params::{Material, Params};
use crate::plan::{LightKinds, Plan};

/// A command that makes something of a frame.
pub(crate) const A_COMMAND: &str = "it is one of the commands of recipes";

/// Everything that is read for a frame of a command.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Source {
    pub(crate) inputs: Inputs,
    pub(crate) needs: Needs,
    /// Whether it belongs to a sequence.
    pub(crate) is_in_sequence: bool,
    pub(crate) specular: Option<(SpecularInputs, Material)>,
}

impl Source {
    /// What `command` reads of a single picture, or of a frame of a sequence, in this light.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] for settings that contradict each other.
    pub(crate) fn of(command: &Command, light: &Illumination, frame: Option<i32>) -> Result<Self> {
        let specular = |args: &RelightArgs| {
            let inputs = args.specular.of_frame(frame).inputs();
            let material = args.params().material.material;
            (!inputs.is_empty()).then_some((inputs, material))
        };
        let ((inputs, needs), specular) = match command {
            Command::Shape(args) => (args.work.reading(args.work.goal()?, frame), None),
            Command::Map(args) | Command::Normals(args) => (args.reading(frame), None),
            Command::Enhance(args) => (args.reading(frame), None),
            Command::Relight(args) => {
                let needs = needs(&args.params(), light);
                ((args.inputs(frame), needs), specular(args))
            }
            Command::Hatch(args) => {
                let reading = args.reading(&args.looks()?, light, frame);
                (reading, specular(&args.relight))
            }
            _ => unreachable!("{A_COMMAND}"),
        };
        Ok(Self {
            inputs,
            needs,
            is_in_sequence: frame.is_some(),
            specular,
        })
    }

    /// The first setting that names a layer or a file, or tells how these are read, but for conventions of normals and
    /// depth; `None` if there is none.
    #[cfg(feature = "host")]
    pub(crate) fn named(&self) -> Option<&'static str> {
        let Self {
            inputs, specular, ..
        } = self;
        let light = inputs.light.clone().unwrap_or_default();
        let named = [
            ("view", inputs.view.is_some()),
            ("layer", inputs.layer.is_some()),
            ("normal", inputs.normal.is_some()),
            ("color", inputs.color.is_some()),
            ("depth", inputs.depth.is_some()),
            ("position", inputs.position.is_some()),
            ("occlusion", inputs.occlusion.is_some()),
            ("importance", inputs.importance.is_some()),
            ("mask", inputs.mask.is_some()),
            ("coverage", inputs.coverage.is_some()),
            ("albedo", inputs.albedo.is_some() || light.albedo.is_some()),
            ("object", !inputs.objects.is_empty()),
            ("cryptomatte", inputs.cryptomatte.is_some()),
            ("object-angle", !inputs.object_angles.is_empty()),
            ("camera", inputs.camera.is_some()),
            ("still-camera", inputs.known_camera.is_some()),
            ("colorspace", inputs.colorspace.is_some()),
            ("diffuse", light.diffuse.is_some()),
            ("specular", light.specular.is_some()),
            ("light-group", !light.groups.is_empty()),
            ("what mirrors and lenses show", specular.is_some()),
        ];
        let found = named.into_iter().find(|(_, is_given)| *is_given);
        found.map(|(setting, _)| setting)
    }

    /// Reads it, and what mirrors and lenses show.
    ///
    /// # Errors
    /// As [`io::load`] and [`load_specular`]; [`crate::Error::Unsupported`] beyond the memory limit.
    pub(crate) fn load(&self, command: &Command) -> Result<(Loaded, Option<SpecularScene>)> {
        let picture = &self.inputs.picture;
        match command {
            Command::Hatch(args) => args.refuse_too_large(picture)?,
            _ => work_of(command).refuse_too_large(picture)?,
        }
        let mut loaded = io::load(&self.inputs, self.needs)?;
        let scene = match (&self.specular, command) {
            (Some((inputs, _)), Command::Relight(args)) => {
                Some(specular_scene(inputs, &args.params(), &mut loaded)?)
            }
            (Some((inputs, _)), _) => {
                let mut scene = load_specular(inputs, &loaded, None)?;
                scene.fill_from_behind(&mut loaded.frame);
                Some(scene)
            }
            (None, _) => None,
        };
        Ok((loaded, scene))
    }
}

/// The plan of a command other than `map`, which has several, and the light of the run. `drawn` tells how a drawing is
/// made, and whether mirrors or lenses are traced.
///
/// # Errors
/// As [`Plan::at_scales`], [`Plan::relight`] and [`Plan::hatch`].
pub(crate) fn plan_of(
    command: &Command,
    frame: &Frame,
    light: Illumination,
    drawn: Drawn,
) -> Result<(Plan, Illumination)> {
    let anew = StripChoice::default();
    Ok(match command {
        Command::Shape(args) => (args.work.plan(args.work.goal()?, frame, &anew)?, light),
        Command::Enhance(args) => (args.plan(frame, &anew)?, light),
        Command::Relight(args) => {
            let kinds = LightKinds::in_light(&light);
            (args.plan(frame, kinds, drawn.is_specular, &anew)?, light)
        }
        Command::Hatch(args) => args.plan(&args.looks()?, light, frame, drawn)?,
        _ => unreachable!("{A_COMMAND}"),
    })
}

/// Warnings about the settings of a command, whatever they are applied to.
pub(crate) fn setting_warnings(command: &Command) -> Vec<String> {
    let scaling = &work_of(command).flags.params.scaling;
    match command {
        Command::Enhance(_) => dark_rims(scaling),
        Command::Relight(args) => {
            let scales = args.params().method.scales();
            let rims = scales.then(|| dark_rims(scaling)).into_iter().flatten();
            rims.chain(args.past_the_zenith()).collect()
        }
        _ => Vec::new(),
    }
}

/// The arguments that all commands share.
pub(crate) fn work_of(command: &Command) -> &WorkArgs {
    match command {
        Command::Shape(args) => &args.work,
        Command::Enhance(args) => &args.work,
        Command::Relight(args) => &args.work,
        Command::Hatch(args) => &args.relight.work,
        Command::Map(args) | Command::Normals(args) => &args.work,
        _ => unreachable!("{A_COMMAND}"),
    }
}

/// The parameters that all commands share, to be changed.
pub(crate) fn params_of(command: &mut Command) -> &mut Params {
    let work = match command {
        Command::Shape(args) => &mut args.work,
        Command::Enhance(args) => &mut args.work,
        Command::Relight(args) => &mut args.work,
        Command::Hatch(args) => &mut args.relight.work,
        Command::Map(args) | Command::Normals(args) => &mut args.work,
        _ => unreachable!("{A_COMMAND}"),
    };
    &mut work.flags.params
}

/// The arguments of light, of commands that have them.
pub(crate) fn light_of(command: &Command) -> Option<&RelightArgs> {
    match command {
        Command::Relight(args) => Some(args),
        Command::Hatch(args) => Some(&args.relight),
        _ => None,
    }
}
