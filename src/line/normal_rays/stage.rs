//! Directions of the surface's own curvature, as layers and for a grain that follows them.

use crate::line::direction::FILL_REACH_PX;
use crate::line::normal_rays::cpu;
use crate::plan::execution::Execution;
use crate::plan::stage::{Stage, Verdict, step};
use crate::plan::{Plan, Points};
use crate::product::Product;

/// Directions of the larger curvature of the surface, from its normal rays.
pub(crate) static NORMAL_RAYS: Stage = Stage {
    takes: |_| vec![Product::Conductance],
    reach_px: |plan| match plan.wants(Product::Direction) {
        true => plan.direction_steps_px[1] + FILL_REACH_PX,
        false => 0,
    },
    depends_on: |plan| format!("{:?} {:?}", plan.points, plan.direction_steps_px),
    name: "normal-rays",
    steps: &[step("normal-rays", &[Product::Direction], decide)],
    cpu: follow_rays,
    #[cfg(feature = "gpu")]
    gpu: Some(super::gpu::follow_rays),
    #[cfg(feature = "gpu")]
    after_gpu: Some(super::gpu::fill_gaps),
    ..Stage::DEFAULT
};

fn decide(plan: &Plan) -> Verdict {
    // Strokes compute them where needed.
    if !plan.wants(Product::Direction) && plan.drawing.is_none() {
        return plan.left_out("nothing here follows a direction");
    }
    let points = match plan.points {
        Points::Depth => "points from depth and camera",
        Points::Normals => "no depth with a camera to trust: points from normals alone",
    };
    let [least, most] = plan.direction_steps_px;
    Verdict::runs(match least == most {
        true => format!("{points}, {least} px away"),
        false => format!("{points}, {least} to {most} px away"),
    })
}

fn follow_rays(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let key = plan.key(NORMAL_RAYS.name);
    if !plan.wants(Product::Direction) || run.has_kept(&[Product::Direction], key) {
        return;
    }
    let conductance = run.made.outcome.shape.conductance.take();
    let conductance = conductance.expect("directions are planned with their edges");
    let directions = run.timed(NORMAL_RAYS.name, || {
        cpu::directions(plan, frame, &conductance, memory)
    });
    let shape = &mut run.made.outcome.shape;
    (shape.conductance, shape.direction) = (Some(conductance), Some(directions));
}
