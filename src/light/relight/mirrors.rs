//! The mirrors and lenses of a frame, and the peak brightness of their scene.

use crate::frame::luminance;
use crate::frame::{ColorPlanes, Frame, SpecularScene};
use crate::params::SpecularParams;
use crate::trace::Tracer;

/// The mirrors and lenses of a frame.
pub(crate) struct Mirrors<'a> {
    pub(super) tracer: Tracer<'a>,
    /// The luminance that counts as intensity 1: the largest that a sight line can hit.
    pub(super) largest: f32,
}

impl<'a> Mirrors<'a> {
    /// The mirrors of `frame` in a scene; `None` if nothing can be traced.
    pub(crate) fn new(
        frame: &'a Frame,
        scene: &'a SpecularScene,
        params: &SpecularParams,
        weights: [f32; 3],
    ) -> Option<Self> {
        let around = scene
            .surroundings
            .as_ref()
            .and_then(|map| map.color.as_ref());
        let behind = scene
            .behind
            .as_ref()
            .and_then(|behind| behind.color.as_ref());
        let largest = around
            .into_iter()
            .chain(behind)
            .map(|color| largest_luminance(color, weights))
            .fold(f32::MIN_POSITIVE, f32::max);
        Some(Self {
            tracer: Tracer::new(frame, scene, params)?,
            largest,
        })
    }
}

fn largest_luminance(color: &ColorPlanes, weights: [f32; 3]) -> f32 {
    let [r, g, b] = [&color.r, &color.g, &color.b].map(|plane| plane.samples());
    let all = r.iter().zip(g).zip(b);
    all.map(|((&r, &g), &b)| luminance([r, g, b], weights))
        .fold(0.0, f32::max)
}
