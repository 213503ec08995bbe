//! What to compute, in what order, and why: from the products asked for and the inputs present, the
//! stages needed and no others. A plan touches no pixel.

mod enhancement;
mod explain;
mod relight;

pub use crate::shape::diffusion::sweeps::{DiffusionSchedule, Importance, Readout, Recurrence};
pub use enhancement::LightAvailable;
pub use explain::Decision;
pub use relight::{Albedo, EnvironmentUse, LightKinds, Relighting};

use crate::error::{Error, Result};
use crate::frame::{DepthKind, Frame};
use crate::line::direction::FILL_REACH_PX;
use crate::params::{
    LineParams, RelightParams, Scale, ScalingParams, ShapeParams, Solver, SpecularParams, Style,
    check_scales,
};
use crate::shape::{EDGE_REACH, diffusion, hessian};
use serde::Serialize;

/// What a run is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Goal {
    /// Every layer of the descriptor.
    Layers,
    /// The coloured curvature display of [LW] figure 6.
    Display,
    /// Radiance scaling of the picture.
    Enhance,
    /// New light.
    Relight,
    /// The picture as it is: to be drawn.
    Picture,
}

/// Where the tone of a drawing comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToneFrom {
    /// The picture as it is.
    Picture,
    /// The picture by radiance scaling.
    Enhanced,
    /// New light.
    Relit(RelightParams, LightKinds),
}

/// One step of the work. The order of the variants is the order of execution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Silhouette weights from depth.
    DepthSilhouettes,
    /// Silhouette weights from an occlusion map or alpha.
    OcclusionSilhouettes,
    /// Silhouette weights from the border of coverage alone.
    BorderSilhouettes,
    /// Crease weights from normals.
    Creases,
    /// Conductance from both weights.
    Conductance,
    /// Depth gradient.
    Gradient,
    /// Diffusion of the gradient.
    Diffusion,
    /// Trace of the Hessian alone.
    Trace,
    /// The whole Hessian.
    Hessian,
    /// Principal and mean curvatures.
    Curvatures,
    /// Directions of the larger view-centred curvature, from the Hessian.
    Directions,
    /// Directions of the larger curvature of the surface itself, from its normal rays.
    NormalRays,
    /// Gain of the curvature mapping, chosen from the frame.
    AutoGain,
    /// White level, chosen from the picture.
    AutoWhite,
    /// Mapped curvature as a layer.
    MappedCurvature,
    /// Radiance scaling of the picture.
    RadianceScaling,
    /// Radiance scaling of each lobe of the picture's light.
    LightLobes,
    /// Radiance scaling of light groups by the directions of their lights.
    LightGroups,
    /// Radiance scaling by ambient occlusion.
    AmbientOcclusion,
    /// Coloured curvature display.
    CurvatureDisplay,
    /// Albedo, from the picture.
    AlbedoEstimate,
    /// Lights that stand for an environment.
    EnvironmentLights,
    /// Environment prefiltered by the lobes.
    EnvironmentPrefilter,
    /// The warp of every pixel.
    Warping,
    /// The Jacobian of its inverse.
    Jacobian,
    /// The sum over lights.
    LightSum,
    /// Look-ups into an environment or a lit sphere.
    LightLookups,
    /// Contrast by curvature.
    Contrast,
    /// Few tones.
    Tones,
    /// What mirrors and lenses show.
    SpecularTrace,
    /// The directions that strokes follow.
    DirectionField,
    /// Where the texture of strokes lies as the surface moves.
    TextureCoordinates,
    /// The texture of strokes.
    TonalArtMap,
    /// Strokes.
    Hatching,
    /// Strokes as lines.
    Streamlines,
    /// Lines along silhouettes and creases.
    Contours,
}

/// What there is to plan with.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Available {
    /// Depth.
    pub depth: bool,
    /// A picture.
    pub color: bool,
    /// The albedo of the surface.
    pub albedo: bool,
    /// An occlusion map or alpha.
    pub occlusion: bool,
    /// A map of importance, by which every pixel has a scale of its own.
    pub importance: bool,
    /// Height in pixels of the whole picture, its display window: neither a crop nor overscan changes it.
    pub image_height: usize,
    /// Depth and a camera that together tell where the surface is.
    pub positions: bool,
    /// Largest rounding error of a component of the normals.
    pub normal_rounding: f32,
    /// How specular pixels are traced, where what they show is known; no frame says so by itself.
    pub specular: Option<SpecularParams>,
    /// Light layers to scale.
    pub light: LightAvailable,
    /// Whether this is a frame of a sequence whose strokes are to move with the surface; no frame says so
    /// by itself.
    pub moving: bool,
}

