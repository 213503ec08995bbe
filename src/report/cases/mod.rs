//! Cases whose answers are known: surfaces and light in closed form, invariances, hostile values. Each is checked for being
//! right, not for being bounded.

mod light;
mod shape;

use super::text::scientific;
use crate::error::Result;
use crate::frame::{Frame, Plane};
use serde::Serialize;
use std::panic::catch_unwind;

/// A case: what is measured, what it should be, and how far off it may be.
pub(super) struct Case {
    name: &'static str,
    truth: &'static str,
    within: f64,
    /// Why it is known not to be met, if it is.
    miss: Option<&'static str>,
    found: fn() -> Result<f64>,
}

/// A table of cases, a row each: name, truth, the error allowed, and what finds the error. What is known to be missed says
/// why.
macro_rules! table {
    ($($name:literal, $truth:literal, $within:literal => $found:expr $(, missed: $why:literal)?;)*) => {
        vec![$($crate::report::cases::Case {
            name: $name,
            truth: $truth,
            within: $within,
            miss: None$(.or(Some($why)))?,
            found: || $found,
        }),*]
    };
}
use table;

/// A case with what was found.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct CaseResult {
    pub name: &'static str,
    pub truth: &'static str,
    /// The error allowed.
    pub within: f64,
    /// The error found; none for a panic or a refusal.
    pub found: Option<f64>,
    /// Why it is known not to be met, if it is.
    pub miss: Option<&'static str>,
    /// Whether it is met, or missed as declared.
    pub is_as_declared: bool,
}

impl Case {
    /// Runs it; a panic fails this case alone.
    fn run(&self) -> CaseResult {
        let found = catch_unwind(self.found);
        let found = found.ok().and_then(Result::ok);
        // NaN is within nothing.
        let is_met = found.is_some_and(|found| found <= self.within);
        CaseResult {
            name: self.name,
            truth: self.truth,
            within: self.within,
            found,
            miss: self.miss,
            is_as_declared: is_met != self.miss.is_some(),
        }
    }
}

/// Runs all cases; `progress` is called with the name of each.
pub(crate) fn all(progress: &dyn Fn(&str)) -> Vec<CaseResult> {
    let cases = shape::cases().into_iter().chain(light::cases());
    let results = cases.map(|case| {
        progress(case.name);
        case.run()
    });
    results.collect()
}

/// The table of results, line by line.
pub(crate) fn lines(results: &[CaseResult]) -> Vec<String> {
    let row = |case: &CaseResult| {
        let found = case.found.map_or("failed".into(), scientific);
        let verdict = match (case.is_as_declared, case.miss) {
            (true, None) => "right".to_string(),
            (true, Some(why)) => format!("known miss: {why}"),
            (false, None) => "WRONG".to_string(),
            (false, Some(_)) => "MET, though declared a miss".to_string(),
        };
        let within = scientific(case.within);
        format!(
            "{:<52} {:<62} {within:>8} {found:>8}  {verdict}",
            case.name, case.truth
        )
    };
    let wrong = results.iter().filter(|case| !case.is_as_declared).count();
    let misses = results.iter().filter(|case| case.miss.is_some()).count();
    let head = format!(
        "{:<52} {:<62} {:>8} {:>8}",
        "case", "truth", "within", "found"
    );
    let end = match wrong {
        0 => format!(
            "{} cases, {misses} of them known misses: all as declared",
            results.len()
        ),
        _ => format!("{wrong} of {} cases did not end as declared", results.len()),
    };
    [head]
        .into_iter()
        .chain(results.iter().map(row))
        .chain([end])
        .collect()
}

/// The pixels of a picture, row by row.
fn pixels(width: usize, height: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// The largest of what `off` gives over the covered pixels; NaN if one is, or if there is none.
fn worst(frame: &Frame, off: impl Fn(usize, usize) -> Option<f64>) -> f64 {
    let mask = &frame.mask;
    let pixels = (0..mask.height()).flat_map(|y| mask.runs(y).flatten().map(move |x| (x, y)));
    let found = pixels.filter_map(|(x, y)| off(x, y));
    found.reduce(larger).unwrap_or(f64::NAN).abs()
}

/// The largest difference of two planes; NaN if a sample is.
fn apart(a: &Plane, b: &Plane) -> f64 {
    let both = a.samples().iter().zip(b.samples());
    both.map(|(a, b)| f64::from(a - b)).fold(0.0, larger)
}

/// The larger of two errors, of either sign; NaN if one is.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else {
        a.abs().max(b.abs())
    }
}

/// The correlation of two series.
fn correlation(pairs: &[[f64; 2]]) -> f64 {
    let count = pairs.len() as f64;
    let mean = |i: usize| pairs.iter().map(|pair| pair[i]).sum::<f64>() / count;
    let means = [mean(0), mean(1)];
    let product = |i: usize, j: usize| -> f64 {
        let terms = pairs
            .iter()
            .map(|pair| (pair[i] - means[i]) * (pair[j] - means[j]));
        terms.sum()
    };
    product(0, 1) / (product(0, 0) * product(1, 1)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn a_case_that_fails_is_wrong() {
        let case = |found, miss| Case {
            name: "a case",
            truth: "0",
            within: 1.0,
            miss,
            found,
        };
        assert!(case(|| Ok(1.0), None).run().is_as_declared);
        let failed: [fn() -> Result<f64>; 4] = [
            || Ok(1.1),
            || Ok(f64::NAN),
            || Err(Error::Cancelled),
            || panic!("on purpose"),
        ];
        for found in failed {
            assert!(!case(found, None).run().is_as_declared);
            assert!(case(found, Some("known")).run().is_as_declared);
        }
        assert!(!case(|| Ok(0.0), Some("known")).run().is_as_declared);
    }
}
