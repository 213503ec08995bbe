//! Mirrors on the page.

use super::super::mirrors::{EDGE_PX, FACING, MirrorReport, Row, Setting, Spread};
use super::{pair, table};
use crate::report::advice::{of_mirrors, rounded, scientific};

/// Name of the plot of mirrors.
pub const MIRRORS_PLOT: &str = "mirrors.svg";

pub(super) fn section(mirrors: &MirrorReport) -> String {
    let Setting { search, map_height } = Setting::default();
    let parts = [
        ("steps of the search", &mirrors.steps, steps as Varied),
        ("refinements", &mirrors.refinements, refinements),
        ("rows of the map", &mirrors.map_heights, map_height_of),
    ];
    let tables: String = parts
        .into_iter()
        .map(|(name, rows, varied)| by(name, rows, varied))
        .collect();
    format!(
        "## Mirrors and lenses\n\n{}\n\nOn {}, in a picture of {}x{}: {} pixels, {} of which show a column. Pixels that are seen at a cosine \
         below {FACING} are left out, and so are those that show what is not seen from the middle of the room, from where \
         the map is ({} of the others). One of the settings is varied, the others are {} steps, {} refinements and a map of {} rows \
         and twice as many columns.\n\n\
         Found are sight lines that end on something seen; columns are missed where another surface or none is found. Points are off, median / 95 % of \
         those found, relative to their distance from the middle of the room; directions of strokes, in degrees and farther than {EDGE_PX} px from edges, from those \
         of the exact points' surfaces as the ball shows them. What is left of the latter at every setting is that of \
         pixels beside one another. Walls are flat, and the map's planes exact there: its \
         resolution shows on columns and edges.\n\n![Error against time]({MIRRORS_PLOT})\n\n{tables}",
        of_mirrors(mirrors),
        mirrors.about,
        mirrors.size,
        mirrors.size,
        mirrors.pixels,
        mirrors.pixels_of_columns,
        share_of_few(mirrors.hidden),
        search.steps,
        search.refinements,
        map_height,
    )
}

/// What is varied, of a setting.
type Varied = fn(&Setting) -> usize;

fn steps(setting: &Setting) -> usize {
    setting.search.steps as usize
}

fn refinements(setting: &Setting) -> usize {
    setting.search.refinements as usize
}

fn map_height_of(setting: &Setting) -> usize {
    setting.map_height
}

fn by(name: &str, rows: &[Row], varied: Varied) -> String {
    let spread = |spread: &Spread, word: fn(f64) -> String| {
        format!("{} / {}", word(spread.median), word(spread.p95))
    };
    let cells = rows.iter().map(|row| {
        vec![
            varied(&row.setting).to_string(),
            share_of_few(row.found),
            share_of_few(row.wrong_surface),
            share_of_few(row.columns_missed),
            spread(&row.position, scientific),
            spread(&row.position_on_columns, scientific),
            spread(&row.direction, rounded),
            spread(&row.direction_on_columns, rounded),
            pair(row.stage),
        ]
    });
    let head = [
        name,
        "found",
        "on a wrong surface",
        "columns missed",
        "points",
        "points on columns",
        "directions",
        "directions on columns",
        "specular-trace min / median",
    ];
    table(&head, cells)
}

/// Per cent, to a tenth.
fn share_of_few(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}
