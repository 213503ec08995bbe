//! One frame from its arguments to its output and messages: what all commands share.

use super::cells::{CellForm, SheetPart};
use super::explained;
use super::message;
use super::output::{NextRows, ReadyOutput, attributes};
use super::run_log::RunLog;
use super::timings::FrameTimings;
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::commands::Command;
use crate::command::invocation::Task;
use crate::command::recipe::RecipeText;
use crate::engine::Engine;
use crate::engine::cpu::row_layers::{LaidRows, RowLayers};
use crate::engine::tiles::Strips;
use crate::error::Result;
use crate::frame::{ColorPlanes, Mask, Window};
use crate::io::exr::OutputChannel;
use crate::io::inputs::Inputs;
use crate::io::output::OutputKind;
use crate::io::output::picture::{Displayed, MadePicture};
use crate::io::output::{write_atomically, write_text};
use crate::io::picture::{Picture, PictureFormat, ViewTransform, Whites, write_picture_as};
use crate::io::svg;
use crate::io::{Holding, InputFiles, Loaded, Needs};
use crate::plan::outcome::{Outcome, Shape};
use crate::plan::{Decision, Plan};
use crate::untrusted::shown;
use crate::work::FrameWork;
use crate::work::shape::held_gain;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A frame to be made.
#[derive(Clone)]
pub(super) struct Job<'a> {
    /// The command, with the names of this frame.
    pub(super) command: Command,
    /// Its number, in a sequence.
    pub(super) frame: Option<i32>,
    /// Its place among the frames of a sequence that is being made.
    pub(super) index: Option<usize>,
    /// What it is of a sheet.
    pub(super) part: Option<SheetPart<'a>>,
    /// Whether its output is written, rather than looked at, or left to the sheet that it is a part of.
    pub(super) writes: bool,
    pub(super) log: &'a RunLog,
    pub(super) recipe: &'a RecipeText,
    pub(super) started: Instant,
    /// What the plans of this frame decided, until it is explained.
    pub(super) decisions: Arc<Mutex<Vec<Decision>>>,
}

/// A frame that has been read and what the plan made of it.
pub(super) struct Done {
    pub(super) loaded: Loaded,
    pub(super) outcome: Outcome,
    pub(super) read: Duration,
}

impl Done {
    fn chosen(&self) -> Chosen {
        Chosen::made(&self.loaded, &self.outcome)
    }
}

impl<'a> Job<'a> {
    /// A single picture, or a frame that is looked at for what is chosen automatically.
    pub(super) fn of(task: &'a Task, log: &'a RunLog, frame: Option<i32>) -> Self {
        let command = task.command.of_frame(frame);
        Self {
            writes: command.work().args().output.output.is_some() && frame.is_none(),
            command,
            frame,
            index: None,
            part: None,
            log,
            recipe: &task.recipe,
            started: Instant::now(),
            decisions: Arc::default(),
        }
    }

    /// What the command does.
    pub(super) fn work(&self) -> &dyn FrameWork {
        self.command.work()
    }

    pub(super) fn args(&self) -> &WorkArgs {
        self.work().args()
    }

    /// The same with the output of one of the maps that its name stands for.
    pub(super) fn writing(&self, part: &str) -> Self {
        let mut job = self.clone();
        let output = &mut job.command.work_mut().args_mut().output;
        output.parts = vec![part.into()];
        output.output = output.files().pop();
        job
    }

