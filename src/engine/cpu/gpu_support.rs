//! Work that other backends leave to the CPU: automatic choices over a whole frame that a device processes in strips,
//! and the searches for them.

use crate::engine::cpu::memory::Memory;
use crate::frame::{ColorPlanes, Frame};
use crate::light::layers::cpu as light_layers;
use crate::light::layers::terms::light_terms;
use crate::light::relight::albedo;
use crate::params::ScalingParams;
use crate::plan::Plan;

/// The albedo estimated from a frame's picture.
pub(crate) fn estimated_albedo(plan: &Plan, frame: &Frame) -> ColorPlanes {
    let (weights, memory) = (frame.luminance_weights(), Memory::default());
    let own = plan.own_part(frame);
    let found = albedo::estimate(&own, &own.normal, weights);
    albedo::by_estimate(frame, &found, &memory)
}

/// The white levels of the terms of a frame's light.
pub(crate) fn term_white_levels(frame: &Frame, params: &ScalingParams) -> Vec<(&'static str, f32)> {
    let terms = light_terms(&frame.light.lobes, params);
    light_layers::white_levels(&terms, frame, params)
}
