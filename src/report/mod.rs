//! Error against run time of one command on one frame: which of its settings trade quality for time, and what it could
//! leave out.
//!
//! The command is run from the frame in memory; errors are differences of pictures as a display has them, in grey levels
//! of 255, from the same command with every such setting at its best.

mod cases;
mod clock;
mod difference;
mod ladder;
mod left_out;
mod page;
mod subject;
mod text;
mod timing;

pub(crate) use cases::{all as all_cases, lines as lines_of_cases};
pub(crate) use page::page;
pub(crate) use text::lines;

use crate::command::commands::ReportArgs;
use crate::command::flags::Flag;
use crate::error::Result;
use clock::{Used, timed};
use difference::{Codes, Difference};
use ladder::{ladders, references};
use serde::Serialize;
use std::time::{Duration, Instant};
use subject::{Change, Subject};
use timing::{Cost, Trust};

/// An error that nobody sees, for 99 of 100 pixels, in grey levels.
const SEEN: f64 = 2.0;

/// A change of fewer pixels than this share is hardly one.
const HARDLY: f64 = 0.02;

/// The share by which a report may overrun its time to get enough rounds.
const GRACE: f64 = 0.15;

/// A time saved below this share of the whole is not worth a flag.
const WORTH: f64 = 0.05;

/// The report on a command.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    pub version: &'static str,
    /// Whether this is an optimised build; times of others mean little.
    pub is_optimised: bool,
    /// The command as it is typed, without IN and OUT.
    pub command: String,
    pub frame: Frame,
    pub verdict: Verdict,
    /// What the truth is taken to be; `None` where nothing is traded.
    pub reference: Option<Reference>,
    /// Settings by their values: the command as given first.
    pub settings: Vec<Setting>,
    /// Flags that change nothing: the same stages run with the same numbers.
    pub same_stages: Vec<String>,
    pub parts: Vec<Part>,
    /// Stages of the command as given, in milliseconds on the wall.
    pub stages: Vec<(&'static str, f64)>,
    pub read: Used,
    /// Writing an 8-bit PNG.
    pub write: Used,
    pub trust: Trust,
    pub warnings: Vec<String>,
    #[serde(skip)]
    pub pictures: Pictures,
}

/// The frame of a report.
#[derive(Debug, Serialize)]
pub(crate) struct Frame {
    pub name: String,
    pub width: usize,
    pub height: usize,
    /// Number of pixels that show a surface.
    pub covered: usize,
}

/// What the report comes to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Verdict {
    /// Flags to add; none where nothing is to be changed.
    pub flags: Option<String>,
    pub sentence: String,
    /// Share of pixels that the shape brought out changes by more than 2 levels, where that is what the command does.
    pub shows: Option<f64>,
}

/// The truth that settings are compared with.
#[derive(Debug, Serialize)]
pub(crate) struct Reference {
    pub flags: String,
    /// Its own error: its difference from half its effort.
    pub own: Difference,
}

/// One value of one setting.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Setting {
    /// As typed; empty for the command as given.
    pub flags: String,
    pub error: Difference,
    pub cost: Cost,
    /// Whether nothing else is both quicker and more exact.
    pub is_on_front: bool,
    /// What it chose by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chosen: Option<String>,
}

/// A part left out.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Part {
    pub name: &'static str,
    pub flags: String,
    /// Difference of the picture without it from the one as given.
    pub change: Difference,
    pub cost: Cost,
}

/// Pictures of a report, as a display has them.
#[derive(Debug, Default)]
pub(crate) struct Pictures {
    pub size: [usize; 2],
    pub before: Option<Codes>,
    pub after: Codes,
    /// Error of each pixel as given, in levels; nothing where nothing is traded.
    pub error: Vec<f32>,
}

/// A run that is compared, and timed.
struct Candidate {
    change: Change,
    difference: Difference,
    first: Used,
    chosen: Option<String>,
}

/// What a report is to be made of.
pub(crate) struct Asked<'a> {
    pub(crate) args: &'a ReportArgs,
    /// Settings given to the report itself.
    pub(crate) typed: &'a [Flag],
    /// The number of the frame, in a sequence.
    pub(crate) number: Option<i32>,
    /// Called with what is measured next.
    pub(crate) progress: &'a dyn Fn(&str),
}

