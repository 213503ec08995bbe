//! Mirrors and lenses: error against time for the steps of the search, its refinements and the resolution of the map
//! of the surroundings.
//!
//! What a mirror ball shows of a room is known exactly (`room`): where sight lines end, and which way strokes go
//! there.

mod room;

pub use room::{ABOUT, EDGE_PX, FACING};

use super::Extent;
use super::compare::Tally;
use super::sweeps::directions::angle_deg;
use super::timing::{Effort, Times, measure_runs};
use crate::Result;
use crate::backend::cpu::{DrawingInputs, Runner};
use crate::frame::{Frame, SpecularScene};
use crate::params::{
    Bend, Fallback, FieldParams, LineParams, ScalingParams, SearchParams, ShapeParams,
    SpecularParams,
};
use crate::plan::{Available, Plan, ToneFrom};
use crate::trace::Tracer;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use room::{Scene, Shown, Surface};
use serde::Serialize;
use std::sync::Arc;

/// Steps of the search that are tried. They are those of half a turn; a mirrored ray turns by a quarter of one at most, and
/// takes 4 of 8.
pub const STEPS: [u32; 6] = [8, 16, 32, 64, 128, 256];
/// Refinements that are tried.
pub const REFINEMENTS: [u32; 4] = [1, 2, 4, 12];
/// Rows of the map that are tried.
pub const MAP_HEIGHTS: [usize; 6] = [16, 32, 64, 128, 256, 512];
/// Rows of the map where they are not varied.
pub const USUAL_MAP_HEIGHT: usize = 256;

/// Half of all errors stay below the median, 95 in 100 below the other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// What 95 in 100 stay below.
    pub p95: f64,
}

impl Spread {
    fn of(mut tally: Tally) -> Self {
        Self {
            median: tally.quantile(0.5),
            p95: tally.quantile(0.95),
        }
    }
}

/// How a ball is traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Setting {
    /// How what its sight lines meet is searched for.
    pub search: SearchParams,
    /// Rows of the map; it has twice as many columns.
    pub map_height: usize,
}

impl Default for Setting {
    fn default() -> Self {
        Self {
            search: SearchParams::default(),
            map_height: USUAL_MAP_HEIGHT,
        }
    }
}

/// What one setting gives. Shares are 0..1.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Row {
    /// The setting.
    pub setting: Setting,
    /// Share of the pixels whose sight line is found to end on something seen.
    pub found: f64,
    /// Share of the pixels where that is another surface than the exact one.
    pub wrong_surface: f64,
    /// Share of the pixels that show a column where it is not found.
    pub columns_missed: f64,
    /// From the exact points to those found, relative to their distance from the middle of the room.
    pub position: Spread,
    /// The same where the exact point is on a column.
    pub position_on_columns: Spread,
    /// From the exact directions of strokes to those found, in degrees, farther than [`EDGE_PX`] from edges; 90 where none
    /// is found.
    pub direction: Spread,
    /// The same on columns, where the map's own curvature leads strokes.
    pub direction_on_columns: Spread,
    /// Time of the stage that traces specular pixels.
    pub stage: Times,
}

impl Row {
    /// Share of the pixels whose sight line is not found to end on the right surface.
    pub fn astray(&self) -> f64 {
        1.0 - self.found + self.wrong_surface
    }
}

/// Everything that was measured of mirrors.
#[derive(Debug, Clone, Serialize)]
pub struct MirrorReport {
    /// What the scene shows.
    pub about: &'static str,
    /// Columns and rows of the picture.
    pub size: usize,
    /// Pixels compared: those that face the viewer ([`FACING`]) and show what the map shows too.
    pub pixels: usize,
    /// Pixels of them that show a column.
    pub pixels_of_columns: usize,
    /// Share of the facing pixels that are left out: what they show is not seen from the middle of the room.
    pub hidden: f64,
    /// By steps of the search.
    pub steps: Vec<Row>,
    /// By refinements.
    pub refinements: Vec<Row>,
    /// By rows of the map.
    pub map_heights: Vec<Row>,
}

