//! The page's section on stiff and extreme cases.

use super::{bold_if, table};
use crate::report::stability::{Bounds, CaseResult, Verdict};

pub(super) fn section(cases: &[CaseResult]) -> String {
    let (all, wrong) = (
        cases.len(),
        cases.iter().filter(|case| !case.as_expected).count(),
    );
    let verdict = match wrong {
        0 => format!("All {all} cases end as declared; none in a NaN or a panic."),
        n => format!("**{n} of {all} cases do not end as declared.**"),
    };
    let but = |case: &CaseResult| match case.as_expected {
        true => String::new(),
        false => format!(", not {:?}", case.expected),
    };
    let cases = cases.iter().map(|case| (case, outcome(&case.verdict)));
    let table = table!(cases, (case, (outcome, details)) => {
        "case": case.name,
        "what is done": case.done,
        "outcome": bold_if(!case.as_expected, outcome) + &but(case),
        "values and bounds, or what is said": details,
    });
    format!("## Stability\n\n{verdict}\n\n{table}")
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
        Verdict::Warned { message, .. } | Verdict::WarnedPicture { message, .. } => {
            ("warned", message.clone())
        }
        Verdict::Refused { message } => ("refused", message.clone()),
        Verdict::Failed { what } => ("failed", what.clone()),
    }
}
