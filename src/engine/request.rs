//! Requests: the result wanted, its parameters, and the inputs beside the frame.

use crate::engine::inputs::PlanInputs;
use crate::error::Result;
use crate::frame::{Frame, SpecularScene};
use crate::light::lights::{DirectionalLight, Illumination, LAMP_DEG, LightKinds};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{
    MaterialParams, Params, RelightParams, ShapeParams, SoftThreshold, SpecularParams, ToneSource,
};
use crate::plan::{Available, Goal, Plan, Tone};
use std::borrow::Cow;

/// The result wanted, its parameters, and the inputs beside the frame: see [`Engine::run`](crate::engine::Engine::run).
///
/// The parameters are those of the command line, with the same defaults and the same effect: of the share that is mixed
/// in, of lamps that take the place of missing light, of enlarged drawings.
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// The result wanted, with its own parameters; `None` for a drawing whose tone and lines are those of the parameters.
    pub goal: Option<Goal<'a>>,
    /// All parameters; of relighting and lines those of a goal that has them count.
    pub params: Params,
    /// How specular pixels are traced, where the inputs have the scene that they show.
    pub specular: Option<SpecularParams>,
    /// Whether an enhanced picture is scaled by the occlusion of the shape, in place of a layer.
    pub computes_occlusion: bool,
    /// The inputs beside the frame.
    pub inputs: PlanInputs<'a>,
}

impl<'a> Request<'a> {
    /// A result, without inputs beside the frame.
    pub fn new(goal: Goal<'a>, params: Params) -> Self {
        Self {
            goal: Some(goal),
            params,
            specular: None,
            computes_occlusion: false,
            inputs: PlanInputs::default(),
        }
    }

    /// Every layer of the descriptor.
    pub fn layers(params: Params) -> Self {
        Self::new(Goal::LAYERS, params)
    }

    /// The coloured curvature display of [LW] figure 6.
    pub fn display(params: Params) -> Self {
        Self::new(Goal::Display, params)
    }

    /// Radiance scaling of the frame's picture. If it changes nothing, the outcome has no picture.
    pub fn enhance(params: Params) -> Self {
        Self::new(Goal::Enhance, params)
    }

    /// New light. If there is none, and no ambient light is asked for, a lamp from the upper left takes its place.
    pub fn relight(params: Params, light: &'a Illumination) -> Self {
        Self::new(Goal::Relight(params.relight), params).lit_by(light)
    }

    /// A drawing, enlarged as the parameters say. Its tone is that of [`Params::tone`], where new light is that of
    /// [`Request::lit_by`], or else a lamp.
    pub fn hatch(params: Params) -> Self {
        Self {
            goal: None,
            ..Self::layers(params)
        }
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
        let mut available = self.available(available);
        let (goal, needs_lamp) = self.resolved(&available);
        available.new_light.directional |= needs_lamp;
        let Params {
            shape,
            scaling,
            mix,
            ..
        } = self.params;
        let scaling = match goal {
            // None of the change shows: it is left out.
            Goal::Enhance if mix == 0.0 => scaling.none(),
            _ => scaling,
        };
        Plan::new(goal, available, shape, scaling)
    }

    /// The lamp that takes the place of missing light.
    pub(crate) fn lamp(&self, available: Available) -> Option<DirectionalLight> {
        let (_, needs_lamp) = self.resolved(&self.available(available));
        needs_lamp.then(|| DirectionalLight::white(LAMP_DEG))
    }

