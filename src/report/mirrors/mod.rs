//! Mirrors and lenses: error against time for the steps of the search, its refinements and the resolution of the map
//! of the surroundings.
//!
//! The mirror image of a room in a ball is known exactly (`ball`, `room`): where sight lines end, and which way strokes
//! go there.

mod ball;
mod bench;
mod room;

pub(super) use ball::{EDGE_PX, FACING};
pub(super) use room::ABOUT;

use super::asked::Extent;
use super::compare::Tally;
use super::timing::{Effort, Times};
use crate::Result;
use crate::params::SearchParams;
use ball::{Ball, Shown};
use bench::MirrorBench;
use room::Surface;
use serde::Serialize;

/// Steps of the search that are tried. They are those of half a turn; a mirrored ray turns by a quarter of one at most, and
/// takes 4 of 8.
pub(super) const STEPS: [u32; 6] = [8, 16, 32, 64, 128, 256];
/// Refinements that are tried.
pub(super) const REFINEMENTS: [u32; 4] = [1, 2, 4, 12];
/// Rows of the map that are tried.
pub(super) const MAP_HEIGHTS: [usize; 6] = [16, 32, 64, 128, 256, 512];
/// Rows of the map where they are not varied.
pub(super) const USUAL_MAP_HEIGHT: usize = 256;

/// Half of all errors stay below the median, 95 in 100 below the other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Spread {
    pub median: f64,
    /// 95 in 100 stay below it.
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
pub(crate) struct Setting {
    /// Search for the ends of sight lines.
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
pub(crate) struct Row {
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
    pub(crate) fn astray(&self) -> f64 {
        1.0 - self.found + self.wrong_surface
    }
}

/// Everything that was measured of mirrors.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct MirrorReport {
    pub about: &'static str,
    pub size: usize,
    /// Pixels compared: those that face the viewer ([`FACING`]) and show what the map shows too.
    pub pixels: usize,
    /// Pixels of them that show a column.
    pub pixels_of_columns: usize,
    /// Share of the facing pixels that are left out: they show points that are hidden from the middle of the room.
    pub hidden: f64,
    pub steps: Vec<Row>,
    pub refinements: Vec<Row>,
    pub map_heights: Vec<Row>,
}

/// Rows by one setting.
pub(crate) struct Varied<'a> {
    pub(crate) name: &'static str,
    pub(crate) rows: &'a [Row],
    pub(crate) value: fn(&Setting) -> usize,
}

impl MirrorReport {
    /// The settings that were varied.
    pub(crate) fn varied(&self) -> [Varied<'_>; 3] {
        [
            Varied {
                name: "steps of the search",
                rows: &self.steps,
                value: |setting| setting.search.steps as usize,
            },
            Varied {
                name: "refinements",
                rows: &self.refinements,
                value: |setting| setting.search.refinements as usize,
            },
            Varied {
                name: "rows of the map",
                rows: &self.map_heights,
                value: |setting| setting.map_height,
            },
        ]
    }
}

/// Measures the mirror ball in its room.
pub(super) fn run(extent: Extent, progress: &dyn Fn(&str)) -> Result<MirrorReport> {
    let (size, effort) = match extent {
        Extent::Full => (320, Effort::new(3, 200)),
        Extent::Quick => (160, Effort::new(2, 60)),
    };
    let mut bench = MirrorBench::new(Ball { size }, effort);
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
    matches!(shown.hit.surface, Surface::Column(_))
}
