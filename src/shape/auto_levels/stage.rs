//! The gain of the curvature mapping: chosen from the whole frame, or given.

use crate::params::Adaptive;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Stage, Verdict, step};
use crate::shape::auto_levels::gain_search::{GainSearch, gain_takes, make_trace};
use crate::shape::auto_levels::most_gain;

/// The gain of the curvature mapping.
pub(crate) static AUTO_GAIN: Stage = Stage {
    // A given gain is recorded.
    also_runs: Plan::wants_curvature,
    takes: gain_takes,
    chooses: |plan| match plan.chooses_gain() {
        true => Some(Box::new(search(plan))),
        false => None,
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
    run.made.outcome.gain = Some(gain);
}

/// The gain from the trace, however that is computed.
fn gain_of_frame(run: &mut Execution) -> f32 {
    let plan = run.plan;
    make_trace(run);
    // The bits of a trace depend on the source it is computed from.
    let made_of = (run.made.trace.is_some(), plan.relighting().is_some());
    let key = format!("{} {made_of:?}", plan.key(AUTO_GAIN.name));
    run.copied_or(AUTO_GAIN.name, Some(&key), |run| {
        run.timed_on(AUTO_GAIN.name, |run| run.searched(search(plan)).gain())
    })
}

fn search(plan: &Plan) -> GainSearch {
    GainSearch::new(plan.resolution_factor as f32, plan.most_gain())
}
