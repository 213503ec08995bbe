//! Settings that trade quality for time, each on its ladder. Looks are no trades: they stay as they are.

use super::subject::{BACKEND, ReportSubject, Variation};
use crate::command::commands::Command;
use crate::params::{SampleCount, Scale, Solver};

/// The most explicit steps worth a try.
const MOST_STEPS: f64 = 400.0;

/// A setting with the values worth a try, the coarsest first; the best stands for the truth, and what lies between it and
/// `half` for the error of that.
pub(super) struct Ladder {
    pub(super) setting: &'static str,
    pub(super) rungs: &'static [&'static str],
    half: &'static str,
    best: &'static str,
}

/// The ladders of a command on its frame.
pub(super) fn ladders(subject: &ReportSubject) -> Vec<Ladder> {
    let shape = &subject.command.work().args().flags.params.shape;
    let plan = subject.plan(&subject.command);
    let diffuses = plan.as_ref().map_or(shape.diffusion_time() > 0.0, |plan| {
        plan.stages().contains(&"diffusion")
    });
    let steps = shape.diffusion_time() / f64::from(shape.time_step);
    let has_steps = !matches!(shape.scale, Scale::Mixed(_)) && steps <= MOST_STEPS;
    let is_expanded = diffuses && has_steps && shape.solver == Solver::Chebyshev;
    let is_relit = plan.is_some_and(|plan| plan.relighting().is_some());
    let samples = subject
        .command
        .work()
        .light()
        .map(|args| args.params().samples);
    let samples = samples.filter(|_| is_relit && subject.light.environment.is_some());
    let is_sampled = samples.is_some_and(|samples| samples != SampleCount::Fixed(0));
    let makes = |map: &str| match &subject.command {
        Command::Map(args) | Command::Normals(args) => {
            args.parts().iter().any(|part| part.name.starts_with(map))
        }
        _ => false,
    };
    let other = subject.other_backend();
    #[rustfmt::skip] // A row each: when, setting, rungs, half the effort of the truth, and the truth.
    let rows: [(bool, _, &[_], _, _); 9] = [
        (diffuses, "tolerance", &["0.1", "0.01", "0.001"], "1e-5", "1e-6"),
        (is_expanded, "solver", &["explicit"], "chebyshev", "chebyshev"),
        (is_sampled, "samples", &["12", "54", "100", "400", "1600", "auto"], "2048", "4096"),
        (samples == Some(SampleCount::Auto), "light-error", &["8", "1"], "", ""),
        (subject.is_specular(), "search-steps", &["16", "32", "64", "256"], "512", "1024"),
        (makes("height"), "height-tolerance", &["1e-2", "1e-3", "1e-5"], "3e-6", "1e-6"),
        (makes("occlusion"), "occlusion-slices", &["2", "4", "16"], "32", "64"),
        (other == Some("gpu"), BACKEND, &["gpu"], "", ""),
        (other == Some("cpu"), BACKEND, &["cpu"], "", ""),
    ];
    let rows = rows.into_iter().filter(|(is_traded, ..)| *is_traded);
    let ladder = |(_, setting, rungs, half, best)| Ladder {
        setting,
        rungs,
        half,
        best,
    };
    rows.map(ladder).collect()
}

/// The changes to the best of every ladder, and to half its effort. Where samples are as many as `samples`, they stand for
/// the truth.
pub(super) fn references(ladders: &[Ladder], samples: u32) -> [Variation; 2] {
    let of = |value: fn(&Ladder) -> &str, samples: u32| Variation {
        settings: ladders
            .iter()
            .filter(|ladder| !value(ladder).is_empty())
            .map(|ladder| match ladder.setting {
                "samples" => ("samples", samples.to_string()),
                setting => (setting, value(ladder).to_string()),
            })
            .collect(),
        without: None,
    };
    [
        of(|ladder| ladder.best, samples),
        of(|ladder| ladder.half, samples / 2),
    ]
}
