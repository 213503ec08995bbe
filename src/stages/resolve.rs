//! Resolution of a plan: stages decide from the last to the first, so that the needs of later stages are known when an
//! earlier one decides.

use crate::error::{Error, Result};
use crate::kernel::shelf::Shelf;
use crate::light::enhancement::Enhancement;
use crate::light::relight::setting::Relighting;
use crate::params::{
    RelightParams, Scale, ScalingParams, Shadows, ShapeParams, Solver, check_scales,
};
use crate::plan::available::Available;
use crate::plan::goal::{Goal, Tone};
use crate::plan::planned::{Decision, Plan, Points};
use crate::plan::stage::{Step, Verdict};
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use crate::stages::stages;
use std::collections::BTreeMap;

impl Plan {
    /// The plan for `goal` over a frame with the given inputs.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] for a parameter outside its range, for lights and materials that lack required inputs, for
    /// tone from a picture if there is none, and for further scales with explicit steps, which share no sweeps, or with an
    /// importance map, which varies the scale per pixel; [`crate::Error::Unfit`] for enhancing without a picture.
    pub fn new(
        goal: Goal,
        available: Available,
        shape: ShapeParams,
        scaling: ScalingParams,
    ) -> Result<Self> {
        let more_px = match goal {
            Goal::Layers { more_px, .. } => more_px,
            _ => &[],
        };
        let (is_enhanced, relit) = picture_of(&goal, available)?;
        shape.validate()?;
        check_scales(1 + more_px.len())?;
        refuse_several_scales(&shape, more_px, available)?;
        shape.validate_for(available.image_height)?;
        scaling.validate()?;
        let resolution_factor = shape.resolution_factor(available.image_height);
        for &sigma in more_px {
            let scale = Scale::Sigma(sigma);
            let at_scale = ShapeParams { scale, ..shape };
            at_scale.validate()?;
            at_scale.validate_for(available.image_height)?;
        }
        let (mut drawing, mut line_scale) = (None, 1.0);
        if let Goal::Hatch(_, mut params) = goal {
            params.validate()?;
            params.strokes.style = available.style(params.strokes.style);
            let size = available.image_size_px();
            line_scale = params.strokes.fit(size, resolution_factor as f32);
            drawing = Some(params);
        }
        let relighting = relit.map(|params| Relighting::new(params, &scaling, available));
        let relighting = relighting.transpose()?;
        let enhancement = is_enhanced.then(|| Enhancement::new(available.light, &scaling));
        let no_shape = match (enhancement, &relighting) {
            (Some(enhancement), _) if enhancement.is_idle() => {
                Some("a magnitude of 0 leaves the picture as it is")
            }
            (None, None) if drawing.is_some() => Some("the picture is taken as it is"),
            (_, Some(relighting)) if !relighting.needs_shape() => {
                Some("light that is not altered asks nothing of shape")
            }
            _ => None,
        };
        let factor = resolution_factor;
        let mut settings = Shelf::default();
        settings.put(DiffusionSchedule::new(
            &shape,
            factor,
            more_px,
            available.importance,
        ));
        enhancement.into_iter().for_each(|own| settings.put(own));
        relighting.into_iter().for_each(|own| settings.put(own));
        let plan = Self {
            shape,
            scaling,
            display: goal == Goal::Display,
            drawing,
            inks_strokes: true,
            keeps_tone: true,
            line_scale,
            shows_shape: matches!(goal, Goal::Hatch(Tone::Shape(_), line) if !line.lines_only),
            specular: available.specular,
            settings,
            more_px: more_px.to_vec(),
            resolution_factor,
            points: match available.positions {
                true => Points::Depth,
                false => Points::Normals,
            },
            direction_steps_px: shape.direction_steps_px(available.normal_rounding),
            available,
            tile: None,
            no_shape,
            wanted: goal.products().into_iter().collect(),
            decisions: Vec::new(),
            stages: Vec::new(),
            keys: BTreeMap::new(),
            reach: 0,
        };
        Ok(plan.resolved())
    }

