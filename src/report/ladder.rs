//! Settings that trade quality for time, each on its ladder. Looks are no trades: they stay as they are.

use super::subject::{BACKEND, Subject, Variation};
use crate::command::commands::Command;
use crate::params::{Samples, Scale, Solver};

/// The most explicit steps worth a try.
const MOST_STEPS: f64 = 400.0;

/// A setting with the values worth a try, the coarsest first; the best stands for the truth, and what lies between it and
/// `half` for the error of that.
pub(super) struct Ladder {
    pub(super) setting: &'static str,
    pub(super) rungs: Vec<String>,
    best: String,
    half: String,
}

impl Ladder {
    fn new(setting: &'static str, rungs: &[&str], half: &str, best: &str) -> Self {
        Self {
            setting,
            rungs: rungs.iter().map(ToString::to_string).collect(),
            best: best.into(),
            half: half.into(),
        }
    }
}

/// The ladders of a command on its frame.
pub(super) fn ladders(subject: &Subject) -> Vec<Ladder> {
    let mut found = Vec::new();
    let params = &subject.command.work().args().flags.params;
    let shape = &params.shape;
    let plan = subject.plan(&subject.command);
    let diffuses = plan.as_ref().map_or(shape.diffusion_time() > 0.0, |plan| {
        plan.stages().contains(&"diffusion")
    });
    if diffuses {
        found.push(Ladder::new(
            "tolerance",
            &["0.1", "0.01", "0.001"],
            "1e-5",
            "1e-6",
        ));
        let steps = shape.diffusion_time() / f64::from(shape.time_step);
        let has_steps = !matches!(shape.scale, Scale::Mixed(_)) && steps <= MOST_STEPS;
        if has_steps && shape.solver == Solver::Chebyshev {
            found.push(Ladder::new(
                "solver",
                &["explicit"],
                "chebyshev",
                "chebyshev",
            ));
        }
    }
    if let Some(relit) = subject.command.work().light().map(|args| args.params())
        && plan.as_ref().is_some_and(|plan| plan.relighting.is_some())
    {
        let light = &subject.light;
        let is_sampled = light.environment.is_some() && relit.samples != Samples::Fixed(0);
        if is_sampled {
            let rungs = ["12", "54", "100", "400", "1600", "auto"];
            found.push(Ladder::new("samples", &rungs, "2048", "4096"));
        }
        if is_sampled && relit.samples == Samples::Auto {
            found.push(Ladder::new("light-error", &["8", "1"], "", ""));
        }
    }
    if subject.is_specular() {
        found.push(Ladder::new(
            "search-steps",
            &["16", "32", "64", "256"],
            "512",
            "1024",
        ));
    }
    if let Command::Map(args) | Command::Normals(args) = &subject.command {
        let parts = args.parts();
        let makes = |name: &str| parts.iter().any(|part| part.name.starts_with(name));
        if makes("height") {
            let rungs = ["1e-2", "1e-3", "1e-5"];
            found.push(Ladder::new("height-tolerance", &rungs, "3e-6", "1e-6"));
        }
        if makes("occlusion") {
            found.push(Ladder::new(
                "occlusion-slices",
                &["2", "4", "16"],
                "32",
                "64",
            ));
        }
    }
    if let Some(other) = subject.other_backend() {
        found.push(Ladder::new(BACKEND, &[other], "", ""));
    }
    found
}

/// The changes to the best of every ladder, and to half its effort. Where samples are as many as `samples`, they stand for
/// the truth.
pub(super) fn references(ladders: &[Ladder], samples: u32) -> [Variation; 2] {
    let of = |value: fn(&Ladder) -> &String, samples: u32| Variation {
        settings: ladders
            .iter()
            .filter(|ladder| !value(ladder).is_empty())
            .map(|ladder| match ladder.setting {
                "samples" => ("samples", samples.to_string()),
                setting => (setting, value(ladder).clone()),
            })
            .collect(),
        without: None,
    };
    [
        of(|ladder| &ladder.best, samples),
        of(|ladder| &ladder.half, samples / 2),
    ]
}