    /// The sheet that it is a cell of.
    fn cell(&self) -> Option<SheetPart<'a>> {
        self.part.filter(SheetPart::is_cell)
    }

    /// Whether the frame goes on from those before it, of a sequence that is being made.
    pub(super) fn follows(&self) -> bool {
        self.index.is_some_and(|index| index > 0)
    }

    /// Whether it is one of a sequence.
    pub(super) fn is_in_sequence(&self) -> bool {
        self.frame.is_some()
    }

    /// Runs `pass` after all frames before this one have passed the same point.
    pub(super) fn in_turn<T>(&self, pass: impl FnOnce() -> T) -> T {
        match self.index {
            Some(index) => self.log.turns.in_turn(index, pass),
            None => pass(),
        }
    }

    /// Reads the frame, and says what was concluded.
    pub(super) fn load(&self, inputs: &Inputs, needs: Needs) -> Result<(Loaded, Duration)> {
        match self.part {
            Some(part) => self.told(|| part.load(inputs, needs)),
            None => self.load_from(
                &InputFiles::open(inputs, Holding::default())?,
                inputs,
                needs,
            ),
        }
    }

    /// The same of files that are open.
    pub(super) fn load_from(
        &self,
        files: &InputFiles,
        inputs: &Inputs,
        needs: Needs,
    ) -> Result<(Loaded, Duration)> {
        self.told(|| files.load(inputs, needs))
    }

    fn told(&self, load: impl FnOnce() -> Result<Loaded>) -> Result<(Loaded, Duration)> {
        let start = Instant::now();
        let loaded = load()?;
        let read = start.elapsed();
        if self.args().run.verbose && self.speaks_for_all() {
            for finding in &loaded.findings {
                self.log.say(&message::finding_line(finding));
            }
        }
        for warning in &loaded.warnings {
            self.say_once("warning", warning, true);
        }
        Ok((loaded, read))
    }

    /// Whether what concerns all frames is said now: with the first one.
    fn speaks_for_all(&self) -> bool {
        match self.index {
            _ if self.cell().is_some() => false,
            None => self.frame.is_none() || self.args().output.output.is_none(),
            Some(index) => index == 0,
        }
    }

    /// Says a warning, unless it was said of another frame.
    pub(super) fn warn(&self, text: &str) {
        self.say_once("warning", text, false);
    }

    /// Says something about this picture, unless it is one of a sequence.
    pub(super) fn note(&self, text: &str) {
        let is_one = !self.log.is_sequence() && self.part.is_none();
        if !self.args().run.quiet && is_one {
            self.log
                .say(&format!("{}: {text}", shown(&self.args().input)));
        }
    }

    fn say_once(&self, kind: &str, text: &str, with_name: bool) {
        let is_looked_at = self.index.is_none() && self.frame.is_some();
        let is_made_later = is_looked_at && self.args().output.output.is_some();
        let is_silent = self.args().run.quiet || self.cell().is_some();
        if is_silent || is_made_later || !self.log.is_new(text) {
            return;
        }
        let name = match with_name {
            true => format!("{}: ", shown(&self.args().input)),
            false => String::new(),
        };
        self.log.say(&format!("{kind}: {name}{text}"));
    }

    /// Frees all that a run computed but its picture or drawing, which is about to be written.
    pub(super) fn keep_picture_alone(&self, engine: &Engine, outcome: &mut Outcome) {
        if !self.is_in_sequence() {
            outcome.shape = Shape::default();
            if outcome.drawing.is_some() {
                outcome.color = None;
            }
        }
        self.release_spare_memory(engine);
    }

    /// Frees the memory that a run leaves for further ones, unless there are any.
    pub(super) fn release_spare_memory(&self, engine: &Engine) {
        if !self.is_in_sequence() && self.part.is_none() {
            engine.release_spare_memory();
        }
    }

    /// Says where normals are too coarse for the gain that their shape asks for.
    pub(super) fn note_gain(&self, plan: &Plan, gain: Option<f32>) {
        if let Some(text) = held_gain(plan, gain).filter(|_| plan.drawing.is_none()) {
            self.warn(&text);
        }
    }

    /// Warns of the plan, and keeps its reasons, to be explained once it has run.
    pub(super) fn tell_plan(&self, plan: &Plan) {
        if let Some(text) = plan.shape.outdated() {
            self.warn(text);
        }
        if self.args().run.explain && self.speaks_for_all() {
            let mut decisions = self
                .decisions
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            decisions.extend(plan.decisions().iter().cloned());
        }
    }

    /// Explains what ran, once for each frame that is explained.
    pub(super) fn explain(
        &self,
        timings: &FrameTimings,
        chosen: &Chosen,
        whites: Whites,
    ) -> Result<()> {
        let mut decisions = self
            .decisions
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let decisions = std::mem::take(&mut *decisions);
        if decisions.is_empty() {
            return Ok(());
        }
        let (ran, idle) = (&timings.stages, timings.idle(whites));
        let is_verbose = self.args().run.verbose;
        let lines = explained::lines(ran, &decisions, chosen, &idle, is_verbose);
        message::result(lines)
    }

    /// Writes the picture that was made, and ends the frame.
    pub(super) fn write_picture(&self, done: &Done, made: MadePicture) -> Result<Chosen> {
        let loaded = &done.loaded;
        let mask = &loaded.frame.mask;
        let params = &self.args().flags.params;
        let exposure = made.exposure(&params.display, mask);
        let chosen = done.chosen().exposed(exposure);
        if let Some(cell) = self.cell() {
            let form = CellForm::Picture {
                form: made.form,
                is_derived: made.before.is_some(),
            };
            let ColorPlanes { r, g, b } = &*made.printed().color;
            cell.keep(self.args(), &done.outcome, form, &[r, g, b]);
            return Ok(chosen);
        }
        let displayed = self.displayed(loaded, made, exposure);
        let settings = self.recipe(&chosen);
        self.write(done, chosen, |output| {
            self.write_picture_to(output, done, &displayed.picture(), settings)?;
            Ok(self.whites(&displayed, mask, 0..mask.height()))
        })
    }

    /// A picture made of `loaded`, as a display has it, with the exposure that was chosen, if one was.
    pub(super) fn displayed<'p>(
        &self,
        loaded: &'p Loaded,
        made: MadePicture<'p>,
        exposure: Option<f32>,
    ) -> Displayed<'p> {
        let (frame, primaries) = (&loaded.frame, loaded.chromaticities);
        let bits = if loaded.photo_bits == Some(16) { 16 } else { 8 };
        let params = &self.args().flags.params;
        params.displayed(frame, primaries, made, bits, exposure)
    }

    fn write_picture_to(
        &self,
        output: ReadyOutput,
        done: &Done,
        picture: &Picture,
        settings: String,
    ) -> Result<()> {
        self.check_picture(&done.loaded.frame, picture)?;
        let ReadyOutput { path, replace } = output;
        let OutputKind::Picture(format) = OutputKind::of(path)? else {
            unreachable!("layers go to an EXR")
        };
        let encoding =
            self.args()
                .output
                .encoding(&done.loaded, settings, &self.args().flags.params)?;
        write_atomically(path, replace, |w| {
            write_picture_as(w, path, format, picture, &encoding)
        })
    }

    /// Writes planes to an EXR or as numbers, and ends the frame.
    pub(super) fn write_channels(
        &self,
        done: &Done,
        channels: Vec<OutputChannel>,
    ) -> Result<Chosen> {
        let channels = self.args().output.picked(channels)?;
        if let Some(cell) = self.cell() {
            cell.keep_channels(self.args(), &done.outcome, &channels);
            return Ok(done.chosen());
        }
        self.write(done, done.chosen(), |output| {
            let results: Vec<_> = channels.iter().map(|channel| channel.plane).collect();
            self.check_channels(&done.loaded.frame, &channels)?;
            let window = done.loaded.frame.data_window;
            let whole = (&done.loaded, window);
            self.write_part(output, whole, &channels, &done.chosen(), |next| {
                next(&results, 0..window.height(), &mut || ())
            })?;
            Ok(Whites::default())
        })
    }

    /// Makes the last of some layers of `loaded` and writes them to an EXR or as numbers, a few rows at a time, and ends the frame.
    /// `channels` names those of some rows.
    pub(super) fn write_layers(
        &self,
        loaded: &Loaded,
        layers: &RowLayers,
        read: Duration,
        channels: impl Fn(&LaidRows) -> Vec<OutputChannel<'_>> + Sync,
    ) -> Result<Chosen> {
        let chosen = Chosen::made(loaded, &layers.outcome);
        let (frame, args) = (&loaded.frame, &self.args().output);
        if let Some(cell) = self.cell() {
            let all = layers.rows(frame, &(0..frame.mask.height()))?;
            let channels = args.picked(channels(&all))?;
            cell.keep_channels(self.args(), &all.outcome, &channels);
            return Ok(chosen);
        }
        let mut timings = FrameTimings::of(loaded, read);
        timings.add_all(&layers.outcome);
        self.write_output(&chosen, |output| {
            let mut writing = Duration::ZERO;
            let height = frame.mask.height();
            let first = layers.rows(frame, &(0..height.min(1)))?;
            let named = args.picked(channels(&first))?;
            self.write_part(
                output,
                (loaded, frame.data_window),
                &named,
                &chosen,
                |next| {
                    let bands = Strips::of_rows(band_rows(), height, 0);
                    let mut bands = bands.each().map(|(rows, _)| rows);
                    let made = |rows: Range<usize>| {
                        let laid = layers.rows(frame, &rows)?;
                        let named = args.picked(channels(&laid))?;
                        self.check_channels(&laid.frame, &named)?;
                        Ok(laid)
                    };
                    let mut laid = bands.next().map(made).transpose()?;
                    while let Some(rows) = laid {
                        timings.add_all(&rows.outcome);
                        let began = Instant::now();
                        let named = args.picked(channels(&rows))?;
                        let planes: Vec<_> = named.iter().map(|channel| channel.plane).collect();
                        // The next rows are made while these are written: neither keeps all threads busy to its end.
                        let (following, mut made_meanwhile) = (bands.next(), Ok(None));
                        next(&planes, rows.rows.clone(), &mut || {
                            made_meanwhile = following.clone().map(made).transpose();
                        })?;
                        writing += began.elapsed();
                        laid = made_meanwhile?;
                        layers.recycle(rows);
                    }
                    Ok(())
                },
            )?;
            timings.add("write", writing);
            self.write_timings(&timings)?;
            Ok(Whites::default())
        })?;
        self.explain(&timings, &chosen, Whites::default())?;
        Ok(chosen)
    }

    /// Writes a part of an EXR, or planes as numbers, with channels like these: `each` hands on their rows.
    pub(super) fn write_part(
        &self,
        output: ReadyOutput,
        (loaded, window): (&Loaded, Window),
        channels: &[OutputChannel],
        chosen: &Chosen,
        each: impl FnOnce(&mut NextRows) -> Result<()>,
    ) -> Result<()> {
        let args = &self.args().output;
        let attributes = attributes(self.args(), loaded, self.recipe(chosen));
        let part = args.part(loaded, window, channels, attributes);
        let warnings = args.write_part(output, loaded, &part, each)?;
        warnings
            .iter()
            .for_each(|warning| self.say_once("warning", warning, true));
        Ok(())
    }

    /// The recipe of this run, with what was chosen.
    pub(super) fn recipe(&self, chosen: &Chosen) -> String {
        self.recipe.with(chosen)
    }

    /// Writes a drawing in lines and ends the frame.
    pub(super) fn write_svg(&self, done: &Done, drawing: &svg::LinePage) -> Result<Chosen> {
        self.write(done, done.chosen(), |ReadyOutput { path, replace }| {
            self.check_lines(drawing)?;
            write_atomically(path, replace, |w| svg::write_svg(w, path, drawing))?;
            Ok(Whites::default())
        })
    }

    /// Writes through `write` where there is anything to be written, then the timings, and says what was done.
    fn write(
        &self,
        done: &Done,
        chosen: Chosen,
        write: impl FnOnce(ReadyOutput) -> Result<Whites>,
    ) -> Result<Chosen> {
        let mut timings = FrameTimings::of(&done.loaded, done.read);
        timings.add_all(&done.outcome);
        let whites = self.write_output(&chosen, |output| {
            let start = Instant::now();
            let whites = write(output)?;
            timings.add("write", start.elapsed());
            self.write_timings(&timings)?;
            Ok(whites)
        })?;
        self.explain(&timings, &chosen, whites)?;
        Ok(chosen)
    }

    /// How much of a picture for a display is white, and of the one before; nothing of one that holds linear numbers.
    pub(super) fn whites(&self, shown: &Displayed, mask: &Mask, rows: Range<usize>) -> Whites {
        let kind = self.args().output.kind();
        let is_linear = matches!(kind, Ok(OutputKind::Picture(PictureFormat::Hdr)));
        let picture = shown.picture();
        match shown.is_light() && !is_linear && picture.transform == ViewTransform::Srgb {
            true => Whites {
                compressed: (self.args().run.explain)
                    .then(|| picture.compressed(mask, rows.clone())),
                ..Whites::of(&picture, shown.before(), mask, rows)
            },
            false => Whites::default(),
        }
    }

    /// Writes through `write` where there is anything to be written, and says what was done; returns what is white.
    pub(super) fn write_output(
        &self,
        chosen: &Chosen,
        write: impl FnOnce(ReadyOutput) -> Result<Whites>,
    ) -> Result<Whites> {
        let Some(path) = self.args().output.output.as_deref().filter(|_| self.writes) else {
            return Ok(Whites::default());
        };
        let replace = self.args().output.replace();
        let whites = write(ReadyOutput { path, replace })?;
        let highlights = self.args().flags.params.display.highlights;
        if let Some(warning) = message::burnt(whites, highlights) {
            self.say_once("warning", &warning, true);
        }
        if !self.args().run.quiet && !self.log.is_sequence() {
            let seconds = self.started.elapsed().as_secs_f64();
            let words = [chosen.in_words(), message::whites(whites)];
            let words = words.into_iter().filter(|words| !words.is_empty());
            let words: String = words.map(|words| words + ", ").collect();
            let path = shown(path);
            self.log.say(&format!("{path}: {words}{seconds:.2} s"));
        }
        Ok(whites)
    }

    /// Writes the timings, where they are asked for.
    pub(super) fn write_timings(&self, timings: &FrameTimings) -> Result<()> {
        let Some(path) = &self.args().run.timings else {
            return Ok(());
        };
        let text = timings.json(self.started.elapsed());
        write_text(path, self.args().output.replace_beside(), &text)
    }
}

/// Rows in a band of layers, a block for every thread: one band is made while another is written.
fn band_rows() -> usize {
    16 * rayon::current_num_threads().clamp(2, 16)
}
