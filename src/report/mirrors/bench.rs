//! The ball traced with one setting after another.

use super::ball::{Ball, Shown};
use super::room;
use crate::Result;
use crate::frame::{Frame, SpecularScene};
use crate::params::{
    Bend, Fallback, FieldParams, LineParams, SearchParams, ShapeParams, SpecularParams,
};
use crate::plan::{Available, Plan};
use crate::report::compare::Tally;
use crate::report::engine::{Inputs, Session, hatch_plan};
use crate::report::scenes::angle_deg;
use crate::report::sweeps::directions::vector_at;
use crate::report::timing::{Effort, Times};
use crate::trace::Tracer;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;

/// Rows of the map when they are not varied.
pub(super) const USUAL_MAP_HEIGHT: usize = 256;

/// The median of errors, and the bound for 95 of 100.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Spread {
    pub median: f64,
    /// The bound for 95 of 100.
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

/// Settings for tracing a ball.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) struct Setting {
    /// Search for the hits of sight lines.
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

/// Results of one setting. Shares are 0..1.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct MirrorRow {
    pub setting: Setting,
    /// Share of the pixels whose sight line is found to hit something visible.
    pub found: f64,
    /// Share of the pixels where the surface found is not the exact one.
    pub wrong_surface: f64,
    /// Share of the pixels showing a column that was not found.
    pub columns_missed: f64,
    /// Distance between exact and found points, relative to their distance from the centre of the room.
    pub position: Spread,
    /// The same for exact points on columns.
    pub position_on_columns: Spread,
    /// Angle between exact and found stroke directions, in degrees, farther than [`EDGE_PX`](super::EDGE_PX) from
    /// edges; 90 if none is found.
    pub direction: Spread,
    /// The same on columns, where strokes follow the curvature of the map.
    pub direction_on_columns: Spread,
    /// Time of the stage that traces specular pixels.
    pub stage: Times,
}

impl MirrorRow {
    /// Share of the pixels whose sight line is not found to hit the right surface.
    pub(crate) fn astray(&self) -> f64 {
        1.0 - self.found + self.wrong_surface
    }
}

/// The ball, for repeated tracing in the same memory.
pub(super) struct MirrorBench {
    frame: Frame,
    /// Points shown by its pixels, by column and row.
    pub(super) shown: Vec<([usize; 2], Shown)>,
    effort: Effort,
    session: Session,
    /// The room with the map requested last.
    around: (usize, SpecularScene),
    /// Rows measured so far.
    known: Vec<MirrorRow>,
}

impl MirrorBench {
    pub(super) fn new(ball: Ball, effort: Effort) -> Self {
        let places = (0..ball.size).flat_map(|y| (0..ball.size).map(move |x| [x, y]));
        let shown = places.filter_map(|at| Some((at, ball.shown(at[0], at[1])?)));
        Self {
            frame: ball.frame(),
            shown: shown.collect(),
            effort,
            session: Session::default(),
            around: (0, SpecularScene::default()),
            known: Vec::new(),
        }
    }

    /// A row for each setting; settings measured earlier are reused.
    pub(super) fn rows(&mut self, settings: &[Setting]) -> Result<Vec<MirrorRow>> {
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

    fn row(&mut self, setting: Setting) -> Result<MirrorRow> {
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
        Ok(MirrorRow {
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

    /// The hits of sight lines.
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

    /// Angles between exact stroke directions and those of the field, at full resolution and without smoothing: on all
    /// surfaces, and on columns.
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
        let inputs = Inputs {
            specular: Some(&self.around.1),
            ..Inputs::default()
        };
        let field = self.session.stroke_field(&plan, &self.frame, inputs, &line);
        let [mut all, mut columns] = [Tally::default(), Tally::default()];
        for (at, shown) in self.shown.iter().filter(|(_, shown)| shown.in_map) {
            let Some(exact) = shown.direction else {
                continue;
            };
            let angle = angle_deg(vector_at(&field, *at), exact);
            all.add(*at, angle);
            if shown.is_column() {
                columns.add(*at, angle);
            }
        }
        Ok([all, columns].map(Spread::of))
    }

    /// Time of the stage in a drawing.
    fn time(&self, specular: SpecularParams) -> Result<Times> {
        let plan = self.plan(specular, LineParams::default())?;
        let inputs = Inputs {
            specular: Some(&self.around.1),
            ..Inputs::default()
        };
        let (outcome, timed) = self
            .session
            .measure(&plan, &self.frame, inputs, self.effort);
        self.session.recycle(outcome);
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
        hatch_plan(available, ShapeParams::default(), line)
    }
}

/// Hits of sight lines: counts of pixels, then shares.
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
        let (exact, is_column) = (&shown.hit, shown.is_column());
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