/// Measures the mirror ball in its room.
///
/// # Errors
/// None for the settings tried here.
pub fn run(extent: Extent, progress: &dyn Fn(&str)) -> Result<MirrorReport> {
    let (size, effort) = match extent {
        Extent::Full => (320, Effort::new(3, 200)),
        Extent::Quick => (160, Effort::new(2, 60)),
    };
    let mut bench = Bench::new(Scene { size }, effort);
    let usual = Setting::default();
    let searching = |search| Setting { search, ..usual };
    progress("mirror ball: steps of the search");
    let steps = STEPS.map(|steps| {
        searching(SearchParams {
            steps,
            ..usual.search
        })
    });
    let steps = bench.rows(&steps)?;
    progress("mirror ball: refinements");
    let refinements = REFINEMENTS.map(|refinements| {
        searching(SearchParams {
            refinements,
            ..usual.search
        })
    });
    let refinements = bench.rows(&refinements)?;
    progress("mirror ball: resolution of the map");
    let map_heights = MAP_HEIGHTS.map(|map_height| Setting {
        map_height,
        ..usual
    });
    let map_heights = bench.rows(&map_heights)?;
    let count = |holds: fn(&Shown) -> bool| bench.shown.iter().filter(|(_, s)| holds(s)).count();
    let pixels = count(|shown| shown.in_map);
    Ok(MirrorReport {
        about: ABOUT,
        size,
        pixels,
        pixels_of_columns: count(|shown| shown.in_map && is_column(shown)),
        hidden: 1.0 - pixels as f64 / bench.shown.len() as f64,
        steps,
        refinements,
        map_heights,
    })
}

fn is_column(shown: &Shown) -> bool {
    matches!(shown.met.surface, Surface::Column(_))
}

/// The ball, to be traced again and again in the same memory.
struct Bench {
    frame: Frame,
    /// What its pixels show, with their columns and rows.
    shown: Vec<([usize; 2], Shown)>,
    effort: Effort,
    runner: Runner,
    /// The room by the map that was last asked for.
    around: (usize, SpecularScene),
    /// What was measured so far.
    known: Vec<Row>,
}

impl Bench {
    fn new(scene: Scene, effort: Effort) -> Self {
        let places = (0..scene.size).flat_map(|y| (0..scene.size).map(move |x| [x, y]));
        let shown = places.filter_map(|at| Some((at, scene.shown(at[0], at[1])?)));
        Self {
            frame: scene.frame(),
            shown: shown.collect(),
            effort,
            runner: Runner::default(),
            around: (0, SpecularScene::default()),
            known: Vec::new(),
        }
    }

