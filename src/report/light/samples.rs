//! How many samples of an environment are enough.

use super::ENOUGH;
use super::lit::{Bench, Difference, Reference, References, Surface};
use crate::Result;
use crate::params::{Method, WarpBy};
use crate::report::pareto;
use crate::report::timing::Times;
use serde::Serialize;

/// Numbers tried: powers of four, and what the paper shows.
pub(crate) const COUNTS: [u32; 8] = [1, 4, 16, 54, 64, 256, 1024, 4096];

/// What one number gives.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Row {
    /// Lights, by median cut.
    pub count: u32,
    pub difference: Difference,
    /// Time of the lights' making, once for a sequence.
    pub cut: Times,
    pub relight: Times,
    /// Whether no other number is both faster and better in 99 pixels of 100.
    pub on_front: bool,
}

/// All numbers for one surface and method.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Sweep {
    pub surface: Surface,
    pub method: Method,
    pub reference: Times,
    /// Largest error of the reference's sums against double precision.
    pub reference_rounding: f64,
    /// What was tried, by growing number.
    pub rows: Vec<Row>,
    /// The fewest lights that are [`ENOUGH`] in 99 pixels of 100.
    pub enough: Option<u32>,
}

/// Tries every number against every reference.
pub(crate) fn sweeps(bench: &Bench, references: &References) -> Result<Vec<Sweep>> {
    let all = references.all().iter();
    all.map(|reference| sweep(bench, reference)).collect()
}

fn sweep(bench: &Bench, reference: &Reference) -> Result<Sweep> {
    let Reference {
        surface, method, ..
    } = *reference;
    let row = |count: u32| {
        let params = surface.params(method, WarpBy::Lights, count);
        let picture = bench.in_environment(params)?;
        Ok(Row {
            count,
            difference: reference.difference(&picture.color, bench.frame),
            cut: picture.environment.expect("lights are cut first"),
            relight: picture.relight,
            on_front: false,
        })
    };
    let mut rows = COUNTS.into_iter().map(row).collect::<Result<Vec<Row>>>()?;
    let points: Vec<_> = rows
        .iter()
        .map(|row| [row.relight.min, row.difference.errors.p99])
        .collect();
    for (row, on_front) in rows.iter_mut().zip(pareto::front(&points)) {
        row.on_front = on_front;
    }
    let enough = rows.iter().find(|row| row.difference.errors.p99 < ENOUGH);
    Ok(Sweep {
        surface,
        method,
        reference: reference.relight,
        reference_rounding: reference.rounding,
        enough: enough.map(|row| row.count),
        rows,
    })
}
