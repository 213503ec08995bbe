//! What a frame went through: the passes that ran, with their time and their reason, what was chosen, what had nothing to do,
//! and what was not made.

use super::timings::NORMALS;
use crate::command::chosen::Chosen;
use crate::plan::Decision;
use crate::stages::stages;
use std::time::Duration;

/// The lines of --explain, of a frame whose passes are `ran` and whose plans decided so; those of `idle` had nothing to do,
/// by these counts.
pub(super) fn lines(
    ran: &[(&'static str, Duration)],
    decisions: &[Decision],
    chosen: &Chosen,
    idle: &[(&'static str, String)],
    is_verbose: bool,
) -> Vec<String> {
    let mut lines: Vec<String> = ran
        .iter()
        .map(|(pass, took)| {
            let ms = format!("{:.1} ms", 1e3 * took.as_secs_f64());
            line("ran", pass, &ms, &reasons(pass, ran, decisions))
        })
        .collect();
    let counts = idle.iter();
    lines.extend(counts.map(|(pass, count)| line("idle", pass, "", count)));
    let choices = chosen.in_words();
    if !choices.is_empty() {
        lines.push(line("chose", "", "", &choices));
    }
    if is_verbose {
        let mut left_out: Vec<&Decision> = Vec::new();
        for decision in decisions.iter().filter(|decision| !decision.kept) {
            // Another plan of the same frame, for a further map, may have made it.
            let is_made = decisions.iter().any(|d| d.kept && d.step == decision.step);
            if !is_made && !left_out.iter().any(|known| known.step == decision.step) {
                left_out.push(decision);
            }
        }
        lines.extend(
            left_out
                .iter()
                .map(|d| line("-", d.step, "", &format!("not made: {}", d.reason))),
        );
    }
    lines
}

fn line(verdict: &str, pass: &str, time: &str, why: &str) -> String {
    let line = format!("{verdict:<6}{pass:<22} {time:>10}  {why}");
    line.trim_end().into()
}

/// Why a pass ran: the reason of its step, or those of its steps by their names, but for steps that are passes of their own.
fn reasons(pass: &str, ran: &[(&'static str, Duration)], decisions: &[Decision]) -> String {
    let reason = |step: &str| {
        let kept = decisions.iter().find(|d| d.kept && d.step == step);
        kept.map(|decision| &decision.reason)
    };
    if pass == NORMALS {
        return "the files hold none".into();
    }
    if let Some(reason) = reason(pass) {
        return reason.clone();
    }
    let Some(stage) = stages().find(|stage| stage.name == pass) else {
        return String::new();
    };
    let is_pass = |step: &str| ran.iter().any(|(name, _)| *name == step);
    let steps = stage.steps.iter().filter(|step| !is_pass(step.name));
    let reasons = steps.filter_map(|step| Some(format!("{}: {}", step.name, reason(step.name)?)));
    let reasons: Vec<_> = reasons.collect();
    match reasons.is_empty() {
        true => "for what follows".into(),
        false => reasons.join("; "),
    }
}
