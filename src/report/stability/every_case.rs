//! Runs every stiff and extreme case of the report: each ends as declared, none in a NaN or a panic.

use super::{Expected, Verdict, all};

#[test]
fn every_case_ends_as_declared() {
    let results: Vec<_> = all().iter().map(|case| case.run()).collect();
    for result in &results {
        println!("{:<28} {:?}", result.name, result.verdict);
    }
    let wrong: Vec<_> = results.iter().filter(|r| !r.as_expected).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    // A shortened list would pass silently.
    assert!(results.len() >= 100, "only {} cases", results.len());
    let count = |expected| results.iter().filter(|r| r.expected == expected).count();
    assert!(count(Expected::Warned) >= 4 && count(Expected::Refused) >= 12);
    assert!(count(Expected::Lit) >= 36 && count(Expected::Drawn) >= 24);
}

#[test]
fn names_are_unique() {
    let mut names: Vec<_> = all().iter().map(|case| case.name).collect();
    names.sort_unstable();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
}

#[test]
fn unstable_steps_are_refused_with_the_reason() {
    let cases = all();
    let above = cases
        .iter()
        .filter(|case| case.name.starts_with("dt ") && case.expected == Expected::Refused);
    let mut refused = 0;
    for result in above.map(|case| case.run()) {
        let Verdict::Refused { message } = &result.verdict else {
            panic!("{result:?}")
        };
        assert!(
            message.contains("time_step") && message.contains("stable only"),
            "{message}"
        );
        refused += 1;
    }
    assert!(refused >= 4, "only {refused} cases");
}

/// At the stability limit a checkerboard reverses with every step and does not decay at the centre of the picture: it
/// stays bounded, and far from gone.
#[test]
fn at_the_limit_a_checkerboard_hardly_decays() {
    let cases = all();
    let at_limit = cases
        .iter()
        .find(|case| case.name == "dt at the limit")
        .unwrap();
    let Verdict::Bounded(bounds) = at_limit.run().verdict else {
        panic!("not bounded")
    };
    assert!(bounds.slope > 0.25 * bounds.slope_bound, "{bounds:?}");
}
