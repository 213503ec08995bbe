//! Radiance scaling of separate light layers.

use crate::frame::ColorPlanes;
use crate::light::enhancement::Subject;
use crate::light::layers::cpu::{self, Curvature};
use crate::light::layers::terms::light_terms;
use crate::light::radiance_scaling::cpu::Scaler;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// Each lobe of the picture's light separately.
pub(crate) static LIGHT_LOBES: Stage = Stage {
    takes: |_| vec![Product::Trace],
    makes: Makes::Picture,
    name: "light-lobes",
    steps: &[step("light-lobes", &[Product::Picture], decide_lobes)],
    cpu: scale_lobes,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("lobes of light"),
    ..Stage::DEFAULT
};

/// Light groups, by the directions of their lights.
pub(crate) static LIGHT_GROUPS: Stage = Stage {
    takes: |plan| match plan.scaling.anisotropy == 0.0 {
        true => vec![Product::Trace],
        false => vec![Product::Trace, Product::Hessian],
    },
    makes: Makes::Picture,
    name: "light-groups",
    steps: &[step("light-groups", &[Product::Picture], |plan| {
        let why = |magnitude| format!("magnitude {magnitude}, by directions");
        plan.scales(Subject::Groups, "no --light-group", why)
    })],
    cpu: scale_groups,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("light groups"),
    ..Stage::DEFAULT
};

/// Ambient occlusion of the picture, enhanced or not.
pub(crate) static AMBIENT_OCCLUSION: Stage = Stage {
    takes: |plan| match plan.available.light.occlusion_is_computed {
        true => vec![Product::Trace, Product::Sky],
        false => vec![Product::Trace],
    },
    makes: Makes::Picture,
    name: "ambient-occlusion",
    steps: &[step(
        "ambient-occlusion",
        &[Product::Picture],
        decide_occlusion,
    )],
    cpu: scale_by_occlusion,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("ambient occlusion"),
    ..Stage::DEFAULT
};

fn decide_lobes(plan: &Plan) -> Verdict {
    let light = plan.available.light;
    let no_lobes = match light.diffuse || light.specular {
        true => "light groups go before lobes",
        false => "no separate lobes, or one layer named",
    };
    let terms = match (plan.scaling.scaling_ambient, light.diffuse_indirect) {
        (Some(ambient), true) => format!(", ambient {ambient}"),
        _ => String::new(),
    };
    plan.scales(Subject::Lobes, no_lobes, |_| {
        let magnitudes = plan.scaling.magnitudes();
        format!(
            "magnitude diffuse {}, specular {}{terms}",
            magnitudes.diffuse, magnitudes.specular
        )
    })
}

fn decide_occlusion(plan: &Plan) -> Verdict {
    let light = plan.available.light;
    let why_not = match (plan.enhancement(), plan.scaling.scaling_ambient) {
        (None, _) => "no light is asked for",
        (Some(own), _) if own.occlusion > 0.0 => {
            return Verdict::runs(format!("magnitude {}", own.occlusion));
        }
        (_, None) => "no --scaling-ambient",
        _ if light.picture_is_occlusion => "the picture is occlusion",
        (_, Some(0.0)) => "--scaling-ambient 0",
        _ if !light.occlusion => "no occlusion layer",
        _ => "in the diffuse light from other surfaces, which is scaled by it",
    };
    plan.left_out(why_not)
}

fn scale_lobes(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let terms = light_terms(&frame.light.lobes, &plan.scaling);
    let whites = run.made.outcome.term_white_levels.clone();
    with_curvature(run, LIGHT_LOBES.name, |_, curvature| {
        cpu::scale_lobes(&terms, &whites, frame, &plan.scaling, curvature, memory)
    });
}

fn scale_groups(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    with_curvature(run, LIGHT_GROUPS.name, |_, curvature| {
        cpu::scale_groups(frame, &plan.scaling, curvature, memory)
    });
}

/// The intensity of ambient light is the share that arrives ([RS] section 5.3.1 and figure 8 b).
fn scale_by_occlusion(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let sky = run.made.outcome.shape.sky.take();
    let occlusion = frame.light.occlusion.as_ref().or(sky.as_ref());
    let occlusion = occlusion.expect("the plan has seen occlusion");
    let scaler = Scaler {
        magnitude: plan.scaling.magnitudes().ambient,
        invariant_point: plan.scaling.invariant_point,
        gain: run.gain(),
        white: 1.0,
        weights: frame.luminance_weights(),
    };
    with_curvature(
        run,
        AMBIENT_OCCLUSION.name,
        |made, Curvature { trace, .. }| {
            let color = made.as_ref().or(frame.color.as_ref());
            let color = color.expect("radiance scaling needs a picture");
            let scaled = scaler.scale(color, Some(occlusion), trace, &frame.mask, memory);
            let planes = made
                .into_iter()
                .flat_map(|ColorPlanes { r, g, b }| [r, g, b]);
            memory.recycle(planes);
            scaled
        },
    );
}

/// Replaces the picture made so far by one modified by curvature.
fn with_curvature(
    run: &mut Execution,
    name: &'static str,
    pass: impl FnOnce(Option<ColorPlanes>, Curvature) -> ColorPlanes,
) {
    let (made, gain) = (run.made.outcome.color.take(), run.gain());
    let shape = std::mem::take(&mut run.made.outcome.shape);
    let curvature = Curvature {
        trace: shape.trace.as_ref().expect("scaling takes the trace"),
        hessian: shape.hessian.as_ref(),
        gain,
    };
    let color = run.timed(name, || pass(made, curvature));
    run.made.outcome.color = Some(color);
    run.made.outcome.shape = shape;
}
