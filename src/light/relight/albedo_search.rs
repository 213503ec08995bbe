//! The estimate of the albedo, found a strip at a time.

use super::albedo::{BRIGHT, fitted, luminance_over};
use crate::frame::percentile::Sample;
use crate::frame::{Extent, Frame};
use crate::light::albedo::{AlbedoEstimate, FittedShading, ShadingFit};
use crate::shape::auto_levels::cpu as statistics;
use std::ops::Range;

/// A search for the estimate in a picture that comes some rows at a time, from top to bottom: once for the shading, and
/// as often as a [`Sample`] is looked at for the white level over it.
#[derive(Debug, Clone)]
pub(crate) struct AlbedoSearch {
    fit: ShadingFit,
    /// The fitted shading, and the light over it, for the white level.
    white: Option<(Option<FittedShading>, Sample<f32>)>,
}

impl AlbedoSearch {
    pub(crate) fn new() -> Self {
        Self {
            fit: ShadingFit::default(),
            white: None,
        }
    }

    /// Takes in the rows `rows` of a strip whose first row is row `top` of the picture.
    pub(crate) fn add(&mut self, strip: &Frame, weights: [f32; 3], rows: Range<usize>, top: usize) {
        match &mut self.white {
            None => self.fit = fitted(self.fit, strip, &strip.normal, weights, rows),
            Some((shading, search)) => {
                let bright = luminance_over(*shading, strip, &strip.normal, weights);
                search.add(&strip.mask, rows, top, bright);
            }
        }
    }

    /// Solves for the shading, and begins to search the white level, in a picture with this extent.
    pub(crate) fn begin_white(&mut self, extent: &Extent) {
        let mut search = Sample::default();
        search.begin(extent);
        self.white = Some((self.fit.solved(), search));
    }

    /// The sample for the white level.
    pub(crate) fn white_search(&mut self) -> Option<&mut Sample<f32>> {
        self.white.as_mut().map(|(_, search)| search)
    }

    /// The estimate, at the end.
    pub(crate) fn found(self) -> Option<AlbedoEstimate> {
        let (shading, search) = self.white?;
        Some(AlbedoEstimate {
            shading,
            factor: BRIGHT / statistics::white_of(search.percentile(statistics::WHITE_PERCENT)),
        })
    }
}
