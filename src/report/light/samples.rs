//! Light from an environment by samples, with either equation of light warping, and by prefiltered maps.

use super::ENOUGH;
use super::lit::{Difference, LitFrame, LitMaterial, Reference, References};
use crate::Result;
use crate::params::{Method, WarpBy};
use crate::report::pareto;
use crate::report::timing::Times;
use serde::Serialize;

/// Numbers of samples tried: powers of four, and the number in the paper's pictures.
const COUNTS: [u32; 8] = [1, 4, 16, 54, 64, 256, 1024, 4096];
/// Numbers tried for both equations.
const COUNTS_OF_EQUATIONS: [u32; 5] = [16, 64, 256, 1024, 4096];

/// Results of one number of samples.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Sample {
    pub count: u32,
    pub difference: Difference,
    pub relight: Times,
}

/// Results of one number of lights.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct SampleRow {
    #[serde(flatten)]
    pub sample: Sample,
    /// Time of the median cut, once per sequence.
    pub cut: Times,
    /// Whether no other number is both faster and more accurate for 99 of 100 pixels.
    pub on_front: bool,
}

/// All numbers for one material and method.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Sweep {
    pub surface: LitMaterial,
    pub method: Method,
    pub reference: Times,
    /// Largest error of the reference's sums against double precision.
    pub reference_rounding: f64,
    /// By increasing number.
    pub rows: Vec<SampleRow>,
    /// The fewest lights that reach [`ENOUGH`] for 99 of 100 pixels.
    pub enough: Option<u32>,
}

/// A sample, and the preparation time of its environment.
fn sample(
    bench: &LitFrame,
    reference: &Reference,
    warp_by: WarpBy,
    count: u32,
) -> Result<(Sample, Times)> {
    let params = reference.surface.params(reference.method, warp_by, count);
    let picture = bench.in_environment(params)?;
    let sample = Sample {
        count,
        difference: reference.difference(&picture.color, bench.frame),
        relight: picture.relight,
    };
    Ok((sample, picture.environment.unwrap_or(picture.relight)))
}

/// Tries every number against every reference.
pub(super) fn sweeps(bench: &LitFrame, references: &References) -> Result<Vec<Sweep>> {
    let sweep = |reference: &Reference| {
        let rows = COUNTS.into_iter().map(|count| {
            let (sample, cut) = sample(bench, reference, WarpBy::Lights, count)?;
            Ok(SampleRow {
                sample,
                cut,
                on_front: false,
            })
        });
        let mut rows = rows.collect::<Result<Vec<SampleRow>>>()?;
        let error = |row: &SampleRow| row.sample.difference.errors.p99;
        let place = |row: &SampleRow| [row.sample.relight.min, error(row)];
        pareto::mark(&mut rows, place, |row| &mut row.on_front);
        let enough = rows.iter().find(|row| error(row) < ENOUGH);
        Ok(Sweep {
            surface: reference.surface,
            method: reference.method,
            reference: reference.relight,
            reference_rounding: reference.rounding,
            enough: enough.map(|row| row.sample.count),
            rows,
        })
    };
    references.all().iter().map(sweep).collect()
}

/// Both equations of light warping for one material.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Equations {
    pub surface: LitMaterial,
    /// Even directions with every look-up warped ([LW] equation 1).
    pub lookups: Vec<Sample>,
    /// Lights by median cut, unwarped and weighted by the Jacobian (equation 2).
    pub lights: Vec<Sample>,
}

/// Measures equation 1 against the references, up to `most` look-ups; `samples` hold the results of equation 2.
pub(super) fn equations(
    bench: &LitFrame,
    references: &References,
    samples: &[Sweep],
    most: u32,
) -> Result<Vec<Equations>> {
    let warped = samples.iter().filter(|sweep| sweep.method == Method::Warp);
    let equations = warped.map(|sweep| {
        let reference = references.of(sweep.surface, Method::Warp);
        let counts = COUNTS_OF_EQUATIONS
            .into_iter()
            .filter(|&count| count <= most);
        let lookups = counts.map(|count| Ok(sample(bench, reference, WarpBy::Lookups, count)?.0));
        let lights = sweep.rows.iter().map(|row| row.sample);
        Ok(Equations {
            surface: sweep.surface,
            lookups: lookups.collect::<Result<_>>()?,
            lights: lights
                .filter(|light| COUNTS_OF_EQUATIONS.contains(&light.count))
                .collect(),
        })
    });
    equations.collect()
}

/// A prefiltered map instead of a sum.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Prefiltered {
    pub surface: LitMaterial,
    /// The lighting method; warping applies to the single look-up.
    pub method: Method,
    pub difference: Difference,
    /// Time of filtering, once per sequence.
    pub prefilter: Times,
    /// Time of lighting with one look-up per pixel.
    pub relight: Times,
    /// Time of the reference's sum.
    pub reference: Times,
    /// Whether the difference reaches [`ENOUGH`] for 99 of 100 pixels.
    pub serves: bool,
}

/// Prefiltered maps for both materials, plain and warped.
pub(super) fn prefiltered(bench: &LitFrame, references: &References) -> Result<Vec<Prefiltered>> {
    let rows = references.all().iter().map(|reference| {
        let (sample, prefilter) = sample(bench, reference, WarpBy::Lookups, 0)?;
        Ok(Prefiltered {
            surface: reference.surface,
            method: reference.method,
            difference: sample.difference,
            prefilter,
            relight: sample.relight,
            reference: reference.relight,
            serves: sample.difference.errors.p99 < ENOUGH,
        })
    });
    rows.collect()
}
