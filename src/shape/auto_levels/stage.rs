//! The gain of the curvature mapping: chosen from the whole frame, or given.

use crate::params::Adaptive;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Stage, Verdict, step};
use crate::product::Product;
use crate::shape::auto_levels::cpu::{self, Counted};
use crate::shape::auto_levels::most_gain;
use crate::shape::curvature::stage::trace_of_gradient;

/// The gain of the curvature mapping.
pub(crate) static AUTO_GAIN: Stage = Stage {
    // A given gain is recorded.
    also_runs: Plan::wants_curvature,
    takes: |plan| match plan.wants(Product::Hessian) {
        // Relighting makes no Hessian as a plane: the gain is chosen from a trace of the gradient.
        true => vec![
            Product::Hessian,
            Product::Trace,
            Product::Gradient,
            Product::Conductance,
        ],
        false => vec![Product::Trace, Product::Conductance],
    },
    reads_normals: false,
    name: "auto-gain",
    steps: &[step("auto-gain", &[], |plan| {
        match plan.scaling.curvature_gain {
            _ if !plan.wants_curvature() => plan.left_out("no curvature is needed"),
            Adaptive::Auto => Verdict::runs("--curvature-gain auto"),
            fixed => plan.left_out(format!("--curvature-gain {fixed}")),
        }
    })],
    cpu: choose_gain,
    #[cfg(feature = "gpu")]
    gpu: Some(|run| super::gpu::with_trace(run, choose_gain)),
    ..Stage::DEFAULT
};

impl Plan {
    /// Whether the gain of the curvature mapping is chosen from the frame.
    pub(crate) fn chooses_gain(&self) -> bool {
        self.wants_curvature() && self.scaling.curvature_gain == Adaptive::Auto
    }

    /// Upper limit of an automatic gain.
    pub(crate) fn most_gain(&self) -> f32 {
        let factor = self.resolution_factor;
        let sigmas = self.shape.scales_px();
        let mean_px = sigmas.iter().sum::<f64>() / sigmas.len() as f64 * factor;
        most_gain(
            self.available.normal_rounding,
            mean_px as f32,
            factor as f32,
        )
    }

    /// Whether the automatic gain was limited, since coarse normals would show their steps.
    #[cfg(feature = "cli")]
    pub(crate) fn holds_gain(&self, gain: Option<f32>) -> bool {
        self.chooses_gain() && self.most_gain() < super::MAX_GAIN && gain == Some(self.most_gain())
    }
}

fn choose_gain(run: &mut Execution) {
    let gain = match run.plan.scaling.curvature_gain {
        Adaptive::Fixed(gain) => gain,
        Adaptive::Auto => gain_of_frame(run),
    };
    run.outcome.gain = Some(gain);
}

/// The gain from the trace, however that is computed.
fn gain_of_frame(run: &mut Execution) -> f32 {
    let plan = run.plan;
    let shape = &run.outcome.shape;
    match (&shape.curvatures, &shape.trace) {
        (Some(curvatures), _) => run.trace = Some(curvatures.trace()),
        (None, None) => trace_of_gradient(run),
        (None, Some(_)) => {}
    }
    let (shape, own) = (std::mem::take(&mut run.outcome.shape), run.trace.take());
    let trace = own.as_ref().or(shape.trace.as_ref());
    let trace = trace.expect("the gain takes the trace");
    let conductance = shape
        .conductance
        .as_ref()
        .expect("the trace takes the conductance");
    // The bits of a trace depend on the source it is computed from.
    let made_of = (own.is_some(), plan.relighting().is_some());
    let key = format!("{} {made_of:?}", plan.key(AUTO_GAIN.name));
    let (factor, most) = (plan.resolution_factor as f32, plan.most_gain());
    let (frame, whole) = (run.frame, run.whole.unwrap_or(run.frame));
    let choose = || {
        let counted = Counted::of(frame, [trace, conductance]);
        let part = plan.tile.map_or(whole.data_window, |tile| tile.window);
        let of_tile = plan.tile.map(|_| frame.mask.crop(frame.data_window, part));
        let mask = of_tile.as_ref().unwrap_or(&whole.mask);
        cpu::curvature_gain(
            &counted,
            (mask, part.relative_to(frame.data_window)),
            factor,
            most,
        )
    };
    let gain = run.copied_or(AUTO_GAIN.name, Some(&key), |run| {
        run.timed(AUTO_GAIN.name, choose)
    });
    (run.outcome.shape, run.trace) = (shape, own);
    gain
}
