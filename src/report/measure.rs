//! The runs of a report: the command as given, its ladders, what is left out, and rounds of all of them.

use super::clock::Spent;
use super::difference::{CodeDifference, Codes};
use super::files::files;
use super::ladder::{Ladder, ladders, references};
use super::left_out::{self, parts};
use super::subject::{ReportSubject, Shot, Variation};
use super::timing::{Timed, TimedCost, rounds};
use super::verdict::{mark_front, verdict};
use super::{Asked, HARDLY, LeftOut, On, Pictures, Reference, Report, Tried};
use crate::error::Result;
use crate::light::lights::LightChoice;
use std::time::{Duration, Instant};

/// Seconds that a report may take, and in the light of an environment.
const USUAL_S: [u16; 2] = [15, 45];

/// The share by which a report may overrun its time to get enough rounds.
const GRACE: f64 = 0.15;

/// The share of its time after which no slower setting is tried.
const TRYING: f64 = 0.5;

/// A run that is compared, and timed.
struct TimedRun {
    change: Variation,
    difference: CodeDifference,
    first: Spent,
    chosen: Option<String>,
    /// Whether it is timed in rounds.
    is_timed: bool,
}

/// The ladders of the command, and the truth that they are compared with.
#[derive(Default)]
struct Trades {
    candidates: Vec<TimedRun>,
    same_stages: Vec<String>,
    reference: Option<Reference>,
    error_of_given: CodeDifference,
    /// Of each pixel as given, in levels.
    errors: Vec<f32>,
}

struct Measuring<'a> {
    subject: ReportSubject,
    given: Shot,
    counts: Vec<bool>,
    began: Instant,
    budget: Duration,
    say: &'a dyn Fn(&str),
}

/// Measures a command.
///
/// # Errors
/// As the command.
pub(crate) fn measured(asked: &Asked) -> Result<Report> {
    let began = Instant::now();
    let say = asked.progress;
    let subject = ReportSubject::read(asked.args, asked.typed, asked.number)?;
    let usual = USUAL_S[usize::from(subject.light.environment.is_some())];
    let budget = Duration::from_secs(asked.args.budget.unwrap_or(usual).into());
    say("the command as given");
    // The first run makes memory that further ones use again.
    let first = subject.shot(&Variation::default())?;
    subject.engine.recycle(first.made.outcome);
    let given = subject.shot(&Variation::default())?;
    let mut measuring = Measuring {
        counts: subject.counts(given.size),
        subject,
        given,
        began,
        budget,
        say,
    };
    let trades = measuring.trades()?;
    let parts = measuring.parts()?;
    say("files");
    let files = files(&measuring.subject, &measuring.given, &measuring.counts)?;
    let candidates = trades.candidates.iter().chain(parts.iter().map(|(_, c)| c));
    let candidates: Vec<&TimedRun> = candidates.collect();
    let times = measuring.times(&candidates)?;
    let costs = costs(&candidates, &times);
    let (of_trades, of_parts) = costs.split_at(trades.candidates.len());

    let tried = |flags, error, cost, chosen| Tried {
        flags,
        error,
        cost,
        is_on_front: false,
        chosen,
    };
    let given = TimedCost::of_given(times.given);
    let given = tried(
        String::new(),
        trades.error_of_given,
        given,
        chosen(&measuring.given),
    );
    let rows = trades.candidates.iter().zip(of_trades);
    let others =
        rows.map(|(c, &cost)| tried(c.change.flags(), c.difference, cost, c.chosen.clone()));
    let mut settings: Vec<Tried> = std::iter::once(given).chain(others).collect();
    mark_front(&mut settings);
    let own_error = trades.reference.as_ref().map_or(0.0, |truth| truth.own.p99);
    let of_command = parts.iter().find(|(part, _)| part.is_command);
    let shows = of_command.map(|(_, candidate)| candidate.difference.beyond_2);
    let parts = parts
        .iter()
        .zip(of_parts)
        .map(|((part, candidate), &cost)| LeftOut {
            name: part.name,
            flags: part.flags.clone(),
            change: candidate.difference,
            cost,
        });
    let Measuring { subject, given, .. } = measuring;
    let stages = given.made.outcome.timings.iter();
    let stages = stages.map(|(stage, time)| (*stage, 1e3 * time.as_secs_f64()));
    let before = subject
        .before()
        .filter(|before| before.len() == given.codes.len());
    let (input, mask) = (&asked.args.input, &subject.frame.mask);
    Ok(Report {
        version: env!("CARGO_PKG_VERSION"),
        is_optimised: !cfg!(debug_assertions),
        command: subject.line(),
        frame: On {
            name: input
                .file_name()
                .unwrap_or(input.as_os_str())
                .to_string_lossy()
                .into(),
            width: mask.width(),
            height: mask.height(),
            covered: mask.count(),
        },
        verdict: verdict(&settings, own_error, shows),
        reference: trades.reference,
        settings,
        same_stages: trades.same_stages,
        parts: parts.collect(),
        stages: stages.collect(),
        read: subject.read,
        files,
        trust: times.trust,
        pictures: Pictures {
            size: given.size,
            before,
            after: given.codes,
            error: trades.errors,
        },
        warnings: subject.warnings,
    })
}

