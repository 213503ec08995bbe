//! Automatic choices from a whole picture that is processed in strips.

use crate::error::Result;
use crate::frame::percentile::Sample;
use crate::frame::{Extent, Frame, Window};
use crate::light::albedo::AlbedoEstimate;
use crate::light::enhancement::Subject;
use crate::light::layers::white_search::add_to_searches;
use crate::light::relight::albedo_search::AlbedoSearch;
use crate::light::relight::setting::Albedo;
use crate::light::white_level::chosen_for;
use crate::params::{Adaptive, ScalingParams};
use crate::plan::Plan;
use crate::plan::execution::RunInputs;
use crate::plan::execution::{Execution, Runner};
use crate::plan::outcome::Shape;
use crate::plan::stage::Makes;
use crate::product::Product;
use crate::shape::auto_levels::WHITE_PERCENT;
use crate::shape::auto_levels::cpu::{luminance_at, white_of};
use crate::shape::auto_levels::gain_search::GainSearch;
use crate::shape::curvature::stage::trace_of_gradient;
use std::ops::Range;

/// A search for the gain, the white levels and the albedo estimate that the whole picture would get. All strips are
/// passed from top to bottom, again and again while [`StripSearch::next_look`] asks for it: once for the extent of what is
/// covered and the fit of the shading, then once or twice for percentiles.
#[derive(Debug, Clone)]
pub(crate) struct StripSearch {
    whole: Window,
    extent: Extent,
    /// Whether the extent is known.
    is_measured: bool,
    gain: Option<GainSearch>,
    white: Option<Sample<f32>>,
    terms: Vec<(&'static str, Sample<f32>)>,
    albedo: Option<AlbedoSearch>,
}

/// Results of the searches; `None` for levels that were given.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct StripChoice {
    /// Gain of the curvature mapping.
    pub gain: Option<f32>,
    /// White level of the picture.
    pub white_level: Option<f32>,
    /// White levels of the kinds of light scaled separately, by name.
    pub term_white_levels: Vec<(&'static str, f32)>,
    /// The fit for estimating albedo.
    pub albedo: Option<AlbedoEstimate>,
}

impl StripSearch {
    /// Looks that most pictures take.
    #[cfg(feature = "cli")]
    pub(crate) const USUAL_LOOKS: usize = 2;

    /// A search for the settings that `plan` leaves open in a picture of this window; `None` if there are none.
    pub(crate) fn new(plan: &Plan, whole: Window) -> Option<Self> {
        let size = [whole.width(), whole.height()];
        let factor = plan.resolution_factor as f32;
        let relighting = plan.relighting();
        let estimates_albedo = relighting.is_some_and(|r| r.albedo == Albedo::Estimate);
        let search = Self {
            whole,
            extent: Extent::default(),
            is_measured: false,
            gain: plan
                .chooses_gain()
                .then(|| GainSearch::new(size, factor, plan.most_gain())),
            white: (chosen_for(plan) == Some(Subject::Picture)).then(Sample::default),
            terms: Vec::new(),
            albedo: estimates_albedo.then(AlbedoSearch::new),
        };
        let open = search.gain.is_some() || search.albedo.is_some() || chosen_for(plan).is_some();
        open.then_some(search)
    }