/// What tells where the surface seen at a pixel lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Points {
    /// Depth along sight lines that the camera gives.
    Depth,
    /// The normals: the surface is followed from pixel to pixel.
    Normals,
}

impl Available {
    /// What `frame` holds.
    pub fn in_frame(frame: &Frame) -> Self {
        Self {
            depth: frame.depth.is_some(),
            color: frame.color.is_some(),
            albedo: frame.albedo.is_some(),
            occlusion: frame.occlusion.is_some(),
            importance: frame.importance.is_some(),
            image_height: frame.display_window.height(),
            positions: frame.depth.is_some()
                && frame.camera.is_some()
                && frame.source.depth_kind != DepthKind::Relative,
            normal_rounding: frame.source.normal_rounding,
            light: LightAvailable::of(&frame.light),
            moving: false,
            specular: None,
        }
    }
}

/// The stages of a run in their order, with the reason for each one kept or left out.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What the run is for.
    pub goal: Goal,
    /// How shape is found.
    pub shape: ShapeParams,
    /// How light is scaled; used by [`Goal::Enhance`] and [`Goal::Relight`], its gain by all.
    pub scaling: ScalingParams,
    /// How the frame is lit anew, for [`Goal::Relight`].
    pub relighting: Option<Relighting>,
    /// How the picture that was made is drawn, if it is.
    pub drawing: Option<LineParams>,
    /// How specular pixels are traced, if they are.
    pub specular: Option<SpecularParams>,
    /// How the gradient is diffused.
    pub sweeps: DiffusionSchedule,
    /// Sigmas of further scales, in pixels of the reference.
    pub more_px: Vec<f32>,
    /// How many pixels of the frame stand for one of the reference, in which curvature is measured; 1 without
    /// a [reference height](ShapeParams::reference_height).
    pub resolution_factor: f64,
    /// How the points of neighbouring pixels are found for [`Stage::NormalRays`].
    pub points: Points,
    /// How many pixels away they are, at the least and at the most.
    pub direction_steps_px: [usize; 2],
    /// What there is to make it of.
    pub(crate) available: Available,
    stages: Vec<Stage>,
    decisions: Vec<Decision>,
}

impl Plan {
    /// The plan for `goal` over a frame with the given inputs.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] for a parameter outside its range.
    pub fn new(
        goal: Goal,
        available: Available,
        shape: ShapeParams,
        scaling: ScalingParams,
    ) -> Result<Self> {
        Self::at_scales(goal, available, shape, scaling, &[])
    }

    /// The plan for lighting a frame with the given inputs anew, by lights of these `kinds`.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] for a parameter outside its range, and for lights and materials that
    /// lack what they need.
    pub fn relight(
        available: Available,
        shape: ShapeParams,
        scaling: ScalingParams,
        relight: RelightParams,
        kinds: LightKinds,
    ) -> Result<Self> {
        scaling.validate()?;
        let relighting = Relighting::new(relight, &scaling, kinds, available)?;
        Self::made(Asked {
            relighting: Some(relighting),
            ..Asked::of(Goal::Relight, available, shape, scaling)
        })
    }

    /// The plan for drawing a frame with the given inputs, in the tone of a picture.
    ///
    /// # Errors
    /// As [`Plan::new`] and [`Plan::relight`]; also for a tone from a picture that there is not.
    pub fn hatch(
        available: Available,
        shape: ShapeParams,
        scaling: ScalingParams,
        tone: ToneFrom,
        drawing: LineParams,
    ) -> Result<Self> {
        scaling.validate()?;
        drawing.validate()?;
        if available.moving && drawing.strokes.style == Style::Lines {
            return Err(Error::BadParameter {
                name: "--style",
                found: "is lines, which do not move with the surface".into(),
                remedy: "take pen or pencil, or give --motion none".into(),
            });
        }
        let (goal, relighting) = match tone {
            ToneFrom::Picture => (Goal::Picture, None),
            ToneFrom::Enhanced => (Goal::Enhance, None),
            ToneFrom::Relit(relight, kinds) => {
                let relighting = Relighting::new(relight, &scaling, kinds, available)?;
                (Goal::Relight, Some(relighting))
            }
        };
        if goal != Goal::Relight && !available.color {
            return Err(Error::BadParameter {
                name: "--tone",
                found: "comes from the picture, and there is none".into(),
                remedy: "name one with --color, or give a --light".into(),
            });
        }
        Self::made(Asked {
            relighting,
            drawing: Some(drawing),
            ..Asked::of(goal, available, shape, scaling)
        })
    }