    /// Lets every stage decide, from the last to the first.
    fn resolved(mut self) -> Self {
        for stage in stages().rev() {
            let steps = stage.steps.iter().rev();
            let decided: Vec<_> = steps.map(|step| decision(step, &self)).collect();
            if decided.iter().any(|decision| decision.kept) || (stage.also_runs)(&self) {
                self.stages.push(stage);
                self.wanted.extend((stage.takes)(&self));
            }
            self.decisions.extend(decided);
        }
        self.stages.reverse();
        self.decisions.reverse();
        self.follow()
    }
}

fn decision(step: &Step, plan: &Plan) -> Decision {
    let (kept, reason) = match (step.decide)(plan) {
        Verdict::Runs(why) => (true, why),
        Verdict::LeftOut(why) => (false, why),
    };
    Decision {
        step: step.name,
        kept,
        reason,
    }
}

/// Whether the picture is the enhanced one, and the new light in it.
fn picture_of(goal: &Goal, available: Available) -> Result<(bool, Option<RelightParams>)> {
    let tone = match goal {
        Goal::Enhance if !available.color => {
            return Err(Error::Unfit {
                found: "enhancing takes a picture, and the frame has none".into(),
                remedy: "give one",
            });
        }
        Goal::Enhance => return Ok((true, None)),
        Goal::Relight(params) => return Ok((false, Some(*params))),
        Goal::Hatch(tone, line) if !line.lines_only => *tone,
        _ => return Ok((false, None)),
    };
    match tone {
        Tone::Picture | Tone::Enhanced if !available.color => Err(Error::BadParameter {
            name: "--tone",
            found: "comes from the picture, and there is none".into(),
            remedy: "name one with --color, or give a --light".into(),
        }),
        Tone::Picture => Ok((false, None)),
        Tone::Enhanced => Ok((true, None)),
        Tone::Shape(None) => Ok((available.color, None)),
        Tone::Relit(relight) | Tone::Shape(Some(relight)) => Ok((false, Some(in_drawing(relight)))),
    }
}

/// New light of a drawing: unless they are asked for, it has no shadows.
fn in_drawing(light: RelightParams) -> RelightParams {
    let shadows = match light.shadows {
        Shadows::Auto => Shadows::Off,
        asked => asked,
    };
    RelightParams { shadows, ..light }
}

