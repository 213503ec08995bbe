//! Requests: the result wanted, its parameters, and the inputs beside the frame.

use crate::engine::inputs::Inputs;
use crate::error::{Error, Result};
use crate::frame::SpecularScene;
use crate::light::lights::Illumination;
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{LineParams, RelightParams, ScalingParams, ShapeParams, SpecularParams};
use crate::plan::{Available, Goal, LightKinds, Plan, ToneFrom};
use crate::product::Product;

/// The result wanted, its parameters, and the inputs beside the frame: see [`Engine::run`](crate::engine::Engine::run).
#[derive(Debug, Clone)]
pub struct Request<'a> {
    kind: Kind,
    shape: ShapeParams,
    scaling: ScalingParams,
    more_px: Vec<f32>,
    named: Vec<Product>,
    specular: Option<SpecularParams>,
    inputs: Inputs<'a>,
}

/// The kind of plan that the request becomes.
#[derive(Debug, Clone)]
enum Kind {
    OfFrame(Goal),
    Relight(RelightParams, LightKinds),
    Hatch(ToneFrom, Box<LineParams>),
}

/// Source of a drawing's tone.
#[derive(Debug, Clone, Copy)]
pub enum Tone<'a> {
    /// The picture unchanged.
    Picture,
    /// The picture after radiance scaling.
    Enhanced,
    /// New light.
    Relit(RelightParams, &'a Illumination),
    /// Shape-showing tone: a key light, combined with the picture after radiance scaling, or with this new light if
    /// given; stretched over all tones from ink to paper.
    Shape(Option<(RelightParams, &'a Illumination)>),
}

impl<'a> Request<'a> {
    fn new(kind: Kind, shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self {
            kind,
            shape,
            scaling,
            more_px: Vec::new(),
            named: Vec::new(),
            specular: None,
            inputs: Inputs::default(),
        }
    }

    /// Every layer of the descriptor.
    pub fn layers(shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self::new(Kind::OfFrame(Goal::Layers), shape, scaling)
    }

    /// The coloured curvature display of [LW] figure 6.
    pub fn display(shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self::new(Kind::OfFrame(Goal::Display), shape, scaling)
    }

    /// Radiance scaling of the frame's picture. If it changes nothing, the outcome has no picture.
    pub fn enhance(shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self::new(Kind::OfFrame(Goal::Enhance), shape, scaling)
    }

    /// New light.
    pub fn relight(
        shape: ShapeParams,
        scaling: ScalingParams,
        params: RelightParams,
        light: &'a Illumination,
    ) -> Self {
        let kind = Kind::Relight(params, LightKinds::in_light(light));
        Self {
            inputs: Inputs::lit_by(light),
            ..Self::new(kind, shape, scaling)
        }
    }

    /// A drawing.
    pub fn hatch(
        shape: ShapeParams,
        scaling: ScalingParams,
        tone: Tone<'a>,
        params: LineParams,
    ) -> Self {
        let kinds = LightKinds::in_light;
        let (tone, light) = match tone {
            Tone::Picture => (ToneFrom::Picture, None),
            Tone::Enhanced => (ToneFrom::Enhanced, None),
            Tone::Relit(relight, light) => (ToneFrom::Relit(relight, kinds(light)), Some(light)),
            Tone::Shape(None) => (ToneFrom::Shape(None), None),
            Tone::Shape(Some((relight, light))) => {
                (ToneFrom::Shape(Some((relight, kinds(light)))), Some(light))
            }
        };
        let inputs = light.map_or_else(Inputs::default, Inputs::lit_by);
        Self {
            inputs,
            ..Self::new(Kind::Hatch(tone, Box::new(params)), shape, scaling)
        }
    }

    /// Adds curvature at further scales, sigmas in pixels, to [layers](Request::layers).
    #[must_use]
    pub fn scales(mut self, sigmas_px: &[f32]) -> Self {
        self.more_px = sigmas_px.to_vec();
        self
    }

    /// Adds products to [layers](Request::layers) that are made only when they are named: the height and what it misses
    /// of the normals, the sky seen over it, and bent normals.
    #[must_use]
    pub fn named(mut self, products: &[Product]) -> Self {
        self.named = products.to_vec();
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

    /// Its inputs beside the frame.
    pub fn inputs(&self) -> Inputs<'a> {
        self.inputs
    }

    /// The plan for a frame with these inputs.
    ///
    /// # Errors
    /// Those of [`Plan::at_scales`], [`Plan::relight`] and [`Plan::hatch`]; also for further scales of anything but layers.
    pub fn plan(&self, available: Available) -> Result<Plan> {
        let (shape, scaling) = (self.shape, self.scaling);
        let available = Available {
            specular: self.specular.or(available.specular),
            moving: available.moving || self.inputs.sequence.is_some(),
            in_sequence: available.in_sequence || self.inputs.sequence.is_some(),
            ..available
        };
        if !matches!(self.kind, Kind::OfFrame(Goal::Layers)) && !self.more_px.is_empty() {
            return Err(Error::BadParameter {
                name: "--scale",
                found: "names several scales, which only layers have".into(),
                remedy: "give one, or ask for layers".into(),
            });
        }
        match &self.kind {
            Kind::OfFrame(Goal::Layers) if !self.named.is_empty() => {
                let products: Vec<_> = Goal::Layers.products().chain(self.named.clone()).collect();
                Plan::of_products(&products, available, shape, scaling, &self.more_px)
            }
            Kind::OfFrame(goal) => Plan::at_scales(*goal, available, shape, scaling, &self.more_px),
            Kind::Relight(params, kinds) => {
                Plan::relight(available, shape, scaling, *params, *kinds)
            }
            Kind::Hatch(tone, params) => Plan::hatch(available, shape, scaling, *tone, **params),
        }
    }
}
