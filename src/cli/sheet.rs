//! A command on a sheet of sprites: each cell is a frame of its own from reading on, and all are made by what is chosen once,
//! over the sheet.

use super::frames::{FrameCommand, command_of, save_recipe};
use super::job::{Done, Job};
use super::message;
use super::panics::caught;
use super::progress::cells_bar;
use super::run_log::RunLog;
use super::strips::take_judgement;
use super::threads::Lanes;
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::grid::Grid;
use crate::command::hatch::is_svg;
use crate::command::invocation::Invocation;
use crate::command::output::MadePicture;
use crate::command::recipe::RecipeText;
use crate::engine::outcome::{Outcome, add_timings};
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Frame, Mask, Plane, Window};
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::{Inputs, StoredDepth, Wrap};
use crate::io::picture::{Picture, ViewTransform};
use crate::io::{InputFiles, Loaded, Needs, PartOfPhotos, WholePhoto, wrapped};
use crate::light::albedo::AlbedoEstimate;
use crate::light::relight::albedo::estimate;
use crate::plan::{Albedo, Plan};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

/// A sheet that is being made.
pub(super) struct Sheet {
    grid: Grid,
    read: OnceLock<Read>,
    albedo: OnceLock<AlbedoEstimate>,
    made: Mutex<Made>,
}

/// The decoded sheet, and how its cells are read.
struct Read {
    photos: Arc<Vec<WholePhoto>>,
    inputs: Inputs,
    needs: Needs,
    window: Window,
    cells: Vec<Window>,
}

/// What the cells that are done have made, by the file it goes to.
#[derive(Default)]
struct Made {
    files: BTreeMap<PathBuf, (Form, Vec<Plane>)>,
    outcome: Outcome,
}

/// What planes are in a file.
pub(super) enum Form {
    /// A picture in linear light, and whether it was derived from the one that was read.
    Color { is_derived: bool },
    /// Another picture.
    Picture {
        grey: bool,
        bits: u8,
        dpi: Option<[f32; 2]>,
        transform: ViewTransform,
    },
    /// Layers.
    Channels(Vec<(String, OutputType)>),
}

/// The part of a sheet that a job is about.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    sheet: &'a Sheet,
    /// One of its cells; the whole sheet is looked at for what is chosen.
    cell: Option<Window>,
}

impl Part<'_> {
    pub(super) fn is_cell(&self) -> bool {
        self.cell.is_some()
    }

    pub(super) fn load(&self, inputs: &Inputs, needs: Needs) -> Result<Loaded> {
        match self.cell {
            Some(cell) => self.sheet.read().load(cell),
            None => self.sheet.look(inputs, needs),
        }
    }

    /// Makes the plan for a cell take the albedo that was estimated over the sheet.
    pub(super) fn settle_albedo(&self, plan: &mut Plan, frame: &Frame) {
        let relighting = plan.relighting.as_mut();
        let estimates = relighting.filter(|r| r.albedo == Albedo::Estimate);
        if let (Some(relighting), Some(_)) = (estimates, &frame.color) {
            let found = || estimate(frame, &frame.normal, frame.luminance_weights());
            relighting.estimate = Some(*self.sheet.albedo.get_or_init(found));
        }
    }

    pub(super) fn keep_channels(&self, job: &Job, outcome: &Outcome, channels: &[OutputChannel]) {
        let named = channels.iter().map(|c| (c.name.clone(), c.sample_type));
        let planes: Vec<_> = channels.iter().map(|channel| channel.plane).collect();
        self.keep(job, outcome, Form::Channels(named.collect()), &planes);
    }

    /// Puts the results of a cell, which go to the file of `job`, in its place.
    pub(super) fn keep(&self, job: &Job, outcome: &Outcome, form: Form, planes: &[&Plane]) {
        let (Some(cell), Some(path)) = (self.cell, &job.work.output.output) else {
            return;
        };
        let whole = self.sheet.read().window;
        let mut made = self.sheet.made();
        add_timings(&mut made.outcome.timings, &outcome.timings);
        let blank = |plane: &&Plane| match plane.samples().is_empty() {
            true => Plane::default(),
            false => Plane::filled(whole.width(), whole.height(), 0.0),
        };
        let file = made.files.entry(path.clone());
        let (_, sheet) = file.or_insert_with(|| (form, planes.iter().map(blank).collect()));
        let both = sheet.iter_mut().zip(planes);
        for (sheet, plane) in both.filter(|(_, plane)| !plane.samples().is_empty()) {
            sheet.paste(whole, cell, plane, cell);
        }
    }
}

