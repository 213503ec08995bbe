//! Radiance scaling of the picture as a whole.

use crate::light::enhancement::Subject;
use crate::light::radiance_scaling::cpu::Scaler;
use crate::params::Magnitude;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// The picture, scaled by curvature ([RS] section 4).
pub(crate) static RADIANCE_SCALING: Stage = Stage {
    takes: |_| vec![Product::Trace, Product::Conductance],
    reads_normals: false,
    makes: Makes::Picture,
    name: "radiance-scaling",
    steps: &[step("radiance-scaling", &[Product::Picture], decide)],
    cpu: scale,
    #[cfg(feature = "gpu")]
    gpu: Some(|run| super::gpu::scale(scaler(&run.host), run)),
    ..Stage::DEFAULT
};

fn decide(plan: &Plan) -> Verdict {
    let by_layers = match plan.enhancement().map(|enhancement| enhancement.subject) {
        Some(Subject::Groups) => "light groups are scaled instead",
        _ => "its lobes are scaled instead",
    };
    plan.scales(Subject::Picture, by_layers, |magnitude| {
        format!("magnitude {magnitude}")
    })
}

impl Plan {
    /// The verdict on scaling this subject; `why_not` if another subject is scaled.
    pub(crate) fn scales(
        &self,
        subject: Subject,
        why_not: &str,
        why: impl FnOnce(Magnitude) -> String,
    ) -> Verdict {
        match self.enhancement() {
            None => self.left_out("no light is asked for"),
            Some(own) if own.subject != subject => self.left_out(why_not),
            Some(own) if own.magnitude.largest() == 0.0 => self.left_out("a magnitude of 0"),
            Some(own) => Verdict::runs(why(own.magnitude)),
        }
    }
}

/// Radiance scaling of the picture with the white level and gain of this run.
fn scaler(run: &Execution) -> Scaler {
    let params = &run.plan.scaling;
    let magnitude = match run.frame.light.picture_is_occlusion {
        true => params.magnitudes().ambient,
        false => params.magnitude(),
    };
    let white = run.made.outcome.white_level;
    Scaler {
        magnitude,
        invariant_point: params.invariant_point,
        gain: run.gain(),
        white: white.expect("the white level is chosen before scaling"),
        weights: run.frame.luminance_weights(),
    }
}

fn scale(run: &mut Execution) {
    let (scaler, frame, memory) = (scaler(run), run.frame, run.memory);
    let color = frame
        .color
        .as_ref()
        .expect("radiance scaling needs a picture");
    let trace = run.made.outcome.shape.trace.take();
    let trace = trace.expect("scaling takes the trace");
    let scaled = run.timed(RADIANCE_SCALING.name, || {
        scaler.scale(color, None, &trace, &frame.mask, memory)
    });
    run.made.outcome.shape.trace = Some(trace);
    run.made.outcome.color = Some(scaled);
}