/// Measures a command.
///
/// # Errors
/// As the command.
pub(crate) fn measured(asked: &Asked) -> Result<Report> {
    let began = Instant::now();
    let say = asked.progress;
    say("reading");
    let mut subject = Subject::read(asked.args, asked.typed, asked.number)?;
    let has_environment = subject.light.environment.is_some();
    let usual = if has_environment { 45.0 } else { 15.0 };
    let budget = Duration::from_secs_f64(asked.args.budget.map_or(usual, f64::from));
    let left = |share: f64| budget.mul_f64(share).saturating_sub(began.elapsed());

    say("the command as given");
    let as_given = Change::default();
    // The first run makes memory that further ones use again.
    let first = subject.shot(&as_given)?;
    subject.engine.recycle(first.made.outcome);
    let given = subject.shot(&as_given)?;
    let counts = subject.counts(given.size);
    let stages = given.made.outcome.timings.iter();
    let stages = stages.map(|(stage, time)| (*stage, 1e3 * time.as_secs_f64()));
    let stages: Vec<_> = stages.collect();

    let ladders = ladders(&subject);
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut reference = None;
    let mut error_of_given = Difference::default();
    let mut error_map = Vec::new();
    let mut same_stages = Vec::new();
    if !ladders.is_empty() {
        let mut shots = Vec::new();
        let mut slowest = given.used.wall_ms;
        for ladder in &ladders {
            for rung in &ladder.rungs {
                let change = Change::setting(ladder.setting, rung);
                // What takes eight times as long would leave no time for the rest.
                let fits = 4.0 * slowest < 1e3 * left(0.5).as_secs_f64();
                if subject.is_same(&change) {
                    same_stages.push(change.flags());
                    continue;
                }
                if !fits {
                    continue;
                }
                say(&format!("--{} {rung}", ladder.setting));
                let shot = subject.shot(&change)?;
                slowest = slowest.max(shot.used.wall_ms);
                shots.push((change, shot));
            }
        }
        let samples = samples_of_truth(&shots, left(0.45));
        let [best, half] = references(&ladders, samples);
        say("the same at its best");
        let truth = subject.shot(&best)?;
        say("the same at half its effort");
        let near = subject.shot(&half)?;
        reference = Some(Reference {
            flags: best.flags(),
            own: Difference::between(&truth.codes, &near.codes, &counts),
        });
        subject.engine.recycle(near.made.outcome);
        error_of_given = Difference::between(&truth.codes, &given.codes, &counts);
        error_map = errors(&truth.codes, &given.codes);
        candidates.extend(shots.into_iter().map(|(change, shot)| {
            Candidate {
                difference: Difference::between(&truth.codes, &shot.codes, &counts),
                first: shot.used,
                chosen: shot
                    .made
                    .outcome
                    .light_choice
                    .map(|choice| choice.to_string()),
                change,
            }
        }));
    }
    let trades = candidates.len();

    let parts = left_out::parts(&subject, &given.made.outcome);
    for part in &parts {
        say(&format!("without {}", part.name));
        let shot = subject.shot(&part.change)?;
        candidates.push(Candidate {
            difference: Difference::between(&given.codes, &shot.codes, &counts),
            first: shot.used,
            chosen: None,
            change: part.change.clone(),
        });
        subject.engine.recycle(shot.made.outcome);
    }

    let write = timed(|| page::png(given.size, &given.codes)).1;
    // What is needed is not timed: nobody would leave it out.
    let is_timed = |(i, candidate): &(usize, &Candidate)| {
        *i < trades || candidate.difference.beyond_2 < HARDLY || parts[*i - trades].is_command
    };
    let timed: Vec<usize> = candidates
        .iter()
        .enumerate()
        .filter(is_timed)
        .map(|(i, _)| i)
        .collect();
    let of_timed = timed.iter().map(|&i| candidates[i].first);
    let first: Vec<Used> = std::iter::once(given.used).chain(of_timed).collect();
    let time_left = budget.saturating_sub(began.elapsed());
    say(&format!("times, for {:.0} s", time_left.as_secs_f64()));
    let measured = timing::rounds(&first, time_left, budget.mul_f64(GRACE), |i| {
        let change = match i {
            0 => &as_given,
            _ => &candidates[timed[i - 1]].change,
        };
        let shot = subject.shot(change)?;
        subject.engine.recycle(shot.made.outcome);
        Ok(shot.used)
    })?;

    let cost_of = |i: usize| match timed.iter().position(|&at| at == i) {
        Some(at) => measured.others[at],
        None => Cost {
            cpu_ms: candidates[i].first.cpu_ms,
            wall_ms: candidates[i].first.wall_ms,
            saved_ms: 0.0,
            is_in_rounds: false,
        },
    };
    let mut settings = vec![Setting {
        flags: String::new(),
        error: error_of_given,
        cost: Cost {
            cpu_ms: measured.given.cpu_ms,
            wall_ms: measured.given.wall_ms,
            saved_ms: 0.0,
            is_in_rounds: true,
        },
        is_on_front: false,
        chosen: given
            .made
            .outcome
            .light_choice
            .map(|choice| choice.to_string()),
    }];
    settings.extend(
        candidates[..trades]
            .iter()
            .enumerate()
            .map(|(i, candidate)| Setting {
                flags: candidate.change.flags(),
                error: candidate.difference,
                cost: cost_of(i),
                is_on_front: false,
                chosen: candidate.chosen.clone(),
            }),
    );
    mark_front(&mut settings);
    let own_error = reference
        .as_ref()
        .map_or(0.0, |reference| reference.own.p99);
    let shows = parts.iter().position(|part| part.is_command);
    let shows = shows.map(|i| candidates[trades + i].difference.beyond_2);
    let verdict = verdict(&settings, own_error, shows);
    let parts = parts.iter().enumerate().map(|(i, part)| Part {
        name: part.name,
        flags: part.flags.clone(),
        change: candidates[trades + i].difference,
        cost: cost_of(trades + i),
    });
    let mask = &subject.frame.mask;
    let input = &asked.args.input;
    Ok(Report {
        version: env!("CARGO_PKG_VERSION"),
        is_optimised: !cfg!(debug_assertions),
        command: subject.line(""),
        frame: Frame {
            name: input
                .file_name()
                .unwrap_or(input.as_os_str())
                .to_string_lossy()
                .into(),
            width: mask.width(),
            height: mask.height(),
            covered: mask.count(),
        },
        verdict,
        reference,
        settings,
        same_stages,
        parts: parts.collect(),
        stages,
        read: subject.read,
        write,
        trust: measured.trust,
        pictures: Pictures {
            size: given.size,
            before: subject
                .before()
                .filter(|before| before.len() == given.codes.len()),
            after: given.codes,
            error: error_map,
        },
        warnings: subject.warnings,
    })
}

