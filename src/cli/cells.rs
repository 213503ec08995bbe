//! Sheets of sprites: reading their cells, each as a frame of its own, and putting together what is made of them.

use crate::command::args::WorkArgs;
use crate::command::grid::CellSize;
use crate::error::Result;
use crate::frame::{Frame, Mask, Plane, Window};
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::{Inputs, StoredDepth, Wrap};
use crate::io::output::picture::Form;
use crate::io::{Holding, InputFiles, Loaded, Needs, PartOfPhotos, WholePhoto, wrapped};
use crate::kernel::timings::add_timings;
use crate::light::albedo::AlbedoEstimate;
use crate::light::relight::albedo_search::estimated;
use crate::light::relight::setting::Albedo;
use crate::plan::Plan;
use crate::plan::outcome::Outcome;
use crate::plan::search::ChosenFrom;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

/// A sheet that is being made.
pub(super) struct Sheet {
    grid: CellSize,
    read: OnceLock<ReadSheet>,
    albedo: OnceLock<AlbedoEstimate>,
    made: Mutex<MadeCells>,
}

/// The decoded sheet, and how its cells are read.
struct ReadSheet {
    photos: Arc<Vec<WholePhoto>>,
    inputs: Inputs,
    needs: Needs,
    window: Window,
    cells: Vec<Window>,
}

/// What the cells that are done have made.
#[derive(Default)]
pub(super) struct MadeCells {
    /// Planes by the file they go to.
    pub(super) files: BTreeMap<PathBuf, (CellForm, Vec<Plane>)>,
    pub(super) timings: Vec<(&'static str, Duration)>,
}

/// What planes are in a file.
pub(super) enum CellForm {
    /// A picture, and whether it was derived from the one that was read.
    Picture { form: Form, is_derived: bool },
    /// Layers.
    Channels(Vec<(String, OutputType)>),
}

/// The part of a sheet that a job is about.
#[derive(Clone, Copy)]
pub(super) struct SheetPart<'a> {
    sheet: &'a Sheet,
    /// One of its cells; the whole sheet is looked at for what is chosen.
    cell: Option<Window>,
}

impl SheetPart<'_> {
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
        let relighting = plan.relighting();
        let estimates = relighting.is_some_and(|own| own.albedo == Albedo::Estimate);
        if estimates && frame.color.is_some() {
            let found = || estimated(&ChosenFrom::whole(frame));
            plan.set_estimate(*self.sheet.albedo.get_or_init(found));
        }
    }

    pub(super) fn keep_channels(
        &self,
        work: &WorkArgs,
        outcome: &Outcome,
        channels: &[OutputChannel],
    ) {
        let named = channels.iter().map(|c| (c.name.clone(), c.sample_type));
        let planes: Vec<_> = channels.iter().map(|channel| channel.plane).collect();
        self.keep(work, outcome, CellForm::Channels(named.collect()), &planes);
    }

    /// Puts the results of a cell in its place in the file that they go to.
    pub(super) fn keep(
        &self,
        work: &WorkArgs,
        outcome: &Outcome,
        form: CellForm,
        planes: &[&Plane],
    ) {
        let (Some(cell), Some(path)) = (self.cell, &work.output.output) else {
            return;
        };
        let whole = self.sheet.read().window;
        let mut made = self.sheet.made();
        add_timings(&mut made.timings, &outcome.timings);
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
    pub(super) fn new(grid: CellSize) -> Self {
        Self {
            grid,
            read: OnceLock::new(),
            albedo: OnceLock::new(),
            made: Mutex::default(),
        }
    }

    /// A cell of it, or the whole.
    pub(super) fn part(&self, cell: Option<Window>) -> SheetPart<'_> {
        SheetPart { sheet: self, cell }
    }

    /// Its cells, once it has been looked at.
    pub(super) fn cells(&self) -> &[Window] {
        &self.read().cells
    }

    /// It as it was read, and what its cells have made.
    pub(super) fn finish(self) -> Result<(Loaded, MadeCells)> {
        let loaded = self.read().load(self.read().window)?;
        let made = self.made.into_inner();
        Ok((loaded, made.unwrap_or_else(PoisonError::into_inner)))
    }

    fn read(&self) -> &ReadSheet {
        self.read.get().expect("the sheet is looked at first")
    }

    fn made(&self) -> MutexGuard<'_, MadeCells> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads the sheet as a whole, and settles how its cells are read; a gap keeps them apart in what is chosen.
    fn look(&self, inputs: &Inputs, mut needs: Needs) -> Result<Loaded> {
        // Cells have no common camera that could be found.
        needs.projection &= inputs.camera.is_some();
        let mut inputs = inputs.clone();
        let wrap = std::mem::replace(&mut inputs.wrap, Wrap::None);
        let holding = Holding {
            stay: true,
            cell: Some(self.grid.0),
            ..Holding::default()
        };
        let files = InputFiles::open(&inputs, holding)?;
        let mut loaded = files.load(&inputs, needs)?;
        let photos = files.photos()?;
        let window = loaded.frame.data_window;
        let cells = self.grid.cells(window)?;
        loaded.settle(&mut inputs);
        inputs.wrap = match wrap {
            Wrap::Auto => common_wrap(&loaded.frame, &cells),
            given => given,
        };
        let read = self.read.get_or_init(|| ReadSheet {
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
        let CellSize([width, height]) = self.grid;
        let is_inside = |at: usize, side: usize| (1..side - 1).contains(&(at % side));
        Mask::new(Plane::from_fn(mask.width(), mask.height(), |x, y| {
            mask.at(x, y) && is_inside(x, width) && is_inside(y, height)
        }))
    }
}

impl ReadSheet {
    fn load(&self, window: Window) -> Result<Loaded> {
        let photos = self.photos.clone();
        let holding = Holding {
            part: Some(PartOfPhotos { photos, window }),
            stay: true,
            ..Holding::default()
        };
        InputFiles::open(&self.inputs, holding)?.load(&self.inputs, self.needs)
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
