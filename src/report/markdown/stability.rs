//! Stiff and extreme cases on the page.

use super::super::stability::{Bounds, CaseResult, Verdict};
use super::table;

pub(super) fn section(cases: &[CaseResult]) -> String {
    let wrong = cases.iter().filter(|case| !case.as_expected).count();
    let verdict = match wrong {
        0 => format!(
            "All {} cases end as declared; none in a NaN or a panic.",
            cases.len()
        ),
        n => format!("**{n} of {} cases do not end as declared.**", cases.len()),
    };
    let rows = cases.iter().map(|case| {
        let (outcome, what) = outcome(&case.verdict);
        let outcome = if case.as_expected {
            outcome.to_string()
        } else {
            format!("**{outcome}**, not {:?}", case.expected)
        };
        vec![case.name.into(), case.done.into(), outcome, what]
    });
    format!(
        "## Stability\n\n{verdict}\n\n{}",
        table(
            &[
                "case",
                "what is done",
                "outcome",
                "values and bounds, or what is said"
            ],
            rows
        )
    )
}

fn outcome(verdict: &Verdict) -> (&'static str, String) {
    let values = |b: &Bounds| {
        format!(
            "|g| {:.3e} of {:.3e}, |trace| {:.3e} of {:.3e}",
            b.slope, b.slope_bound, b.trace, b.trace_bound
        )
    };
    match verdict {
        Verdict::Bounded(bounds) => ("bounded", values(bounds)),
        Verdict::Lit { largest, bound } => ("lit", format!("{largest:.3e} of {bound:.3e}")),
        Verdict::Drawn {
            ink,
            bounds: [least, most],
        } => ("drawn", format!("ink {ink:.4} of {least} to {most}")),
        Verdict::Warned { message, .. } | Verdict::Told { message, .. } => {
            ("warned", message.clone())
        }
        Verdict::Refused { message } => ("refused", message.clone()),
        Verdict::Failed { what } => ("failed", what.clone()),
    }
}
