//! What a command reads: files and layers, and what mirrors and lenses show.

use super::FrameWork;
use crate::error::Result;
use crate::frame::{SpecularScene, Surroundings};
use crate::io::inputs::Inputs;
use crate::io::{self, Loaded, Needs, SpecularInputs, load_specular};
use crate::light::lights::Illumination;
use crate::params::Material;
use std::sync::Arc;

/// Everything that is read for a frame of a command.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FrameSource {
    pub(crate) inputs: Inputs,
    pub(crate) needs: Needs,
    /// Whether it belongs to a sequence.
    pub(crate) is_in_sequence: bool,
    pub(crate) specular: Option<(SpecularInputs, Material)>,
}

impl FrameSource {
    /// What `work` reads in this light.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] for settings that contradict each other.
    pub(crate) fn of(
        work: &dyn FrameWork,
        light: &Illumination,
        is_in_sequence: bool,
    ) -> Result<Self> {
        let (inputs, needs) = work.reading(light)?;
        let specular = work.light().and_then(|args| {
            let inputs = args.specular.clone();
            let material = args.params().material.material;
            (!inputs.is_empty()).then_some((inputs, material))
        });
        Ok(Self {
            inputs,
            needs,
            is_in_sequence,
            specular,
        })
    }

    /// Reads it, and what mirrors and lenses show.
    ///
    /// # Errors
    /// As [`io::load`] and [`load_specular`]; [`crate::Error::Unsupported`] beyond the memory limit.
    pub(crate) fn load(&self, work: &dyn FrameWork) -> Result<(Loaded, Option<SpecularScene>)> {
        work.refuse_too_large(&self.inputs.picture)?;
        let mut loaded = io::load(&self.inputs, self.needs)?;
        let scene = self.scene(work, &mut loaded, None)?;
        Ok((loaded, scene))
    }

    /// What mirrors and lenses show, if anything is named; what lies behind fills the frame where it is empty.
    /// Surroundings that are `known` are not read again.
    ///
    /// # Errors
    /// As [`load_specular`]; [`crate::Error::BadParameter`] for what the command cannot show.
    pub(crate) fn scene(
        &self,
        work: &dyn FrameWork,
        loaded: &mut Loaded,
        known: Option<Arc<Surroundings>>,
    ) -> Result<Option<SpecularScene>> {
        let Some((inputs, _)) = &self.specular else {
            return Ok(None);
        };
        work.check_specular(inputs)?;
        let mut scene = load_specular(inputs, loaded, known)?;
        scene.fill_from_behind(&mut loaded.frame);
        Ok(Some(scene))
    }
}