    /// [`Plan::new`] whose gradient is also made at further scales, sigmas in pixels, by the same sweeps.
    ///
    /// # Errors
    /// As [`Plan::new`]; also for further scales of explicit steps, whose sweeps are theirs alone, or
    /// where pixels have a scale of their own by importance.
    pub fn at_scales(
        goal: Goal,
        available: Available,
        shape: ShapeParams,
        scaling: ScalingParams,
        more_px: &[f32],
    ) -> Result<Self> {
        Self::made(Asked {
            more_px,
            ..Asked::of(goal, available, shape, scaling)
        })
    }

    fn made(asked: Asked) -> Result<Self> {
        let Asked {
            goal,
            available,
            shape,
            scaling,
            more_px,
            relighting,
            drawing,
        } = asked;
        shape.validate()?;
        check_scales(1 + more_px.len())?;
        if !more_px.is_empty() {
            refuse_several_scales(&shape, available)?;
        }
        shape.validate_for(available.image_height)?;
        scaling.validate()?;
        let resolution_factor = shape.resolution_factor(available.image_height);
        for &sigma in more_px {
            let scale = Scale::Sigma(sigma);
            let at_scale = ShapeParams { scale, ..shape };
            at_scale.validate()?;
            at_scale.validate_for(available.image_height)?;
        }
        let by_importance = available.importance;
        let sweeps = DiffusionSchedule::new(&shape, resolution_factor, more_px, by_importance);
        let points = match available.positions {
            true => Points::Depth,
            false => Points::Normals,
        };
        let direction_steps_px = shape.direction_steps_px(available.normal_rounding);
        let decisions = explain::decide(&explain::Request {
            goal,
            available,
            shape: &shape,
            sweeps: &sweeps,
            rays: (points, direction_steps_px),
            scaling: &scaling,
            relighting: relighting.as_ref(),
            drawing: drawing.as_ref(),
        });
        let stages = decisions
            .iter()
            .filter(|d| d.kept)
            .map(|d| d.stage)
            .collect();
        Ok(Self {
            goal,
            shape,
            scaling,
            relighting,
            drawing,
            specular: available.specular,
            sweeps,
            more_px: more_px.to_vec(),
            resolution_factor,
            points,
            direction_steps_px,
            available,
            stages,
            decisions,
        })
    }

    /// The stages to run, in order.
    pub fn stages(&self) -> &[Stage] {
        &self.stages
    }

    /// Whether `stage` is part of the plan.
    pub fn has(&self, stage: Stage) -> bool {
        self.stages.contains(&stage)
    }

    /// Whether the weights of silhouettes and creases are results themselves, or a later stage reads them: conductance
    /// alone is made without.
    pub(crate) fn keeps_edge_weights(&self) -> bool {
        self.goal == Goal::Layers || self.has(Stage::Contours)
    }

    /// How far, in pixels, an input sample reaches: a crop gives the results of the whole picture from
    /// this distance to its border on, unless a gain or white level is chosen from the frame. A drawing
    /// depends on all of it.
    pub fn reach(&self) -> usize {
        let sweeps = if self.has(Stage::Diffusion) {
            self.sweeps.count()
        } else {
            0
        };
        let curvature = sweeps * diffusion::REACH + hessian::REACH;
        let rays = if self.has(Stage::NormalRays) {
            self.direction_steps_px[1] + FILL_REACH_PX
        } else {
            0
        };
        // Of new light pixels that are covered in part take some from their neighbours.
        let rim = usize::from(self.goal == Goal::Relight);
        EDGE_REACH + curvature.max(rays) + rim
    }

    /// The same without the directions of the surface's own curvature.
    pub(crate) fn without_directions(mut self) -> Self {
        self.stages.retain(|&stage| stage != Stage::NormalRays);
        self
    }

    /// Every stage there is, kept or left out, and why.
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }
}

/// What a plan is made of.
struct Asked<'a> {
    goal: Goal,
    available: Available,
    shape: ShapeParams,
    scaling: ScalingParams,
    more_px: &'a [f32],
    relighting: Option<Relighting>,
    drawing: Option<LineParams>,
}

impl Asked<'_> {
    fn of(goal: Goal, available: Available, shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self {
            goal,
            available,
            shape,
            scaling,
            more_px: &[],
            relighting: None,
            drawing: None,
        }
    }
}

fn refuse_several_scales(shape: &ShapeParams, available: Available) -> Result<()> {
    let bad = |found: &str, remedy: &str| {
        Err(Error::BadParameter {
            name: "--scale",
            found: found.into(),
            remedy: remedy.into(),
        })
    };
    if shape.solver == Solver::Explicit {
        return bad(
            "names several scales, which explicit steps cannot share",
            "leave out --solver explicit, or run once per scale",
        );
    }
    if available.importance {
        return bad(
            "names several scales, but --importance gives every pixel its own",
            "give one scale, or leave out --importance",
        );
    }
    Ok(())
}