fn refuse_several_scales(shape: &ShapeParams, more_px: &[f32], available: Available) -> Result<()> {
    let are_mixed = matches!(shape.scale, Scale::Mixed(_));
    let bad = |found: &str, remedy: &str| {
        Err(Error::BadParameter {
            name: "--scale",
            found: found.into(),
            remedy: remedy.into(),
        })
    };
    if shape.solver == Solver::Explicit && (are_mixed || !more_px.is_empty()) {
        return bad(
            "names several scales, which explicit steps cannot share",
            "leave out --solver explicit, or run once per scale",
        );
    }
    if available.importance && !more_px.is_empty() {
        return bad(
            "names several scales, but --importance gives every pixel its own",
            "give one scale, or leave out --importance",
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::gap::GAP_REACH;
    use crate::light::lights::LightKinds;
    use crate::line::direction::FILL_REACH_PX;
    use crate::plan::LightAvailable;

    fn plan(goal: Goal, available: Available, iterations: u32) -> Plan {
        let shape = ShapeParams {
            scale: crate::params::Scale::Iterations(iterations),
            ..ShapeParams::default()
        };
        Plan::new(goal, available, shape, ScalingParams::default()).unwrap()
    }

    const DEPTH: Available = Available {
        bends: false,
        grainy_occlusion: false,
        is_map: false,
        is_flat: false,
        depth: true,
        color: true,
        albedo: false,
        gloss: false,
        occlusion: true,
        importance: false,
        object_angles: false,
        image_height: 1080,
        image_width: 1920,
        positions: true,
        normal_rounding: 0.0,
        moving: false,
        in_sequence: false,
        specular: None,
        new_light: LightKinds::NONE,
        light: LightAvailable::NONE,
    };
    const NOTHING: Available = Available {
        bends: false,
        grainy_occlusion: false,
        is_map: false,
        is_flat: false,
        depth: false,
        color: true,
        albedo: false,
        gloss: false,
        occlusion: false,
        importance: false,
        object_angles: false,
        image_height: 1080,
        image_width: 1920,
        positions: false,
        normal_rounding: 0.0,
        moving: false,
        in_sequence: false,
        specular: None,
        new_light: LightKinds::NONE,
        light: LightAvailable::NONE,
    };

    #[test]
    fn a_run_pays_only_for_what_it_needs() {
        assert!(plan(Goal::Enhance, DEPTH, 50).runs("diffusion"));
        assert!(!plan(Goal::Enhance, DEPTH, 0).runs("diffusion"));
        assert!(!plan(Goal::Enhance, NOTHING, 50).runs("depth-silhouettes"));
        assert!(!plan(Goal::Enhance, DEPTH, 50).runs("occlusion-silhouettes"));
        for step in ["directions", "curvatures", "hessian"] {
            assert!(!plan(Goal::Enhance, DEPTH, 50).runs(step));
            assert!(plan(Goal::LAYERS, DEPTH, 50).runs(step));
        }
    }

    #[test]
    fn scaling_by_zero_computes_nothing() {
        let idle = ScalingParams {
            scaling: 0.0,
            ..ScalingParams::default()
        };
        let plan = Plan::new(Goal::Enhance, DEPTH, ShapeParams::default(), idle).unwrap();
        assert!(plan.stages().is_empty());
    }

    #[test]
    fn names_are_given_once_and_what_is_taken_is_given_before() {
        let names = stages().flat_map(|stage| stage.steps).map(|step| step.name);
        let passes = stages().map(|stage| stage.name);
        for mut names in [names.collect::<Vec<_>>(), passes.collect()] {
            let count = names.len();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), count);
        }
        for goal in [Goal::LAYERS, Goal::Display, Goal::Enhance] {
            let plan = plan(goal, DEPTH, 50);
            let mut given = Vec::new();
            for stage in &plan.stages {
                let takes = (stage.takes)(&plan);
                assert!(
                    takes.iter().all(|taken| given.contains(taken)),
                    "{}",
                    stage.name
                );
                given.extend(stage.gives());
            }
        }
    }

    /// Reach adds up along the stages: that of edges, 1 for each sweep, 1 for the Hessian.
    #[test]
    fn reaches_add_up() {
        let enhanced = plan(Goal::Enhance, DEPTH, 50);
        assert_eq!(enhanced.reach(), GAP_REACH + enhanced.sweeps().count() + 1);
        assert_eq!(plan(Goal::Enhance, DEPTH, 0).reach(), GAP_REACH + 1);
        let layers = plan(Goal::LAYERS, DEPTH, 50);
        let directions = GAP_REACH + layers.direction_steps_px[1] + FILL_REACH_PX;
        assert_eq!(layers.reach(), enhanced.reach().max(directions));
    }

    #[test]
    fn a_key_changes_with_what_its_result_depends_on_and_with_nothing_else() {
        let (fine, coarse) = (
            plan(Goal::Enhance, DEPTH, 10),
            plan(Goal::Enhance, DEPTH, 50),
        );
        assert_eq!(
            fine.key("edges-and-gradient"),
            coarse.key("edges-and-gradient")
        );
        for stage in ["diffusion", "curvature", "auto-gain"] {
            assert_ne!(fine.key(stage), coarse.key(stage));
        }
        let brighter = ScalingParams {
            scaling: 2.0,
            ..ScalingParams::default()
        };
        let brighter = Plan::new(Goal::Enhance, DEPTH, coarse.shape, brighter).unwrap();
        assert_eq!(brighter.key("auto-gain"), coarse.key("auto-gain"));
    }
}
