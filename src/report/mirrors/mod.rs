//! Mirrors and lenses: error against time for the steps of the search, its refinements and the resolution of the map of
//! the surroundings.
//!
//! The mirror image of a room in a ball is known exactly (`ball`, `room`): the hits of sight lines, and the stroke
//! directions there.

mod ball;
pub(super) mod bench;
mod room;

pub(super) use ball::{EDGE_PX, FACING};
pub(super) use room::ABOUT;

use super::asked::Extent;
use super::timing::Effort;
use crate::Result;
use crate::params::SearchParams;
use ball::{Ball, Shown};
use bench::{MirrorBench, MirrorRow, Setting};
use serde::Serialize;

/// Search steps tried, counted over half a turn; a mirrored ray covers at most a quarter turn, so it takes 4 of 8.
pub(super) const STEPS: [u32; 6] = [8, 16, 32, 64, 128, 256];
/// Refinements tried.
pub(super) const REFINEMENTS: [u32; 4] = [1, 2, 4, 12];
/// Rows of the map tried.
pub(super) const MAP_HEIGHTS: [usize; 6] = [16, 32, 64, 128, 256, 512];
/// All measurements of mirrors.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct MirrorReport {
    pub about: &'static str,
    pub size: usize,
    /// Number of pixels compared: those facing the viewer ([`FACING`]) that show points also shown by the map.
    pub pixels: usize,
    /// Number of those that show a column.
    pub pixels_of_columns: usize,
    /// Share of the facing pixels left out, because they show points hidden from the centre of the room.
    pub hidden: f64,
    pub steps: Vec<MirrorRow>,
    pub refinements: Vec<MirrorRow>,
    pub map_heights: Vec<MirrorRow>,
}

/// Rows for one varied setting.
pub(crate) struct Varied<'a> {
    pub(crate) name: &'static str,
    pub(crate) rows: &'a [MirrorRow],
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
        pixels_of_columns: count(|shown| shown.in_map && shown.is_column()),
        hidden: 1.0 - pixels as f64 / bench.shown.len() as f64,
        steps,
        refinements,
        map_heights,
    })
}
