//! One case, and tables of them.

use super::{Case, Expected, Verdict};
use crate::Result;

/// A table of cases, one per row.
macro_rules! cases {
    ($($case:expr;)*) => { vec![$($case),*] };
}
pub(super) use cases;

pub(super) fn case(
    name: &'static str,
    done: &'static str,
    expected: Expected,
    run: impl Fn() -> Result<Verdict> + 'static,
) -> Case {
    Case {
        name,
        done,
        expected,
        run: Box::new(run),
    }
}
