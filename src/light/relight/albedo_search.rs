//! The estimate of the albedo, from all pixels of a picture.

use super::albedo::{fitted, luminance_over};
#[cfg(any(feature = "cli", feature = "gpu"))]
use crate::frame::Extent;
use crate::frame::percentile::{InLooks, PictureSample};
use crate::frame::{Frame, Vector3Planes};
use crate::light::albedo::{AlbedoEstimate, ShadingFit};
use crate::plan::execution::Execution;
use crate::plan::search::{ChosenFrom, Search, Settle};
use crate::shape::auto_levels::WHITE_PERCENT;
use crate::shape::auto_levels::cpu::white_of;

/// Luminance that the albedo's white level is mapped to: that of paper.
const BRIGHT: f32 = 0.8;

/// A search for the estimate: the picture divided by its best-fitting shading, scaled so that all but a few pixels are
/// darker than paper. White where the picture is black.
#[derive(Default)]
pub(crate) struct AlbedoSearch {
    fit: ShadingFit,
    /// The light over the fitted shading, for the white level.
    white: PictureSample<f32>,
}

impl AlbedoSearch {
    fn fit(&mut self, from: &ChosenFrom, normal: &Vector3Planes) {
        self.fit = fitted(self.fit, from, normal);
    }

    fn add(&mut self, from: &ChosenFrom, normal: &Vector3Planes) {
        let bright = luminance_over(self.fit.solved(), from.frame, normal);
        from.add_to(&mut self.white, bright);
    }

    /// The estimate, after the last look.
    pub(super) fn estimate(self) -> AlbedoEstimate {
        AlbedoEstimate {
            shading: self.fit.solved(),
            factor: BRIGHT / white_of(self.white.percentile(WHITE_PERCENT)),
        }
    }
}

impl Search for AlbedoSearch {
    fn survey(&mut self, run: &Execution) {
        let from = run.chosen_from();
        self.fit(&from, normals(run, from.frame));
    }

    fn look(&mut self, run: &mut Execution) {
        let from = run.chosen_from();
        self.add(&from, normals(run, from.frame));
    }

    fn samples(&mut self) -> Vec<&mut dyn InLooks> {
        vec![&mut self.white]
    }

    fn found(self: Box<Self>) -> Settle {
        let estimate = self.estimate();
        Box::new(move |plan| plan.set_estimate(estimate))
    }
}

/// The normals of a frame, which the run may have been handed.
fn normals<'a>(run: &'a Execution, frame: &'a Frame) -> &'a Vector3Planes {
    run.normals.as_ref().unwrap_or(&frame.normal)
}

/// The estimate of the pixels of a frame.
#[cfg(any(feature = "cli", feature = "gpu"))]
pub(crate) fn estimated(from: &ChosenFrom) -> AlbedoEstimate {
    let (mut search, normal) = (AlbedoSearch::default(), &from.frame.normal);
    search.fit(from, normal);
    search.white.begin(&Extent::of(&from.mask));
    while search.white.is_open() {
        search.add(from, normal);
        search.white.end_look();
    }
    search.estimate()
}
