//! Inputs of a plan beside the frame, and the check that both fit the plan.

use crate::error::{Error, Result};
use crate::frame::{Frame, Plane, SpecularScene};
use crate::kernel::shelf::Lent;
use crate::light::lights::{Illumination, LightKinds};
use crate::light::relight::setting::{EnvironmentUse, Relighting};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::Style;
use crate::plan::execution::RunInputs;
use crate::plan::{Available, Plan};

/// Inputs of a plan beside the frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct PlanInputs<'a> {
    /// The lights, for relighting.
    pub illumination: Option<&'a Illumination>,
    /// The texture of strokes, for [`crate::params::Style::Pictures`].
    pub art_map: Option<&'a TonalArtMap>,
    /// The scene seen in mirrors and lenses, if the plan traces it.
    pub specular: Option<&'a SpecularScene>,
    /// The state of a sequence whose strokes move with the surface; a still picture needs none.
    pub sequence: Option<SequenceInputs<'a>>,
}

impl<'a> PlanInputs<'a> {
    /// Inputs for relighting.
    pub fn lit_by(illumination: &'a Illumination) -> Self {
        Self {
            illumination: Some(illumination),
            ..Self::default()
        }
    }

    /// The same, as stages take them.
    pub(crate) fn given(&self) -> RunInputs<'a> {
        RunInputs {
            specular: self.specular,
            sequence: self.sequence,
            others: Lent::of(self.illumination, self.art_map),
        }
    }

    /// Checks that all inputs the plan was made for are present.
    ///
    /// # Errors
    /// [`Error::Unfit`] naming the first input that is missing, or differs in size from the frame.
    pub(crate) fn check(&self, plan: &Plan, frame: &Frame) -> Result<()> {
        check_frame(&plan.available, frame)?;
        if let Some(relighting) = plan.relighting() {
            self.check_light(relighting, &plan.available, frame)?;
        }
        let strokes = plan.drawing.as_ref().map(|drawing| &drawing.strokes);
        let of_pictures = strokes.is_some_and(|strokes| strokes.style == Style::Pictures);
        if of_pictures && self.art_map.is_none() {
            return Err(missing("a texture of strokes", "none is given"));
        }
        let relighting = plan.relighting();
        let is_traced = strokes.is_some() || relighting.is_some_and(|relighting| relighting.traced);
        if plan.specular.is_some() && is_traced && self.specular.is_none() {
            return Err(missing("what mirrors and lenses show", "none is given"));
        }
        self.check_sizes(frame)
    }

    fn check_light(
        &self,
        relighting: &Relighting,
        planned: &Available,
        frame: &Frame,
    ) -> Result<()> {
        let Some(light) = self.illumination else {
            return Err(missing("light", "none is given"));
        };
        let kinds = light.kinds();
        if relighting.environment != EnvironmentUse::None && !kinds.environment {
            return Err(missing("an environment", "the light has none"));
        }
        if relighting.lit_spheres != kinds.lit_spheres {
            let planned = format!("{} lit spheres", relighting.lit_spheres);
            return Err(missing(
                &planned,
                &format!("the light has {}", kinds.lit_spheres),
            ));
        }
        let of_lamps = |kinds: LightKinds| [kinds.directional, kinds.points];
        if of_lamps(planned.new_light) != of_lamps(kinds) {
            return Err(missing("other lamps", "these differ in kind"));
        }
        if kinds.points && relighting.sums && !Available::in_frame(frame).positions {
            return Err(missing(
                "depth and a camera for lights at a point",
                "the frame lacks them",
            ));
        }
        Ok(())
    }

    /// Checks that the planes of the specular scene have the frame's size.
    fn check_sizes(&self, frame: &Frame) -> Result<()> {
        let motion = self.sequence.and_then(|sequence| sequence.motion);
        let mask = self.specular.and_then(|scene| scene.mask.as_ref());
        let position = self.specular.and_then(|scene| scene.hit_position.as_ref());
        let size = |plane: &Plane| [plane.width(), plane.height()];
        let sizes = [
            ("motion", motion.map(|motion| size(&motion.x))),
            ("the ends of sight lines", position.map(|at| size(&at.x))),
            (
                "the mask of specular pixels",
                mask.map(|mask| [mask.width(), mask.height()]),
            ),
        ];
        let [width, height] = [frame.mask.width(), frame.mask.height()];
        for (name, size) in sizes {
            if let Some([own_width, own_height]) = size.filter(|size| *size != [width, height]) {
                return Err(Error::Unfit {
                    found: format!(
                        "{name} is {own_width}x{own_height}, for {width}x{height} pixels"
                    ),
                    remedy: "give inputs of one size",
                });
            }
        }
        Ok(())
    }
}

/// Checks that `frame` has the inputs the plan was made for.
fn check_frame(planned: &Available, frame: &Frame) -> Result<()> {
    let there = Available::in_frame(frame);
    let (plan, here) = (planned.light, there.light);
    let layer = plan.occlusion && !plan.occlusion_is_computed;
    let occlusion = [planned.occlusion, there.occlusion];
    let importance = [planned.importance, there.importance];
    let positions = [planned.positions, there.positions];
    let layers = [
        ("depth", [planned.depth, there.depth]),
        ("a picture", [planned.color, there.color]),
        ("an albedo", [planned.albedo, there.albedo]),
        ("layers of gloss", [planned.gloss, there.gloss]),
        ("an occlusion map or alpha", occlusion),
        ("a map of importance", importance),
        ("depth and a camera", positions),
        ("layers of diffuse light", [plan.diffuse, here.diffuse]),
        ("layers of specular light", [plan.specular, here.specular]),
        ("light groups", [plan.groups, here.groups]),
        ("a layer of ambient occlusion", [layer, here.occlusion]),
    ];
    match layers.iter().find(|(_, has)| *has == [true, false]) {
        Some((name, ..)) => Err(missing(name, "the frame has none")),
        None => Ok(()),
    }
}

fn missing(what: &str, but: &str) -> Error {
    Error::Unfit {
        found: format!("the plan takes {what}, and {but}"),
        remedy: "give it, or plan without",
    }
}
