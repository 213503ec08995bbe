//! White levels: chosen from the whole picture, or given.

use crate::light::enhancement::Subject;
use crate::light::layers::terms::light_terms;
use crate::light::white_search::{TermSearch, WhiteSearch};
use crate::params::{Adaptive, Magnitudes};
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};

/// The white level of the picture, or one for each term of its light.
pub(crate) static AUTO_WHITE: Stage = Stage {
    // A given white level is recorded.
    also_runs: |plan| matches!(plan.scaled(), Some(Subject::Picture | Subject::Lobes)),
    // The kinds of light that are scaled, and their magnitudes.
    depends_on: |plan| {
        let scaling = &plan.scaling;
        let Magnitudes {
            ambient,
            diffuse,
            specular,
        } = scaling.magnitudes();
        let scaled = [ambient, diffuse, specular].map(|magnitude| magnitude.largest() > 0.0);
        let has_ambient = scaling.scaling_ambient.is_some();
        format!(
            "{scaled:?} {has_ambient} {:?} {:?}",
            scaling.white_level, scaling.term_white_levels
        )
    },
    chooses: |plan| match chosen_for(plan)? {
        Subject::Lobes => Some(Box::new(TermSearch::default())),
        _ => Some(Box::new(WhiteSearch::default())),
    },
    reads_normals: false,
    makes: Makes::Picture,
    name: "auto-white",
    steps: &[step("auto-white", &[], decide_white)],
    cpu: choose_white,
    #[cfg(feature = "gpu")]
    gpu: Some(|run| run.choose(choose_white)),
    ..Stage::DEFAULT
};

/// The subject scaled with automatic white levels, if any.
pub(crate) fn chosen_for(plan: &Plan) -> Option<Subject> {
    let chosen = plan.scaling.white_level == Adaptive::Auto;
    let of_light = |subject: &Subject| match subject {
        Subject::Picture => !plan.available.light.picture_is_occlusion,
        Subject::Lobes => true,
        Subject::Groups => false,
    };
    plan.scaled().filter(|subject| chosen && of_light(subject))
}

fn decide_white(plan: &Plan) -> Verdict {
    let Some(enhancement) = plan.enhancement() else {
        return plan.left_out("no light is asked for");
    };
    match enhancement.subject {
        _ if chosen_for(plan).is_some() => Verdict::runs("--white-level auto"),
        Subject::Groups => plan.left_out("intensity is the cosine to the light"),
        Subject::Picture if plan.available.light.picture_is_occlusion => {
            plan.left_out("1: the picture is occlusion")
        }
        _ => plan.left_out(format!("--white-level {}", plan.scaling.white_level)),
    }
}

fn choose_white(run: &mut Execution) {
    match run.plan.scaled() {
        Some(Subject::Lobes) => choose_term_whites(run),
        _ => choose_picture_white(run),
    }
}

fn choose_picture_white(run: &mut Execution) {
    let white = match run.plan.scaling.white_level {
        Adaptive::Fixed(level) => level,
        // Ambient occlusion is the share of 1 that arrives.
        Adaptive::Auto if run.frame.light.picture_is_occlusion => 1.0,
        Adaptive::Auto => run.copied_or("white", Some(""), |run| {
            run.timed_on(AUTO_WHITE.name, |run| {
                run.searched(WhiteSearch::default()).level()
            })
        }),
    };
    run.made.outcome.white_level = Some(white);
}

fn choose_term_whites(run: &mut Execution) {
    let plan = run.plan;
    let found = match plan.scaling.white_level {
        Adaptive::Auto => {
            let key = plan.key(AUTO_WHITE.name);
            run.copied_or("white levels of terms", Some(key), |run| {
                run.timed_on(AUTO_WHITE.name, |run| {
                    run.searched(TermSearch::default()).levels()
                })
            })
        }
        Adaptive::Fixed(_) => Vec::new(),
    };
    let scaling = &plan.scaling;
    let terms = light_terms(&run.frame.light.lobes, scaling);
    let level = |name| {
        let of_name = found.iter().find(|(term, _)| *term == name);
        let found = of_name.map(|&(_, level)| level);
        let given = match scaling.white_level {
            Adaptive::Fixed(level) => Some(level),
            Adaptive::Auto => None,
        };
        let level = scaling.term_white_levels.of(name).or(given).or(found);
        (name, level.unwrap_or(1.0))
    };
    run.made.outcome.term_white_levels = terms.iter().map(|term| level(term.name)).collect();
}
