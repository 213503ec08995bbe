//! Error against run time of one command on one frame: which of its settings trade quality for time, and what it could
//! leave out.
//!
//! The command is run from the frame in memory; errors are differences of pictures as a display has them, in grey levels
//! of 255, from the same command with every such setting at its best.

mod cases;
mod clock;
mod difference;
mod files;
mod ladder;
mod left_out;
mod measure;
mod page;
mod subject;
mod text;
mod timing;
mod verdict;

pub(crate) use cases::{all as all_cases, lines as lines_of_cases};
pub(crate) use measure::measured;
pub(crate) use page::page;
pub(crate) use text::lines;

use crate::command::commands::ReportArgs;
use crate::command::flags::Flag;
use clock::Spent;
use difference::{CodeDifference, Codes};
use serde::Serialize;
use timing::{TimedCost, Trust};

/// An error that nobody sees, for 99 of 100 pixels, in grey levels.
const SEEN: f64 = 2.0;

/// A change of fewer pixels than this share is hardly one.
const HARDLY: f64 = 0.02;

/// The report on a command.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    pub version: &'static str,
    /// Whether this is an optimised build; times of others mean little.
    pub is_optimised: bool,
    /// The command as it is typed, without IN and OUT.
    pub command: String,
    pub frame: On,
    pub verdict: Advice,
    /// What the truth is taken to be; `None` where nothing is traded.
    pub reference: Option<Reference>,
    /// Settings by their values: the command as given first.
    pub settings: Vec<Tried>,
    /// Flags that change nothing: the same stages run with the same numbers.
    pub same_stages: Vec<String>,
    pub parts: Vec<LeftOut>,
    /// Stages of the command as given, in milliseconds on the wall.
    pub stages: Vec<(&'static str, f64)>,
    pub read: Spent,
    /// Kinds of files of the picture: a PNG first.
    pub files: Vec<StoredReport>,
    pub trust: Trust,
    pub warnings: Vec<String>,
    #[serde(skip)]
    pub pictures: Pictures,
}

/// The frame of a report.
#[derive(Debug, Serialize)]
pub(crate) struct On {
    pub name: String,
    pub width: usize,
    pub height: usize,
    /// Number of pixels that show a surface.
    pub covered: usize,
}

/// What the report comes to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Advice {
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
    pub own: CodeDifference,
}

/// One value of one setting.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Tried {
    /// As typed; empty for the command as given.
    pub flags: String,
    pub error: CodeDifference,
    pub cost: TimedCost,
    /// Whether nothing else is both quicker and more exact.
    pub is_on_front: bool,
    /// What it chose by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chosen: Option<String>,
}

/// A part left out.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct LeftOut {
    pub name: &'static str,
    pub flags: String,
    /// Difference of the picture without it from the one as given.
    pub change: CodeDifference,
    pub cost: TimedCost,
}

/// The picture as a file.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct StoredReport {
    /// As typed.
    pub flags: String,
    pub bytes: u64,
    /// Difference from the picture as made.
    pub error: CodeDifference,
    /// Writing it, once.
    pub used: Spent,
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
