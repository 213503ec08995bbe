//! Mirrors and lenses in a drawing: surfaces seen in them are drawn as they appear.

use crate::line::specular::map_directions::DirectionCache;
use crate::line::specular::seen_through;
use crate::params::{Bend, SpecularParams};
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;
use crate::shape::edges::cpu::edges_and_gradient;

/// The stage that finds the surfaces seen in mirrors and lenses, for drawings. Relighting looks them up itself.
pub(crate) static SPECULAR_TRACE: Stage = Stage {
    makes: Makes::Drawing,
    name: "specular-trace",
    steps: &[step("specular-trace", &[Product::Picture], decide)],
    cpu: trace,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("mirrors and lenses that show what is traced"),
    ..Stage::DEFAULT
};

fn decide(plan: &Plan) -> Verdict {
    let Some(SpecularParams { bend, search }) = plan.specular else {
        return Verdict::left_out("nothing is known that mirrors or lenses could show");
    };
    let bent = match bend {
        Bend::Mirror => "mirrored".into(),
        Bend::Glass { ior } => format!("refracted by {ior}"),
        Bend::Straight => "straight on".into(),
    };
    Verdict::runs(format!("sight lines {bent}, {} search steps", search.steps))
}

fn trace(run: &mut Execution) {
    let (plan, frame, runner) = (run.plan, run.frame, run.runner);
    let (Some(params), Some(specular)) = (&plan.drawing, &plan.specular) else {
        return;
    };
    let scene = run.inputs.specular;
    let scene = scene.expect("specular pixels are planned with what they show");
    let (kept, memory) = (&runner.caches.of::<DirectionCache>(), run.memory);
    let seen = run.timed(SPECULAR_TRACE.name, || {
        seen_through(plan, frame, scene, specular, params, kept, memory)
    });
    run.canvas_mut().seen = seen.map(|seen| {
        let (edges, _) = run.timed("specular-edges", || {
            edges_and_gradient(plan, &seen.frame, memory)
        });
        (seen, edges)
    });
}
