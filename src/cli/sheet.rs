//! A command on a sheet of sprites: all cells are made by what is chosen once, over the sheet.

use super::cells::{CellForm, MadeCells, Sheet};
use super::frames::{self, begin, settled};
use super::job::{Done, Job};
use super::kit::Kit;
use super::make::make;
use super::panics::caught;
use super::progress::cells_bar;
use super::run_log::RunLog;
use super::threads::FrameThreads;
use crate::command::grid::CellSize;
use crate::command::invocation::Task;
use crate::error::{Result, bad};
use crate::frame::ColorPlanes;
use crate::io::exr::OutputChannel;
use crate::io::output::picture::MadePicture;
use crate::plan::outcome::Outcome;
use std::borrow::Cow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Makes one picture, as it is or cell by cell.
pub(super) fn one(task: &Task) -> Result<()> {
    match task.command.work().args().sequence.grid {
        Some(grid) => make_sheet(task, grid),
        None => frames::one(task),
    }
}

/// Makes a sheet.
fn make_sheet(task: &Task, grid: CellSize) -> Result<()> {
    begin(task)?;
    if task.command.work().args().output.is_svg() {
        return Err(bad(
            "--grid",
            "makes a sheet of pixels, and an SVG holds lines",
            "write a .png",
        ));
    }
    let sheet = Sheet::new(grid);
    let (log, started) = (RunLog::default(), Instant::now());
    // Nothing is written before all cells are done.
    let part = |task, cell| Job {
        writes: false,
        part: Some(sheet.part(cell)),
        ..Job::of(task, &log, None)
    };
    let chosen = make(&Kit::of(task.command.work())?, &part(task, None))?;
    let task = &settled(task, "cells", &chosen, None)?;
    let args = task.command.work().args();
    if args.output.output.is_none() {
        return Ok(());
    }
    let kit = Kit::of(task.command.work())?;
    let cells = sheet.cells();
    let bar = cells_bar(&args.run, cells.len());
    let (next, failed) = (AtomicUsize::new(0), OnceLock::new());
    FrameThreads::of(cells.len(), u64::MAX, false).each(|| {
        while let Some(&cell) = cells.get(next.fetch_add(1, Ordering::Relaxed)) {
            let job = part(task, Some(cell));
            match caught(&args.input, || make(&kit, &job)) {
                _ if failed.get().is_some() => return,
                Ok(_) => bar.inc(1),
                Err(error) => drop(failed.set(error)),
            }
        }
    });
    bar.finish_and_clear();
    match failed.into_inner() {
        Some(error) => Err(error),
        None => {
            let job = Job::of(task, &log, None);
            write(sheet, &Job { started, ..job })
        }
    }
}

/// Writes what all cells have made.
fn write(sheet: Sheet, job: &Job) -> Result<()> {
    let began = Instant::now();
    let (loaded, MadeCells { files, timings }) = sheet.finish()?;
    let done = Done {
        loaded,
        outcome: Outcome {
            timings,
            ..Outcome::default()
        },
        read: began.elapsed(),
    };
    for (path, (form, planes)) in files {
        let mut job = job.clone();
        job.command.work_mut().args_mut().output.output = Some(path);
        match form {
            CellForm::Picture { form, is_derived } => {
                let frame = &done.loaded.frame;
                let made = MadePicture {
                    color: Cow::Owned(ColorPlanes::of(planes)),
                    before: frame.color.as_ref().filter(|_| is_derived),
                    like: None,
                    form,
                };
                job.write_picture(&done, made)?
            }
            CellForm::Channels(named) => {
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
