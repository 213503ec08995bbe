//! A layer of occlusion without its grain, which few samples leave: it would show in the light that it dims.
//!
//! Grain spreads by conductance, so that the shade of a corner stays on its side of an edge. A layer without grain is taken
//! as it is.

use crate::frame::Plane;
use crate::plan::execution::Execution;
use crate::shape::diffusion::stage::spread;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use crate::shape::edges::stage::EDGES;

/// Its name in timings and in a session.
pub(super) const NAME: &str = "occlusion-grain";

/// How far it spreads, in pixels, and the largest error of a share by that.
const SIGMA_PX: f32 = 3.0;
const TOLERANCE: f64 = 2e-3;

/// The sweeps that spread grain.
pub(super) fn sweeps() -> DiffusionSchedule {
    DiffusionSchedule::to_sigmas(&[SIGMA_PX], TOLERANCE)
}

/// The occlusion of the frame without grain, if the plan says that it has some.
pub(super) fn without_grain(run: &mut Execution) -> Option<Plane> {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let is_grainy = plan.relighting()?.grainy_occlusion;
    let occlusion = frame.light.occlusion.as_ref().filter(|_| is_grainy)?;
    let key = plan.key(EDGES.name);
    let quiet = run.copied_or(NAME, Some(key), |run| {
        let mut planes = memory.vectors(&frame.mask);
        planes.x.samples_mut().copy_from_slice(occlusion.samples());
        spread(run, NAME, planes, &sweeps())
    });
    quiet.into_iter().next().map(|planes| planes.x)
}