impl Measuring<'_> {
    /// What is left of a share of the time.
    fn left(&self, share: f64) -> Duration {
        self.budget
            .mul_f64(share)
            .saturating_sub(self.began.elapsed())
    }

    /// Runs the rungs of all ladders, and the truth.
    fn trades(&mut self) -> Result<Trades> {
        let mut trades = Trades::default();
        let ladders = ladders(&self.subject);
        if ladders.is_empty() {
            return Ok(trades);
        }
        let mut shots = Vec::new();
        for ladder in &ladders {
            shots.extend(self.rungs(ladder, &mut trades.same_stages)?);
        }
        let samples = samples_of_truth(&shots, self.left(TRYING));
        let [best, half] = references(&ladders, samples);
        (self.say)("the same at its best");
        let truth = self.subject.shot(&best)?;
        (self.say)("the same at half its effort");
        let near = self.subject.shot(&half)?;
        let off = |codes: &Codes| CodeDifference::between(&truth.codes, codes, &self.counts);
        trades.reference = Some(Reference {
            flags: best.flags(),
            own: off(&near.codes),
        });
        trades.error_of_given = off(&self.given.codes);
        trades.errors = errors(&truth.codes, &self.given.codes);
        let candidates = shots.into_iter().map(|(change, shot)| TimedRun {
            difference: off(&shot.codes),
            first: shot.used,
            chosen: chosen(&shot),
            change,
            is_timed: true,
        });
        trades.candidates = candidates.collect();
        Ok(trades)
    }

    /// Runs the rungs of a ladder as far as time allows; those that change no stage are only named.
    fn rungs(&mut self, ladder: &Ladder, same: &mut Vec<String>) -> Result<Vec<(Variation, Shot)>> {
        let mut shots = Vec::new();
        let mut slowest = self.given.used.wall_ms;
        for rung in ladder.rungs {
            let change = Variation::setting(ladder.setting, rung);
            if self.subject.is_same(&change) {
                same.push(change.flags());
                continue;
            }
            // The next rung may take four times as long.
            if 4.0 * slowest > 1e3 * self.left(TRYING).as_secs_f64() {
                continue;
            }
            (self.say)(&change.flags());
            let shot = self.subject.shot(&change)?;
            slowest = slowest.max(shot.used.wall_ms);
            shots.push((change, shot));
        }
        Ok(shots)
    }

    /// Leaves each part out in turn.
    fn parts(&mut self) -> Result<Vec<(left_out::Omission, TimedRun)>> {
        let parts = parts(&self.subject, &self.given.made.outcome);
        let without = |part: left_out::Omission| {
            (self.say)(&format!("without {}", part.name));
            let shot = self.subject.shot(&part.change)?;
            let difference = CodeDifference::between(&self.given.codes, &shot.codes, &self.counts);
            self.subject.engine.recycle(shot.made.outcome);
            let candidate = TimedRun {
                change: part.change.clone(),
                difference,
                first: shot.used,
                chosen: None,
                // Nobody would leave out what is needed.
                is_timed: difference.beyond_2 < HARDLY,
            };
            Ok((part, candidate))
        };
        parts.into_iter().map(without).collect()
    }

    fn times(&mut self, candidates: &[&TimedRun]) -> Result<Timed> {
        let timed: Vec<_> = candidates.iter().filter(|c| c.is_timed).collect();
        let first = timed.iter().map(|candidate| candidate.first);
        let first: Vec<Spent> = std::iter::once(self.given.used).chain(first).collect();
        let left = self.left(1.0);
        (self.say)(&format!("times, for {:.0} s", left.as_secs_f64()));
        let as_given = Variation::default();
        rounds(&first, left, self.budget.mul_f64(GRACE), |i| {
            let change = match i {
                0 => &as_given,
                _ => &timed[i - 1].change,
            };
            let shot = self.subject.shot(change)?;
            self.subject.engine.recycle(shot.made.outcome);
            Ok(shot.used)
        })
    }
}

/// The cost of each candidate, in rounds or once.
fn costs(candidates: &[&TimedRun], times: &Timed) -> Vec<TimedCost> {
    let mut in_rounds = times.others.iter();
    let cost = |candidate: &&TimedRun| match candidate.is_timed {
        true => *in_rounds.next().expect("all of these are timed"),
        false => TimedCost::once(candidate.first),
    };
    candidates.iter().map(cost).collect()
}

/// The light that a run chose by itself.
fn chosen(shot: &Shot) -> Option<String> {
    shot.made
        .outcome
        .light_choice
        .as_ref()
        .map(LightChoice::to_string)
}

/// How many samples the truth may have within a time: doubled from 1024 to 4096, by what samples were found to cost.
fn samples_of_truth(shots: &[(Variation, Shot)], within: Duration) -> u32 {
    let of_samples = |(change, shot): &(Variation, Shot)| {
        let (name, value) = change.settings.first()?;
        let count: f64 = (*name == "samples").then(|| value.parse().ok())??;
        Some((count, shot.used.wall_ms))
    };
    let known: Vec<_> = shots.iter().filter_map(of_samples).collect();
    let per_sample = match known[..] {
        [(few, quick), .., (many, slow)] => ((slow - quick) / (many - few)).max(0.0),
        _ => 0.0,
    };
    // The truth, and half of it.
    let fits = |count: &u32| 1.5 * f64::from(*count) * per_sample < 1e3 * within.as_secs_f64();
    [4096, 2048].into_iter().find(fits).unwrap_or(1024)
}

/// The largest error of a channel of each pixel, in levels.
fn errors(a: &Codes, b: &Codes) -> Vec<f32> {
    let off = |(a, b): (&[u16; 4], &[u16; 4])| {
        let off = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
        f32::from(off.unwrap_or(0)) / 257.0
    };
    a.iter().zip(b).map(off).collect()
}
