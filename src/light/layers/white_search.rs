//! White levels of the terms of light, found a strip at a time.

use super::cpu::Absent;
use super::terms::light_terms;
use crate::frame::percentile::Sample;
use crate::frame::{Extent, Frame};
use crate::params::ScalingParams;
use std::ops::Range;

/// Adds the luminance of each term in the rows `rows` of a strip, whose first row is row `top` of a picture with this
/// extent, to the sample for its white level; given levels need none.
pub(crate) fn add_to_searches(
    searches: &mut Vec<(&'static str, Sample<f32>)>,
    extent: &Extent,
    (strip, params): (&Frame, &ScalingParams),
    rows: &Range<usize>,
    top: usize,
) {
    let (weights, absent) = (strip.luminance_weights(), Absent::new(strip.mask.width()));
    for term in light_terms(&strip.light.lobes, params) {
        let known = searches.iter().position(|(name, _)| *name == term.name);
        let index = known.unwrap_or_else(|| {
            let mut search = Sample::default();
            search.begin(extent);
            searches.push((term.name, search));
            searches.len() - 1
        });
        let lit = term.lit(weights, &absent);
        searches[index].1.add(&strip.mask, rows.clone(), top, lit);
    }
}