    /// Takes in the rows `rows` of a strip, counted within it; the other rows are margin.
    ///
    /// # Errors
    /// [`Error::Unfit`](crate::Error::Unfit) if the plan was made for other inputs than the strip holds.
    ///
    /// # Panics
    /// If the plan is for a drawing.
    pub(crate) fn look(
        &mut self,
        runner: &Runner,
        plan: &Plan,
        strip: &Frame,
        rows: Range<usize>,
    ) -> Result<()> {
        assert!(plan.drawing.is_none(), "a drawing takes the picture whole");
        let (weights, mask) = (strip.luminance_weights(), &strip.mask);
        let top = strip.data_window.relative_to(self.whole).y0 as usize;
        if let Some(search) = &mut self.albedo {
            search.add(strip, weights, rows.clone(), top);
        }
        if !self.is_measured {
            self.extent.add(mask, rows, top);
            return Ok(());
        }
        if let Some(search) = self.gain.as_mut().filter(|gain| gain.sample.is_open()) {
            // The gain depends neither on itself nor on directions.
            let mut given = plan.clone().without(Product::Direction);
            given.scaling.curvature_gain = Adaptive::Fixed(1.0);
            let mut run = Execution::new(runner, &given, strip, RunInputs::default());
            let of_shape = given
                .stages
                .iter()
                .filter(|stage| stage.makes == Makes::Shape);
            run.go_through(of_shape.copied())?;
            if run.outcome.shape.curvatures.is_none() && run.outcome.shape.trace.is_none() {
                trace_of_gradient(&mut run);
            }
            let outcome = run.outcome;
            let Shape {
                trace,
                curvatures,
                conductance,
                ..
            } = &outcome.shape;
            let summed = curvatures.as_ref().map(|c| c.trace());
            let trace = trace.as_ref().or(summed.as_ref());
            let trace = trace.expect("the gain takes the trace");
            let conductance = conductance.as_ref();
            let conductance = conductance.expect("the trace takes the conductance");
            search.add(strip, rows.clone(), top, [trace, conductance]);
            runner.recycle(outcome);
        }
        if let (Some(search), Some(color)) = (&mut self.white, &strip.color) {
            search.add(mask, rows.clone(), top, |x, y| {
                Some(luminance_at(color, weights, x, y))
            });
        }
        if chosen_for(plan) == Some(Subject::Lobes) {
            let (searches, extent) = (&mut self.terms, &self.extent);
            add_to_searches(searches, extent, (strip, &plan.scaling), &rows, top);
        }
        Ok(())
    }

    /// Ends a look, and returns whether all strips have to be passed again.
    pub(crate) fn next_look(&mut self) -> bool {
        if !self.is_measured {
            self.is_measured = true;
            if let Some(gain) = &mut self.gain {
                gain.sample.begin(&self.extent);
            }
            if let Some(white) = &mut self.white {
                white.begin(&self.extent);
            }
            if let Some(search) = &mut self.albedo {
                search.begin_white(&self.extent);
            }
            return true;
        }
        let gain = self.gain.iter_mut().map(|gain| gain.sample.end_look());
        let terms = self.terms.iter_mut().map(|(_, search)| search);
        let albedo = self
            .albedo
            .iter_mut()
            .filter_map(AlbedoSearch::white_search);
        let whites = self.white.iter_mut().chain(terms).chain(albedo);
        // All of them, though one is enough to look again.
        gain.chain(whites.map(Sample::end_look))
            .fold(false, |is_open, open| is_open | open)
    }

    /// The results, after the last look.
    pub(crate) fn found(self) -> StripChoice {
        let terms = self.terms.into_iter();
        StripChoice {
            gain: self.gain.map(GainSearch::gain),
            white_level: self
                .white
                .map(|sample| white_of(sample.percentile(WHITE_PERCENT))),
            term_white_levels: terms
                .map(|(name, sample)| (name, sample.percentile(WHITE_PERCENT).unwrap_or(1.0)))
                .collect(),
            albedo: self.albedo.and_then(AlbedoSearch::found),
        }
    }
}

impl StripChoice {
    /// `scaling` with open settings replaced by the results; levels given for kinds of light stay.
    pub(crate) fn given(&self, mut scaling: ScalingParams) -> ScalingParams {
        if let Some(gain) = self.gain {
            scaling.curvature_gain = Adaptive::Fixed(gain);
        }
        if let Some(white) = self.white_level {
            scaling.white_level = Adaptive::Fixed(white);
        }
        let found = self.term_white_levels.iter().copied();
        scaling.term_white_levels = scaling.term_white_levels.or(found);
        scaling
    }
}