impl Sheet {
    fn read(&self) -> &Read {
        self.read.get().expect("the sheet is looked at first")
    }

    fn made(&self) -> MutexGuard<'_, Made> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads the sheet as a whole, and settles how its cells are read; a gap keeps them apart in what is chosen.
    fn look(&self, inputs: &Inputs, mut needs: Needs) -> Result<Loaded> {
        // Cells have no common camera that could be found.
        needs.projection &= inputs.camera.is_some();
        let mut inputs = inputs.clone();
        let wrap = std::mem::replace(&mut inputs.wrap, Wrap::None);
        let files = InputFiles::open_sheet(&inputs, self.grid.0)?;
        let mut loaded = files.load(&inputs, needs)?;
        let photos = files.photos()?;
        let window = loaded.frame.data_window;
        let cells = self.grid.cells(window)?;
        take_judgement(&mut inputs, &loaded);
        inputs.wrap = match wrap {
            Wrap::Auto => common_wrap(&loaded.frame, &cells),
            given => given,
        };
        let read = self.read.get_or_init(|| Read {
            photos,
            inputs,
            needs,
            window,
            cells,
        });
        if loaded.normals_made.is_some() {
            read.take_made(&mut loaded)?;
        }
        loaded.frame.mask = self.apart(&loaded.frame.mask);
        Ok(loaded)
    }

    /// The mask without the outermost pixels of each cell.
    fn apart(&self, mask: &Mask) -> Mask {
        let Grid([width, height]) = self.grid;
        let is_inside = |at: usize, side: usize| at % side != 0 && at % side != side - 1;
        Mask::new(Plane::from_fn(mask.width(), mask.height(), |x, y| {
            mask.at(x, y) && is_inside(x, width) && is_inside(y, height)
        }))
    }
}

impl Read {
    fn load(&self, window: Window) -> Result<Loaded> {
        let part = PartOfPhotos {
            photos: self.photos.clone(),
            window,
        };
        InputFiles::open_part(&self.inputs, part)?.load(&self.inputs, self.needs)
    }

    /// Replaces normals that were made of depth by those of the cells: slopes go by the size of a picture, and so does how
    /// high heights are, and what is said of that.
    fn take_made(&self, sheet: &mut Loaded) -> Result<()> {
        let mut covered = sheet.frame.mask.plane().clone();
        for &cell in &self.cells {
            let Loaded {
                frame, warnings, ..
            } = self.load(cell)?;
            let (of_sheet, normal) = (&mut sheet.frame.normal, &frame.normal);
            of_sheet.x.paste(self.window, cell, &normal.x, cell);
            of_sheet.y.paste(self.window, cell, &normal.y, cell);
            of_sheet.z.paste(self.window, cell, &normal.z, cell);
            covered.paste(self.window, cell, frame.mask.plane(), cell);
            if self.inputs.depth_kind == Some(StoredDepth::Height) {
                sheet.warnings = warnings;
            }
        }
        sheet.frame.mask = Mask::new(covered);
        Ok(())
    }
}

/// The borders that continue each other in most cells that show anything.
fn common_wrap(frame: &Frame, cells: &[Window]) -> Wrap {
    let whole = frame.data_window;
    let (mut shown, mut count) = (0, [0; 2]);
    for &cell in cells {
        if frame.mask.crop(whole, cell).count() > 0 {
            shown += 1;
            let normal = frame.normal.mapped(|plane| plane.crop(whole, cell));
            let wraps = wrapped(&normal, Wrap::Auto);
            count = [0, 1].map(|axis| count[axis] + usize::from(wraps[axis]));
        }
    }
    match count.map(|count| 2 * count > shown) {
        [false, false] => Wrap::None,
        [true, false] => Wrap::X,
        [false, true] => Wrap::Y,
        [true, true] => Wrap::Xy,
    }
}