    /// A row for each setting; what is known already is not measured again.
    fn rows(&mut self, settings: &[Setting]) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        for setting in settings {
            let known = self.known.iter().find(|row| row.setting == *setting);
            let row = match known {
                Some(row) => *row,
                None => self.row(*setting)?,
            };
            self.known.push(row);
            rows.push(row);
        }
        Ok(rows)
    }

    fn row(&mut self, setting: Setting) -> Result<Row> {
        if self.around.0 != setting.map_height {
            let scene = SpecularScene {
                surroundings: Some(Arc::new(room::surroundings(setting.map_height))),
                ..SpecularScene::default()
            };
            self.around = (setting.map_height, scene);
        }
        let specular = SpecularParams {
            bend: Bend::Mirror,
            search: setting.search,
        };
        let ends = self.ends(&specular);
        let [direction, direction_on_columns] = self.directions(specular)?;
        Ok(Row {
            setting,
            found: ends.found,
            wrong_surface: ends.wrong_surface,
            columns_missed: ends.columns_missed,
            position: Spread::of(ends.position),
            position_on_columns: Spread::of(ends.position_on_columns),
            direction,
            direction_on_columns,
            stage: self.time(specular)?,
        })
    }

    /// Where sight lines are found to end.
    fn ends(&self, specular: &SpecularParams) -> Ends {
        let tracer = Tracer::new(&self.frame, &self.around.1, specular);
        let tracer = tracer.expect("the ball has depth and a camera");
        let end = |[x, y]: [usize; 2]| {
            let hit = tracer.hit(&tracer.path(x, y)?.leaving())?;
            hit.is_seen.then_some(hit.point)
        };
        let found: Vec<_> = self.shown.par_iter().map(|(at, _)| end(*at)).collect();
        let mut ends = Ends::default();
        for ((at, shown), point) in self.shown.iter().zip(found) {
            if shown.in_map {
                ends.add(*at, shown, point);
            }
        }
        ends.shares()
    }

    /// From exact directions of strokes to those of the field, of full resolution and not averaged: on all surfaces, and
    /// on columns.
    fn directions(&self, specular: SpecularParams) -> Result<[Spread; 2]> {
        let line = LineParams {
            field: FieldParams {
                passes: 0,
                cell_px: 1,
                fallback: Fallback::Surface,
                ..FieldParams::default()
            },
            ..LineParams::default()
        };
        let plan = self.plan(specular, line)?;
        let scene = &self.around.1;
        let fields = self
            .runner
            .stroke_fields_through(&plan, &self.frame, scene, &line);
        let [mut all, mut columns] = [Tally::default(), Tally::default()];
        for (at, shown) in self.shown.iter().filter(|(_, shown)| shown.in_map) {
            let Some(exact) = shown.direction else {
                continue;
            };
            let [x, y] = [&fields[0].x, &fields[0].y].map(|plane| plane.at(at[0], at[1]));
            let angle = angle_deg(DVec2::new(x.into(), y.into()), exact);
            all.add(*at, angle);
            if is_column(shown) {
                columns.add(*at, angle);
            }
        }
        Ok([all, columns].map(Spread::of))
    }

    /// Time of the stage in a drawing.
    fn time(&self, specular: SpecularParams) -> Result<Times> {
        let plan = self.plan(specular, LineParams::default())?;
        let inputs = DrawingInputs {
            specular: Some(&self.around.1),
            ..DrawingInputs::default()
        };
        let draw = || self.runner.draw(&plan, &self.frame, inputs);
        let (outcome, timed) = measure_runs(&self.runner, self.effort, draw);
        self.runner.take_back(outcome);
        Ok(timed.stage("specular-trace").expect("a mirror is traced"))
    }

    fn plan(&self, specular: SpecularParams, line: LineParams) -> Result<Plan> {
        let available = Available {
            specular: Some(specular),
            ..Available::in_frame(&self.frame)
        };
        let line = LineParams {
            contours: None,
            ..line
        };
        let scaling = ScalingParams::default();
        Plan::hatch(
            available,
            ShapeParams::default(),
            scaling,
            ToneFrom::Picture,
            line,
        )
    }
}

/// What was found where sight lines end: counts of pixels, then shares.
#[derive(Default)]
struct Ends {
    pixels: f64,
    columns: f64,
    found: f64,
    wrong_surface: f64,
    columns_missed: f64,
    position: Tally,
    position_on_columns: Tally,
}

impl Ends {
    fn add(&mut self, at: [usize; 2], shown: &Shown, found: Option<DVec3>) {
        let (exact, is_column) = (&shown.met, is_column(shown));
        let is_right = found.is_some_and(|point| room::nearest_surface(point) == exact.surface);
        let one_if = |holds: bool| f64::from(u8::from(holds));
        self.pixels += 1.0;
        self.columns += one_if(is_column);
        self.found += one_if(found.is_some());
        self.wrong_surface += one_if(found.is_some() && !is_right);
        self.columns_missed += one_if(is_column && !is_right);
        if let Some(point) = found {
            let error = point.distance(exact.point) / room::from_center(exact.point);
            self.position.add(at, error);
            if is_column {
                self.position_on_columns.add(at, error);
            }
        }
    }

    fn shares(self) -> Self {
        Self {
            found: self.found / self.pixels,
            wrong_surface: self.wrong_surface / self.pixels,
            columns_missed: self.columns_missed / self.columns,
            ..self
        }
    }
}
