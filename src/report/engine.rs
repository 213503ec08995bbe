//! Engine calls of the report: a plan and its inputs in, planes and times out.

use super::timing::{self, Effort, Timed};
use crate::Result;
use crate::engine::{Engine, Run};
pub(super) use crate::engine::{Inputs, Outcome, SequenceInputs, TextureCoordinates};
use crate::frame::{Frame, Plane, SymmetricPlanes, Vector2Planes};
use crate::light::lights::Illumination;
use crate::params::{
    Adaptive, LineParams, RelightParams, ScalingParams, ShapeParams, StrokeDirections, ToneParams,
};
use crate::plan::{Available, Goal, LightKinds, Plan, ToneFrom};

/// The plan for relighting `frame` by `light`.
pub(super) fn relight_plan(
    frame: &Frame,
    shape: ShapeParams,
    params: RelightParams,
    light: &Illumination,
) -> Result<Plan> {
    let (available, kinds) = (Available::in_frame(frame), LightKinds::in_light(light));
    Plan::relight(available, shape, ScalingParams::default(), params, kinds)
}

/// The plan for drawing in the tones of the picture.
pub(super) fn hatch_plan(
    available: Available,
    shape: ShapeParams,
    line: LineParams,
) -> Result<Plan> {
    let scaling = ScalingParams::default();
    Plan::hatch(available, shape, scaling, ToneFrom::Picture, line)
}

/// Tones taken directly from the picture: 1 is paper.
pub(super) fn painted() -> ToneParams {
    ToneParams {
        white_point: Adaptive::Fixed(1.0),
        black_point: 0.0,
        gamma: 1.0,
        ..ToneParams::default()
    }
}

/// Runs `plan` on the CPU.
///
/// # Errors
/// As [`Engine::execute`].
pub(super) fn run(plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
    Engine::cpu().execute(plan, frame, inputs, &Run::new())
}

/// Runs plans in the memory of earlier runs, like the frames of a sequence.
#[derive(Default)]
pub(super) struct Session(Engine);

impl Session {
    /// Runs `plan`.
    ///
    /// # Panics
    /// If it was made for other inputs.
    pub(super) fn run(&self, plan: &Plan, frame: &Frame, inputs: Inputs) -> Outcome {
        let outcome = self.0.execute(plan, frame, inputs, &Run::new());
        outcome.expect("plans of reports are made for what they are run on")
    }

    /// Runs `plan` once to warm up, then the number of times given by `effort`; returns the last outcome.
    pub(super) fn measure(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        effort: Effort,
    ) -> (Outcome, Timed) {
        timing::measure_runs(&self.0, effort, || {
            // Preparation of the environment is timed too.
            self.0.forget_environment();
            self.run(plan, frame, inputs)
        })
    }

    /// Recycles the memory of an outcome for the next run.
    pub(super) fn recycle(&self, outcome: Outcome) {
        self.0.recycle(outcome);
    }

    /// The stroke directions along the larger curvature; where specular pixels show a scene, those of the surfaces
    /// shown.
    ///
    /// # Panics
    /// If the plan was made for other inputs.
    pub(super) fn stroke_field(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        line: &LineParams,
    ) -> Vector2Planes {
        let line = LineParams {
            directions: StrokeDirections::Max,
            ..*line
        };
        let fields = self.0.stroke_fields(plan, frame, inputs, &line);
        let fields = fields.expect("plans of reports are made for what they are run on");
        fields.into_iter().next().expect("one field was asked for")
    }
}

/// The planes of the descriptor.
pub(super) struct Layers {
    pub(super) silhouette: Plane,
    pub(super) crease: Plane,
    pub(super) conductance: Plane,
    pub(super) gradient: Vector2Planes,
    pub(super) hessian: SymmetricPlanes,
    /// Mean of the principal curvatures.
    pub(super) mean: Plane,
    pub(super) direction: Vector2Planes,
    /// Gain of the mapped curvature.
    pub(super) gain: f32,
}

impl Layers {
    /// # Panics
    /// If the outcome does not belong to [`Goal::Layers`].
    pub(super) fn of(outcome: Outcome) -> Self {
        let gain = outcome.gain.unwrap_or(0.0);
        let shape = outcome.shape;
        let all = || {
            Some(Self {
                silhouette: shape.silhouette?,
                crease: shape.crease?,
                conductance: shape.conductance?,
                gradient: shape.gradient?,
                hessian: shape.hessian?,
                mean: shape.curvatures?.mean,
                direction: shape.direction?,
                gain,
            })
        };
        all().expect("layers hold the whole descriptor")
    }

    /// Trace of the Hessian.
    pub(super) fn trace(&self) -> Plane {
        let mut trace = self.hessian.xx.clone();
        for (xx, yy) in trace
            .samples_mut()
            .iter_mut()
            .zip(self.hessian.yy.samples())
        {
            *xx += yy;
        }
        trace
    }
}

/// The descriptor of `frame`.
pub(super) fn layers(frame: &Frame, shape: ShapeParams) -> Result<Layers> {
    let plan = timing::plan(Goal::Layers, frame, shape)?;
    Ok(Layers::of(Session::default().run(
        &plan,
        frame,
        Inputs::default(),
    )))
}