/// How many samples the truth may have within a time: doubled from 1024 to 4096, by what samples were found to cost.
fn samples_of_truth(shots: &[(Change, subject::Shot)], within: Duration) -> u32 {
    let of_samples = |(change, shot): &(Change, subject::Shot)| {
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

/// Marks what nothing else is both quicker than and more exact. Times that cannot be told apart are equal.
fn mark_front(settings: &mut [Setting]) {
    let all: Vec<(f64, f64)> = settings
        .iter()
        .map(|s| (-s.cost.saved_ms, s.error.p99))
        .collect();
    for (setting, own) in settings.iter_mut().zip(&all) {
        let better = |(time, error): &(f64, f64)| {
            *time <= own.0 && *error <= own.1 && (*time < own.0 || *error < own.1)
        };
        setting.is_on_front = !all.iter().any(better);
    }
}

/// What to change, if anything: the quickest of what nobody can tell from the truth.
fn verdict(settings: &[Setting], own_error: f64, shows: Option<f64>) -> Verdict {
    let [given, others @ ..] = settings else {
        unreachable!("the command as given is one of them")
    };
    let is_exact = |setting: &&Setting| setting.error.p99 <= SEEN;
    let is_unseen = |setting: &&Setting| {
        let (found, as_given) = (&setting.error, &given.error);
        let is_no_worse = found.p99 <= as_given.p99 && found.largest <= as_given.largest;
        is_no_worse || (found.p99 <= 0.5 * SEEN && found.largest <= SEEN)
    };
    let saves = |setting: &&Setting| setting.cost.saved_ms > WORTH * given.cost.cpu_ms;
    let quickest = |found: Vec<&Setting>| -> Option<Setting> {
        let order = |a: &&Setting, b: &&Setting| {
            let by_time = b.cost.saved_ms.total_cmp(&a.cost.saved_ms);
            by_time.then(a.error.p99.total_cmp(&b.error.p99))
        };
        found.into_iter().min_by(order).cloned()
    };
    let ms = |ms: f64| text::ms(ms.abs());
    let nothing = |why: String| Verdict {
        flags: None,
        sentence: why,
        shows,
    };
    if others.is_empty() {
        return nothing(
            "nothing to trade: no setting of this command gives quality for time here".into(),
        );
    }
    if own_error > SEEN {
        return nothing(format!(
            "no advice: even the best that was tried is off by {own_error:.1} levels from half its effort; \
             a longer --budget gives it more"
        ));
    }
    let found = match is_exact(&given) {
        true => quickest(others.iter().filter(is_unseen).filter(saves).collect()),
        false => quickest(others.iter().filter(is_exact).collect()).or_else(|| {
            let better = others
                .iter()
                .filter(|s| 1.5 * s.error.p99 < given.error.p99);
            better
                .min_by(|a, b| a.error.p99.total_cmp(&b.error.p99))
                .cloned()
        }),
    };
    let Some(found) = found else {
        return nothing(match is_exact(&given) {
            true => format!(
                "nothing to trade: as given it is off by {:.1} levels (99 % of pixels), and nothing as exact is quicker",
                given.error.p99
            ),
            false => format!(
                "as given it is off by {:.1} levels (99 % of pixels), and no other setting does better",
                given.error.p99
            ),
        });
    };
    let (from, to) = (ms(given.cost.cpu_ms), ms(found.cost.cpu_ms));
    let sentence = match (is_exact(&given), found.cost.saved_ms) {
        (true, saved) => format!(
            "{} saves {} ms of {from}, and nobody sees it (99 % of pixels within {:.1} levels, all within {:.1})",
            found.flags,
            ms(saved),
            found.error.p99,
            found.error.largest
        ),
        (false, saved) => {
            let time = match saved {
                0.0 => "in the same time".to_string(),
                saved if saved > 0.0 => format!("{} ms of CPU less a frame", ms(saved)),
                longer => format!("{} ms of CPU more a frame", ms(longer)),
            };
            format!(
                "{}: {:.1} levels off instead of {:.1} (99 % of pixels), {time} ({from} -> {to})",
                found.flags, found.error.p99, given.error.p99
            )
        }
    };
    Verdict {
        sentence,
        flags: Some(found.flags),
        shows,
    }
}