    /// The light of a frame with these inputs.
    pub(crate) fn light(&self, available: Available) -> Cow<'a, Illumination> {
        let given = self.inputs.illumination;
        let mut light = given.map_or_else(Cow::default, Cow::Borrowed);
        if let Some(lamp) = self.lamp(available) {
            light.to_mut().directional.push(lamp);
        }
        light
    }

    /// How many times as large as the frame its drawing is.
    ///
    /// # Errors
    /// As [`Params::times`].
    pub(crate) fn times(&self, frame: &Frame) -> Result<f64> {
        match self.goal {
            None => {
                let window = frame.display_window;
                let size = [window.width(), window.height()];
                self.params.times(size, frame.pixel_aspect)
            }
            Some(_) => Ok(1.0),
        }
    }

    /// A drawing of a `frame` that is enlarged so many times: lengths in pixels of the original become those of the
    /// frame.
    #[must_use]
    pub(crate) fn fitted(mut self, frame: &Frame, times: f64) -> Self {
        if self.goal.is_none() {
            let params = &mut self.params;
            params.shape = enlarged(params.shape, times, frame);
            let line = &mut params.line;
            line.contours = line.contours.map(|lines| lines.enlarged(times as f32));
            let size = frame.display_window;
            let size = [size.width(), size.height()].map(|side| side as f64);
            params.line.strokes = params.strokes_on_page(size, frame.pixel_aspect);
        }
        self
    }

    /// These inputs and those of the request.
    fn available(&self, there: Available) -> Available {
        let light = self.inputs.illumination.map(Illumination::kinds);
        Available {
            specular: self.specular.or(there.specular),
            moving: there.moving || self.inputs.sequence.is_some(),
            in_sequence: there.in_sequence || self.inputs.sequence.is_some(),
            new_light: light.unwrap_or(there.new_light),
            light: match self.computes_occlusion {
                true => there.light.with_computed_occlusion(),
                false => there.light,
            },
            ..there
        }
    }

    /// The goal with these inputs, and whether it takes a lamp that is not there.
    fn resolved(&self, there: &Available) -> (Goal<'a>, bool) {
        let Params {
            relight,
            line,
            tone,
            ..
        } = self.params;
        match self.goal {
            Some(Goal::Relight(params)) => {
                (Goal::Relight(params), is_dark(&params, there.new_light))
            }
            Some(goal) => (goal, false),
            None => {
                let (tone, needs_lamp) = toned(tone, relight, there);
                (Goal::Hatch(tone, line), needs_lamp)
            }
        }
    }
}

/// Whether new light that is empty would leave all dark: no ambient light is asked for, and no surroundings show.
pub(crate) fn is_dark(params: &RelightParams, light: LightKinds) -> bool {
    let MaterialParams {
        material, ambient, ..
    } = params.material;
    let usual = MaterialParams::default().ambient;
    light == LightKinds::NONE && !material.shows_surroundings() && ambient == usual
}

/// The tone of a drawing from this source, and whether it takes a lamp that is not there.
fn toned(source: ToneSource, relight: RelightParams, there: &Available) -> (Tone, bool) {
    let is_lit = there.new_light != LightKinds::NONE;
    let is_specular = there.specular.is_some();
    // A surface seen in mirrors has no tone but that of its light.
    let shows_shape = source == ToneSource::Auto && !is_specular;
    let is_relit = match source {
        ToneSource::Relight => true,
        ToneSource::Auto if shows_shape => is_lit,
        ToneSource::Auto => is_lit || !there.color,
        ToneSource::Enhance | ToneSource::Picture => false,
    };
    let is_mirror = relight.material.material.shows_surroundings();
    let needs_lamp = is_relit && !is_lit && !(is_mirror && is_specular);
    let tone = match source {
        _ if shows_shape => Tone::Shape(is_relit.then_some(relight)),
        _ if is_relit => Tone::Relit(relight),
        ToneSource::Picture => Tone::Picture,
        _ => Tone::Enhanced,
    };
    (tone, needs_lamp)
}

/// Shape parameters for a frame enlarged by `times`, measured in pixels of the original.
fn enlarged(shape: ShapeParams, times: f64, frame: &Frame) -> ShapeParams {
    if times == 1.0 {
        return shape;
    }
    let height = (frame.display_window.height() as f64 / times)
        .round()
        .max(1.0) as u32;
    let SoftThreshold { lo, hi } = shape.crease;
    ShapeParams {
        reference_height: shape.reference_height.or(Some(height)),
        // Interpolated normals turn `times` less from pixel to pixel.
        crease: SoftThreshold {
            lo: lo / times as f32,
            hi: hi / times as f32,
        },
        ..shape
    }
}
