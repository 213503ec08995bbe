//! What all frames of a command share: its light, textures and engine, and what a frame leaves to the next.

use super::job::Job;
use super::motion::Steps;
use crate::engine::{Engine, PlanInputs};
use crate::error::Result;
use crate::frame::{Frame, SpecularScene, Surroundings};
use crate::io::Loaded;
use crate::light::lights::Illumination;
use crate::line::texture_coordinates::cpu::{SequenceInputs, TextureCoordinates};
use crate::line::tonal_art_map::TonalArtMap;
use crate::plan::outcome::Outcome;
use crate::work::source::FrameSource;
use crate::work::{FrameWork, light_of};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Inputs and state shared by all frames.
pub(super) struct Kit {
    pub(super) engine: Engine,
    pub(super) light: Illumination,
    pub(super) art_map: Option<TonalArtMap>,
    /// What there is to say of the light.
    pub(super) warning: Option<String>,
    /// The surroundings of a frame before, and their file.
    surroundings: Mutex<Option<(PathBuf, Arc<Surroundings>)>>,
    course: Mutex<CarriedState>,
}

/// State carried over from the frame before.
struct CarriedState {
    steps: Steps,
    /// Where the texture of strokes lay.
    coordinates: Option<TextureCoordinates>,
}

impl Kit {
    pub(super) fn of(work: &dyn FrameWork) -> Result<Self> {
        let (light, warning) = light_of(work)?;
        let convention = work.motion().and_then(|motion| motion.convention());
        Ok(Self {
            art_map: work.art_map()?,
            engine: work.args().run.compute.backend.engine()?,
            light,
            warning,
            surroundings: Mutex::default(),
            course: Mutex::new(CarriedState {
                steps: Steps::new(convention),
                coordinates: None,
            }),
        })
    }

    /// What mirrors and lenses show in a frame.
    pub(super) fn scene(
        &self,
        work: &dyn FrameWork,
        source: &FrameSource,
        loaded: &mut Loaded,
    ) -> Result<Option<SpecularScene>> {
        let named = source.specular.as_ref();
        let Some(path) = named.and_then(|(inputs, _)| inputs.surroundings.clone()) else {
            return source.scene(work, loaded, None);
        };
        let mut kept = self
            .surroundings
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let known = kept.take().filter(|(known, _)| *known == path);
        let scene = source.scene(work, loaded, known.map(|(_, surroundings)| surroundings))?;
        let surroundings = scene.as_ref().and_then(|scene| scene.surroundings.clone());
        *kept = surroundings.map(|surroundings| (path, surroundings));
        Ok(scene)
    }

    /// Draws a frame of a sequence in its turn, with strokes that move on from the frame before; `small` is the frame as it
    /// was if it has been enlarged.
    pub(super) fn drawn_on(
        &self,
        job: &Job,
        loaded: &mut Loaded,
        small: Option<&Frame>,
        inputs: PlanInputs,
        draw: impl FnOnce(&mut Frame, PlanInputs) -> Result<Outcome>,
    ) -> Result<Outcome> {
        job.in_turn(|| {
            let mut course = self.course.lock().unwrap_or_else(PoisonError::into_inner);
            let number = job.frame.unwrap_or_default();
            let (layers, times) = (loaded.motion.take(), loaded.enlarged);
            let frame = small.unwrap_or(&loaded.frame);
            let say = |text: &str| job.warn(text);
            let motion = course.steps.motion(number, frame, layers, say);
            let motion = motion.map(|motion| match small {
                Some(small) => small.enlarged_motion(&motion, times),
                None => motion,
            });
            let sequence = SequenceInputs {
                before: course.coordinates.as_ref(),
                motion: motion.as_ref(),
            };
            let inputs = PlanInputs {
                sequence: Some(sequence),
                ..inputs
            };
            let mut outcome = draw(&mut loaded.frame, inputs)?;
            let drawing = outcome.drawing.as_mut().expect("a drawing was planned");
            course.coordinates = drawing.coordinates.take();
            Ok(outcome)
        })
    }
}
