//! Requests: the result wanted, its parameters, and the inputs beside the frame.

use crate::engine::inputs::Inputs;
use crate::error::Result;
use crate::frame::SpecularScene;
use crate::light::lights::Illumination;
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{LineParams, RelightParams, ScalingParams, ShapeParams, SpecularParams};
use crate::plan::{Available, Goal, Plan, Tone};

/// The result wanted, its parameters, and the inputs beside the frame: see [`Engine::run`](crate::engine::Engine::run).
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// The result wanted.
    pub goal: Goal<'a>,
    /// Shape analysis.
    pub shape: ShapeParams,
    /// Radiance scaling.
    pub scaling: ScalingParams,
    /// How specular pixels are traced, where the inputs have the scene that they show.
    pub specular: Option<SpecularParams>,
    /// The inputs beside the frame.
    pub inputs: Inputs<'a>,
}

impl<'a> Request<'a> {
    /// A result, without inputs beside the frame.
    pub fn new(goal: Goal<'a>, shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self {
            goal,
            shape,
            scaling,
            specular: None,
            inputs: Inputs::default(),
        }
    }

    /// Every layer of the descriptor.
    pub fn layers(shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self::new(Goal::LAYERS, shape, scaling)
    }

    /// The coloured curvature display of [LW] figure 6.
    pub fn display(shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self::new(Goal::Display, shape, scaling)
    }

    /// Radiance scaling of the frame's picture. If it changes nothing, the outcome has no picture.
    pub fn enhance(shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self::new(Goal::Enhance, shape, scaling)
    }

    /// New light.
    pub fn relight(
        shape: ShapeParams,
        scaling: ScalingParams,
        params: RelightParams,
        light: &'a Illumination,
    ) -> Self {
        Self::new(Goal::Relight(params), shape, scaling).lit_by(light)
    }

    /// A drawing. Tone from new light takes that of [`Request::lit_by`].
    pub fn hatch(
        shape: ShapeParams,
        scaling: ScalingParams,
        tone: Tone,
        params: LineParams,
    ) -> Self {
        Self::new(Goal::Hatch(tone, params), shape, scaling)
    }

    /// Sets the new light.
    #[must_use]
    pub fn lit_by(mut self, light: &'a Illumination) -> Self {
        self.inputs.illumination = Some(light);
        self
    }

    /// Adds the scene seen in mirrors and lenses, for relighting and drawings.
    #[must_use]
    pub fn specular(mut self, scene: &'a SpecularScene, params: SpecularParams) -> Self {
        self.specular = Some(params);
        self.inputs.specular = Some(scene);
        self
    }

    /// Sets the stroke texture, for a drawing of [`crate::params::Style::Pictures`].
    #[must_use]
    pub fn strokes(mut self, art_map: &'a TonalArtMap) -> Self {
        self.inputs.art_map = Some(art_map);
        self
    }

    /// Makes the drawing a frame of a sequence, whose strokes move with the surface.
    #[must_use]
    pub fn in_sequence(mut self, sequence: SequenceInputs<'a>) -> Self {
        self.inputs.sequence = Some(sequence);
        self
    }

    /// The plan for a frame with these inputs.
    ///
    /// # Errors
    /// Those of [`Plan::new`].
    pub fn plan(&self, available: Available) -> Result<Plan> {
        let light = self.inputs.illumination.map(Illumination::kinds);
        let available = Available {
            specular: self.specular.or(available.specular),
            moving: available.moving || self.inputs.sequence.is_some(),
            in_sequence: available.in_sequence || self.inputs.sequence.is_some(),
            new_light: light.unwrap_or(available.new_light),
            ..available
        };
        Plan::new(self.goal, available, self.shape, self.scaling)
    }
}
