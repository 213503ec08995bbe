//! Prefiltered maps against sums over lights.

use super::ENOUGH;
use super::lit::{Bench, Difference, References, Surface};
use crate::Result;
use crate::params::{Method, WarpBy};
use crate::report::timing::Times;
use serde::Serialize;

/// What a prefiltered map gives in place of a sum.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Row {
    pub surface: Surface,
    /// How light is altered: where it is warped, the one look-up is.
    pub method: Method,
    pub difference: Difference,
    /// Time of filtering, once for a sequence.
    pub prefilter: Times,
    /// Time of lighting: a look-up per pixel.
    pub relight: Times,
    /// Time of the reference's sum.
    pub reference: Times,
    /// Whether the difference is [`ENOUGH`] in 99 pixels of 100.
    pub serves: bool,
}

/// Both surfaces, plain and warped.
pub(crate) fn rows(bench: &Bench, references: &References) -> Result<Vec<Row>> {
    let rows = references.all().iter().map(|reference| {
        let params = reference
            .surface
            .params(reference.method, WarpBy::Lookups, 0);
        let picture = bench.in_environment(params)?;
        let difference = reference.difference(&picture.color, bench.frame);
        Ok(Row {
            surface: reference.surface,
            method: reference.method,
            difference,
            prefilter: picture.environment.expect("maps are filtered first"),
            relight: picture.relight,
            reference: reference.relight,
            serves: difference.errors.p99 < ENOUGH,
        })
    });
    rows.collect()
}
