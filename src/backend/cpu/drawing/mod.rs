//! Drawings: the tone of a picture in strokes along the curvature, and lines along its edges.

mod hatching;
mod tone;

use super::memory::Memory;
use super::{Drawing, Run, light, normal_rays, statistics};
use crate::frame::Plane;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{Adaptive, LineParams};
use tone::Densities;

impl Run<'_> {
    /// Draws the picture made so far, or that of the frame.
    pub(super) fn draw(&mut self, params: &LineParams) {
        let (plan, frame, memory) = (self.plan, self.frame, &self.runner.memory);
        let conductance = self.outcome.shape.conductance.take();
        let conductance = conductance.expect("a drawing is planned with its edges");
        let direction = self.timed("direction-field", || {
            normal_rays::directions(plan, frame, &conductance, memory)
        });
        let stroke = params.strokes.stroke(plan.resolution_factor as f32);
        let map = self.timed("tonal-art-map", || {
            TonalArtMap::of_strokes(&stroke, params.strokes.style, params.strokes.seed)
        });
        let made = self.outcome.color.take();
        let color = made.as_ref().or(frame.color.as_ref());
        let color = color.expect("a drawing is planned with its tone");
        let weights = light::luminance_weights(frame);
        let white = match params.tone.white_point {
            Adaptive::Fixed(white) => white,
            Adaptive::Auto => self.timed("auto-white", || {
                statistics::white_level(color, weights, &frame.mask)
            }),
        };
        let densities = Densities::new(color, frame, weights, white, &params.tone);
        let hatching = self.timed("hatching", || {
            hatching::hatched(&densities, &direction, &map, &params.strokes, frame, memory)
        });
        self.outcome.color = made;
        self.outcome.shape.conductance = Some(conductance);
        self.outcome.drawing = Some(Drawing { hatching });
    }
}
