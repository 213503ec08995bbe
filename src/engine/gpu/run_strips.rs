//! Plans on the strips of a picture, with automatic choices from the whole.

use crate::engine::cpu::gpu_support::term_white_levels;
use crate::engine::gpu::runner::{Beside, Runner};
use crate::engine::outcome::Outcome;
use crate::engine::tiles::{Strips, strip_of};
use crate::error::Result;
use crate::frame::{Extent, Frame};
use crate::light::enhancement::Subject;
use crate::light::white_level::chosen_for;
use crate::params::Adaptive;
use crate::plan::Plan;
use crate::shape::auto_levels::cpu::{GainSearch, white_level};
use std::ops::Range;

impl Runner {
    /// Runs `plan` on the strips of a frame, with automatic choices from the whole frame.
    pub(crate) fn run_strips(
        &self,
        plan: &Plan,
        frame: &Frame,
        beside: Beside,
        strips: &Strips,
    ) -> Result<Outcome> {
        let mut plan = plan.clone();
        if plan.chooses_gain() {
            let gain = self.chosen_gain(&plan, frame, beside, strips)?;
            plan.scaling.curvature_gain = Adaptive::Fixed(gain);
        }
        if chosen_for(&plan) == Some(Subject::Picture) {
            let color = frame.color.as_ref().expect("scaling takes a picture");
            let white = white_level(color, frame.luminance_weights(), &frame.mask);
            plan.scaling.white_level = Adaptive::Fixed(white);
        }
        if chosen_for(&plan) == Some(Subject::Lobes) {
            let levels = term_white_levels(frame, &plan.scaling);
            let known = plan.scaling.term_white_levels;
            plan.scaling.term_white_levels = known.or(levels.into_iter());
        }
        let run =
            |strip: &Frame, rows: &Range<usize>| self.run_strip(&plan, strip, beside, rows.clone());
        strips.run(frame, run, drop)
    }

    /// The gain of the whole picture.
    fn chosen_gain(
        &self,
        plan: &Plan,
        frame: &Frame,
        beside: Beside,
        strips: &Strips,
    ) -> Result<f32> {
        let size = [frame.mask.width(), frame.mask.height()];
        let factor = plan.resolution_factor as f32;
        let mut gain = GainSearch::new(size, factor, plan.most_gain());
        gain.search.begin(&Extent::of(&frame.mask));
        while gain.search.is_open() {
            for (takes, gives) in strips.each() {
                strips.check()?;
                let strip = strip_of(frame, &takes);
                let mut run = self.start(plan, &strip, beside);
                let shape = run.find_shape();
                let [trace, conductance] = run.read_planes([shape.trace(), &shape.conductance]);
                run.finish(&[])?;
                gain.add(&strip.mask, gives, takes.start, [&trace, &conductance]);
                self.buffers.recycle(shape.into_buffers());
            }
            gain.search.end_look();
        }
        Ok(gain.gain())
    }
}
