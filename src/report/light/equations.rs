//! The two equations of light warping: every look-up warped ([LW] equation 1), or lights that were
//! sampled before, unwarped and weighed by the Jacobian (equation 2).

use super::lit::{Bench, Difference, Reference, References, Surface};
use super::samples;
use crate::Result;
use crate::params::{Method, WarpBy};
use crate::report::timing::Times;
use serde::Serialize;

/// Numbers tried.
pub(crate) const COUNTS: [u32; 5] = [16, 64, 256, 1024, 4096];

/// What one number of samples gives by one of the two equations.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Sample {
    pub count: u32,
    pub difference: Difference,
    pub relight: Times,
}

/// Both equations for one surface.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Sweep {
    pub surface: Surface,
    /// Equation 1: even directions, looked up at every pixel.
    pub lookups: Vec<Sample>,
    /// Equation 2: lights by median cut.
    pub lights: Vec<Sample>,
}

/// Tries equation 1 against the references, up to `most` look-ups; what equation 2 gives is known from the
/// samples.
pub(crate) fn sweeps(
    bench: &Bench,
    references: &References,
    samples: &[samples::Sweep],
    most: u32,
) -> Result<Vec<Sweep>> {
    let warped = samples.iter().filter(|sweep| sweep.method == Method::Warp);
    warped
        .map(|sweep| {
            let reference = references.of(sweep.surface, Method::Warp);
            let rows = sweep.rows.iter().filter(|row| COUNTS.contains(&row.count));
            Ok(Sweep {
                surface: sweep.surface,
                lookups: lookups(bench, reference, most)?,
                lights: rows
                    .map(|row| Sample {
                        count: row.count,
                        difference: row.difference,
                        relight: row.relight,
                    })
                    .collect(),
            })
        })
        .collect()
}

fn lookups(bench: &Bench, reference: &Reference, most: u32) -> Result<Vec<Sample>> {
    let sample = |count| {
        let params = reference
            .surface
            .params(Method::Warp, WarpBy::Lookups, count);
        let picture = bench.in_environment(params)?;
        Ok(Sample {
            count,
            difference: reference.difference(&picture.color, bench.frame),
            relight: picture.relight,
        })
    };
    let counts = COUNTS.into_iter().filter(|&count| count <= most);
    counts.map(sample).collect()
}
