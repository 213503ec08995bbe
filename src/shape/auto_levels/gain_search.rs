//! The gain of the curvature mapping, from the trace of all pixels.

use super::cpu::Counted;
use super::{flat_curvature, gain_of};
use crate::frame::percentile::{Looks, Sample};
use crate::params::Adaptive;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::search::{ChosenFrom, Search, Settle};
use crate::product::Product;
use crate::shape::auto_levels::stage::{gain_takes, make_trace};

/// A search for the gain.
pub(crate) struct GainSearch {
    pub(super) sample: Sample<[f32; 2]>,
    /// The factor of the trace to its value per pixel.
    factor: f32,
    most: f32,
}

impl GainSearch {
    /// For a trace of `factor` times its value per pixel, and a gain of at most `most`.
    pub(crate) fn new(factor: f32, most: f32) -> Self {
        Self {
            sample: Sample::default(),
            factor,
            most,
        }
    }

    pub(super) fn add(&mut self, from: &ChosenFrom, counted: &Counted) {
        let flat = flat_curvature(from.strip.whole, self.factor);
        from.add_to(&mut self.sample, |x, y| counted.at(flat, [x, y]));
    }

    /// The gain, after the last look.
    pub(crate) fn gain(self) -> f32 {
        gain_of(&self.sample.values(), self.most)
    }
}

impl Search for GainSearch {
    fn takes(&self, plan: &Plan) -> Vec<Product> {
        gain_takes(plan)
    }

    fn look(&mut self, run: &mut Execution) {
        make_trace(run);
        let shape = &run.made.outcome.shape;
        let trace = run.made.trace.as_ref().or(shape.trace.as_ref());
        let trace = trace.expect("the gain takes the trace");
        let conductance = shape.conductance.as_ref();
        let conductance = conductance.expect("the trace takes the conductance");
        let counted = Counted::of(run.frame, [trace, conductance]);
        self.add(&run.chosen_from_made(), &counted);
    }

    fn samples(&mut self) -> Vec<&mut dyn Looks> {
        vec![&mut self.sample]
    }

    fn found(self: Box<Self>) -> Settle {
        let gain = self.gain();
        Box::new(move |plan| plan.scaling.curvature_gain = Adaptive::Fixed(gain))
    }
}