/// Makes a sheet.
pub(super) fn make<C: FrameCommand>(
    command: &C,
    recipe: &RecipeText,
    invocation: &Invocation,
    grid: Grid,
) -> Result<()> {
    let work = command.work();
    if is_svg(work) {
        return Err(Error::BadParameter {
            name: "--grid",
            found: "makes a sheet of pixels, and an SVG holds lines".into(),
            remedy: "write a .png".into(),
        });
    }
    let sheet = Sheet {
        grid,
        read: OnceLock::new(),
        albedo: OnceLock::new(),
        made: Mutex::default(),
    };
    let (log, started) = (RunLog::default(), Instant::now());
    let job = |recipe, work: &WorkArgs, cell| {
        let sheet = &sheet;
        Job::of_sheet(work.clone(), Part { sheet, cell }, &log, recipe)
    };
    let chosen = command.make(&command.prepare()?, &job(recipe, work, None))?;
    let words = chosen.in_words();
    if !work.run.quiet && !words.is_empty() {
        message::say(&format!("for all cells: {words}"));
    }
    let flags = chosen.flags();
    let (command, _) = command_by(command, &invocation.with(&flags));
    let recipe = &recipe.clone().choosing(flags);
    let work = command.work();
    save_recipe(work, &recipe.with(&Chosen::default()))?;
    if work.output.output.is_none() {
        return Ok(());
    }
    let kit = command.prepare()?;
    let cells = &sheet.read().cells;
    let bar = cells_bar(&work.run, cells.len());
    let (next, failed) = (AtomicUsize::new(0), OnceLock::new());
    Lanes::of(cells.len(), u64::MAX, false).each(|| {
        while let Some(&cell) = cells.get(next.fetch_add(1, Ordering::Relaxed)) {
            let job = job(recipe, work, Some(cell));
            match caught(&work.input, || command.make(&kit, &job)) {
                _ if failed.get().is_some() => return,
                Ok(_) => bar.inc(1),
                Err(error) => drop(failed.set(error)),
            }
        }
    });
    bar.finish_and_clear();
    match failed.into_inner() {
        Some(error) => Err(error),
        None => write(&sheet, &Job::new(work.clone(), &log, recipe).begun(started)),
    }
}

/// The command with the choices of the sheet, on the same files.
fn command_by<C: FrameCommand>(command: &C, invocation: &Invocation) -> (C, RecipeText) {
    let (mut chosen, recipe) = command_of::<C>(invocation);
    let (from, to) = (command.work(), chosen.work_mut());
    to.input = from.input.clone();
    to.more = from.more.clone();
    to.output = from.output.clone();
    (chosen, recipe)
}

/// Writes what all cells have made.
fn write(sheet: &Sheet, job: &Job) -> Result<()> {
    let read = sheet.read();
    let began = Instant::now();
    let loaded = read.load(read.window)?;
    let Made { files, outcome } = std::mem::take(&mut *sheet.made());
    let done = Done {
        loaded,
        outcome,
        read: began.elapsed(),
    };
    for (path, (form, planes)) in files {
        let job = job.writing_to(path);
        match form {
            Form::Color { is_derived } => {
                let before = done.loaded.frame.color.as_ref().filter(|_| is_derived);
                let color = &ColorPlanes::of(planes);
                job.write_color(
                    &done,
                    MadePicture {
                        color,
                        before,
                        like: None,
                    },
                )?
            }
            Form::Picture {
                grey,
                bits,
                dpi,
                transform,
            } => {
                let color = ColorPlanes::of(planes);
                job.write_picture(
                    &done,
                    &Picture {
                        grey,
                        bits,
                        dpi,
                        ..Picture::of(&color, transform)
                    },
                )?
            }
            Form::Channels(named) => {
                let channels = named.into_iter().zip(&planes);
                let channel = |((name, sample_type), plane)| OutputChannel {
                    name,
                    plane,
                    sample_type,
                };
                job.write_channels(&done, channels.map(channel).collect())?
            }
        };
    }
    Ok(())
}
