//! The field of directions: number of passes, and resolution relative to the picture.

use super::Card;
use crate::Result;
use crate::frame::Vector2Planes;
use crate::params::{FieldParams, LineParams, MAX_FIELD_PASSES};
use crate::report::asked::On;
use crate::report::compare::Angles;
use crate::report::compare::{Tally, covered};
use crate::report::pareto;
use crate::report::scenes::Scene;
use crate::report::scenes::angle_deg;
use crate::report::sweeps::directions::vector_at;
use crate::report::timing::Times;
use glam::DVec2;
use serde::Serialize;

/// Cell sizes of the field tried, in pixels of the picture.
pub(crate) const CELLS_PX: [u32; 4] = [8, 4, 2, 1];

/// Results of one setting.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct FieldRow {
    /// Number of smoothing passes.
    pub passes: u32,
    /// Cell size of the field, in pixels of the picture.
    pub cell_px: u32,
    /// Angles to the field of full resolution with the same number of passes.
    pub from_full: Angles,
    /// Angles to the exact directions, if known.
    pub from_exact: Option<Angles>,
    /// Mean turn per pixel, in degrees: a measure of how calm strokes are.
    pub turn: f64,
    pub stage: Times,
    /// Whether no other resolution with the same number of passes is both faster and closer to the full one.
    pub on_front: bool,
}

/// All settings on one frame.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Sweep {
    #[serde(flatten)]
    pub on: On,
    /// All resolutions at the default number of passes, then all passes at the default resolution.
    pub rows: Vec<FieldRow>,
}

pub(super) fn sweep(name: &str, bench: &Card, exact: Option<&Scene>) -> Result<Sweep> {
    let usual = FieldParams::default();
    let resolutions = CELLS_PX.map(|cell_px| FieldParams { cell_px, ..usual });
    let passes = (0..=MAX_FIELD_PASSES).filter(|&passes| passes != usual.passes);
    let passes = passes.map(|passes| FieldParams { passes, ..usual });
    let mut rows = Vec::new();
    for params in resolutions.into_iter().chain(passes) {
        rows.push(row(bench, params, exact)?);
    }
    let place = |row: &FieldRow| [row.stage.min, row.from_full.p95];
    pareto::mark(&mut rows[..CELLS_PX.len()], place, |row| &mut row.on_front);
    Ok(Sweep {
        on: On::new(name, &bench.card.mask),
        rows,
    })
}

fn row(bench: &Card, params: FieldParams, exact: Option<&Scene>) -> Result<FieldRow> {
    let found = bench.field(params)?;
    let full = bench.field(FieldParams {
        cell_px: 1,
        ..params
    })?;
    let (_, timed) = bench.timed(LineParams {
        field: params,
        ..LineParams::default()
    })?;
    let from = |known: &dyn Fn([usize; 2]) -> Option<DVec2>| {
        let mut tally = Tally::default();
        for at in covered(&bench.card.mask) {
            if let Some(known) = known(at) {
                tally.add(at, angle_deg(vector_at(&found, at), known));
            }
        }
        Angles::of(tally)
    };
    Ok(FieldRow {
        passes: params.passes,
        cell_px: params.cell_px,
        from_full: from(&|at| Some(vector_at(&full, at))),
        from_exact: exact.map(|scene| from(&|[x, y]| scene.exact_direction(x, y))),
        turn: turn(bench, &found),
        stage: timed
            .stage("direction-field")
            .expect("strokes follow a field"),
        on_front: false,
    })
}

/// Mean angle between the directions of neighbouring pixels.
fn turn(bench: &Card, found: &Vector2Planes) -> f64 {
    let mask = &bench.card.mask;
    let mut tally = Tally::default();
    for [x, y] in covered(mask) {
        if x + 1 < mask.width() && mask.at(x + 1, y) {
            let [here, right] = [[x, y], [x + 1, y]].map(|at| vector_at(found, at));
            tally.add([x, y], angle_deg(here, right));
        }
    }
    tally.errors().mean
}
