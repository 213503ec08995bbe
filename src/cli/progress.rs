//! Progress of a sequence: a bar on a terminal, otherwise lines of text or of JSON.

use super::message::{event, say};
use crate::command::args::{ProgressArg, RunArgs};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::fmt::Display;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Outcome of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Status {
    Done,
    Skipped,
    Missing,
    Failed,
}

impl Status {
    fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Skipped => "skipped",
            Self::Missing => "missing",
            Self::Failed => "failed",
        }
    }
}

/// Frames by how they ended.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub(super) done: usize,
    pub(super) skipped: usize,
    pub(super) missing: usize,
    /// Numbers of the failed frames.
    pub(super) failed: Vec<i32>,
}

impl Tally {
    pub(super) fn finished(&self) -> usize {
        self.done + self.skipped + self.missing + self.failed.len()
    }

    fn add(&mut self, frame: i32, status: Status) {
        match status {
            Status::Done => self.done += 1,
            Status::Skipped => self.skipped += 1,
            Status::Missing => self.missing += 1,
            Status::Failed => self.failed.push(frame),
        }
    }
}

/// Shows the progress of a sequence.
pub(super) struct SequenceProgress {
    shown: ShownProgress,
    total: usize,
    started: Instant,
    tally: Mutex<Tally>,
}

enum ShownProgress {
    Bar(ProgressBar),
    Plain,
    Json,
    Nothing,
}

impl SequenceProgress {
    pub(super) fn begin(arg: ProgressArg, quiet: bool, total: usize) -> Self {
        let shown = match arg {
            ProgressArg::None => ShownProgress::Nothing,
            ProgressArg::Json => ShownProgress::Json,
            _ if quiet => ShownProgress::Nothing,
            ProgressArg::Plain => ShownProgress::Plain,
            ProgressArg::Auto if !std::io::stderr().is_terminal() => ShownProgress::Plain,
            ProgressArg::Auto | ProgressArg::Bar => ShownProgress::Bar(bar(total)),
        };
        if let ShownProgress::Json = shown {
            event(&json!({ "event": "begin", "total": total }));
        }
        Self {
            shown,
            total,
            started: Instant::now(),
            tally: Mutex::default(),
        }
    }

    /// Counts a finished frame, after `took`; `what` is its output, or the error.
    pub(super) fn frame(&self, frame: i32, status: Status, took: Duration, what: impl Display) {
        let mut tally = self
            .tally
            .lock()
            .expect("no frame panics while it is counted");
        tally.add(frame, status);
        let (finished, total) = (tally.finished(), self.total);
        // Skipped frames took no time and predict nothing about the rest.
        let worked = tally.done + tally.failed.len();
        let left = self.started.elapsed().as_secs_f64() / worked.max(1) as f64;
        let left = left * (total - finished) as f64;
        let (seconds, name) = (took.as_secs_f64(), status.name());
        match &self.shown {
            ShownProgress::Nothing => {}
            ShownProgress::Bar(bar) => bar.set_position(finished as u64),
            ShownProgress::Plain => say(&format!(
                "[{finished}/{total}] {what}: {name}, {seconds:.2} s, {left:.0} s left"
            )),
            ShownProgress::Json => {
                let mut ended = json!({
                    "event": "frame", "frame": frame, "status": name, "finished": finished,
                    "total": total, "seconds": seconds, "eta_seconds": left,
                });
                if status == Status::Failed {
                    ended["message"] = what.to_string().into();
                }
                event(&ended);
            }
        }
    }

    /// Prints a line other than progress, above the bar if there is one.
    pub(super) fn say(&self, line: &str) {
        match &self.shown {
            ShownProgress::Bar(bar) => bar.suspend(|| say(line)),
            _ => say(line),
        }
    }

    /// Ends the display, and reports the number of frames by outcome.
    pub(super) fn end(self, quiet: bool) -> Tally {
        let tally = self
            .tally
            .into_inner()
            .expect("no frame panics while it is counted");
        let Tally {
            done,
            skipped,
            missing,
            failed,
        } = &tally;
        match &self.shown {
            ShownProgress::Bar(bar) => bar.finish_and_clear(),
            ShownProgress::Json => event(&json!({
                "event": "end", "done": done, "skipped": skipped, "missing": missing,
                "failed": failed.len(),
            })),
            ShownProgress::Plain | ShownProgress::Nothing => {}
        }
        if !quiet && !matches!(self.shown, ShownProgress::Json) {
            say(&in_words(&tally, self.total, self.started.elapsed()));
        }
        tally
    }
}

/// A bar for the strips of one picture if progress is shown as bars; otherwise an invisible one.
pub(super) fn strips_bar(args: &RunArgs, doing: &'static str, total: usize) -> ProgressBar {
    let template = "{msg} {bar:40} {pos}/{len} strips, {eta} left";
    part_bar(args, template, total).with_message(doing)
}

/// The same for the cells of a sheet.
pub(super) fn cells_bar(args: &RunArgs, total: usize) -> ProgressBar {
    part_bar(args, "{bar:40} {pos}/{len} cells, {eta} left", total)
}

/// The same for the passes of a run, in percent; an invisible one unless it is `wanted`.
pub(super) fn passes_bar(args: &RunArgs, wanted: bool) -> ProgressBar {
    match wanted {
        true => part_bar(args, "{msg} {bar:40} {pos} %, {eta} left", 100),
        false => ProgressBar::hidden(),
    }
}

/// A bar for the parts of one picture.
fn part_bar(args: &RunArgs, template: &str, total: usize) -> ProgressBar {
    let on_terminal = std::io::stderr().is_terminal();
    let is_shown = match args.progress {
        ProgressArg::Bar => true,
        ProgressArg::Auto => on_terminal && !args.quiet,
        ProgressArg::Plain | ProgressArg::Json | ProgressArg::None => false,
    };
    if !is_shown {
        return ProgressBar::hidden();
    }
    styled(template, total)
}

fn styled(template: &str, total: usize) -> ProgressBar {
    let style = ProgressStyle::with_template(template).expect("the template is well formed");
    ProgressBar::new(total as u64).with_style(style)
}

fn bar(total: usize) -> ProgressBar {
    let bar = styled("{bar:40} {pos}/{len} frames, {per_sec}, {eta} left", total);
    // The tick needs a thread, and the system may have none left.
    if std::thread::Builder::new().spawn(|| ()).is_ok() {
        bar.enable_steady_tick(Duration::from_millis(250));
    }
    bar
}

fn in_words(tally: &Tally, total: usize, took: Duration) -> String {
    let seconds = took.as_secs_f64();
    let mut text = format!("{} of {total} frames done in {seconds:.1} s", tally.done);
    if tally.skipped > 0 {
        text += &format!(", {} there already", tally.skipped);
    }
    if tally.missing > 0 {
        text += &format!(", {} missing", tally.missing);
    }
    if !tally.failed.is_empty() {
        let mut failed = tally.failed.clone();
        failed.sort_unstable();
        let failed: Vec<_> = failed.iter().map(i32::to_string).collect();
        text += &format!(", {} failed: {}", failed.len(), failed.join(","));
    }
    text
}
