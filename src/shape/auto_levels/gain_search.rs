//! The gain of the curvature mapping, from the trace of all pixels.

use super::cpu::Counted;
use super::{flat_curvature, gain_of};
use crate::frame::percentile::{InLooks, PictureSample};
use crate::params::Adaptive;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::search::{ChosenFrom, Search, Settle};
use crate::product::Product;
use crate::shape::curvature::stage::trace_of_gradient;

/// A search for the gain.
pub(crate) struct GainSearch {
    pub(super) sample: PictureSample<[f32; 2]>,
    /// The factor of the trace to its value per pixel.
    factor: f32,
    most: f32,
}

impl GainSearch {
    /// For a trace of `factor` times its value per pixel, and a gain of at most `most`.
    pub(crate) fn new(factor: f32, most: f32) -> Self {
        Self {
            sample: PictureSample::default(),
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

    fn samples(&mut self) -> Vec<&mut dyn InLooks> {
        vec![&mut self.sample]
    }

    fn found(self: Box<Self>) -> Settle {
        let gain = self.gain();
        Box::new(move |plan| plan.scaling.curvature_gain = Adaptive::Fixed(gain))
    }
}

/// Makes the trace where it is no product: of the curvatures, or, where rows alone have them, of the gradient.
pub(super) fn make_trace(run: &mut Execution) {
    let shape = &run.made.outcome.shape;
    match (&shape.curvatures, &shape.trace) {
        (Some(curvatures), _) if run.made.trace.is_none() => {
            run.made.trace = Some(curvatures.trace())
        }
        (None, None) => trace_of_gradient(run),
        _ => {}
    }
}

/// Products that the gain is chosen from. Relighting makes no Hessian as a plane: of that, a trace of the gradient.
pub(super) fn gain_takes(plan: &Plan) -> Vec<Product> {
    let mut takes = vec![Product::Trace, Product::Conductance];
    if plan.wants(Product::Hessian) {
        takes.extend([Product::Hessian, Product::Gradient]);
    }
    takes
}
