//! White levels, from the luminance of all pixels: of the picture, or of each term of its light.

use crate::frame::percentile::{InLooks, PictureSample};
use crate::light::layers::cpu::Absent;
use crate::light::layers::terms::light_terms;
use crate::params::Adaptive;
use crate::plan::execution::Execution;
use crate::plan::search::{Search, Settle};
use crate::shape::auto_levels::WHITE_PERCENT;
use crate::shape::auto_levels::cpu::{luminance_at, white_of};

/// A search for the white level of the picture.
#[derive(Default)]
pub(crate) struct WhiteSearch(PictureSample<f32>);

impl WhiteSearch {
    pub(super) fn level(self) -> f32 {
        white_of(self.0.percentile(WHITE_PERCENT))
    }
}

impl Search for WhiteSearch {
    fn look(&mut self, run: &mut Execution) {
        let (from, weights) = (run.chosen_from(), run.frame.luminance_weights());
        if let Some(color) = &from.frame.color {
            from.add_to(&mut self.0, |x, y| Some(luminance_at(color, weights, x, y)));
        }
    }

    fn samples(&mut self) -> Vec<&mut dyn InLooks> {
        vec![&mut self.0]
    }

    fn found(self: Box<Self>) -> Settle {
        let white = self.level();
        Box::new(move |plan| plan.scaling.white_level = Adaptive::Fixed(white))
    }
}

/// A search for the white level of each term of the light that has none given.
#[derive(Default)]
pub(crate) struct TermSearch(Vec<(&'static str, PictureSample<f32>)>);

impl TermSearch {
    pub(super) fn levels(self) -> Vec<(&'static str, f32)> {
        let terms = self.0.into_iter();
        terms
            .map(|(name, sample)| (name, sample.percentile(WHITE_PERCENT).unwrap_or(1.0)))
            .collect()
    }
}

impl Search for TermSearch {
    fn survey(&mut self, run: &Execution) {
        let scaling = &run.plan.scaling;
        if self.0.is_empty() {
            let terms = light_terms(&run.frame.light.lobes, scaling).into_iter();
            let names = terms.map(|term| term.name);
            let open = names.filter(|name| scaling.term_white_levels.of(name).is_none());
            self.0 = open.map(|name| (name, PictureSample::default())).collect();
        }
    }

    fn look(&mut self, run: &mut Execution) {
        let (from, weights) = (run.chosen_from(), run.frame.luminance_weights());
        let absent = Absent::new(from.frame.mask.width());
        for term in light_terms(&from.frame.light.lobes, &run.plan.scaling) {
            let known = self.0.iter_mut().find(|(name, _)| *name == term.name);
            if let Some((_, sample)) = known {
                from.add_to(sample, term.lit(weights, &absent));
            }
        }
    }

    fn samples(&mut self) -> Vec<&mut dyn InLooks> {
        let samples = self.0.iter_mut();
        samples
            .map(|(_, sample)| sample as &mut dyn InLooks)
            .collect()
    }

    fn found(self: Box<Self>) -> Settle {
        let levels = self.levels();
        Box::new(move |plan| {
            let given = plan.scaling.term_white_levels;
            plan.scaling.term_white_levels = given.or(levels.iter().copied());
        })
    }
}
