//! The page's section on mirrors.

use super::{percent_to_a_tenth, table};
use crate::report::advice::of_mirrors;
use crate::report::mirrors::bench::{Setting, Spread};
use crate::report::mirrors::{EDGE_PX, FACING, MirrorReport, Varied};
use crate::report::numbers::{rounded, scientific};
use crate::report::plots::MIRRORS;

pub(super) fn section(mirrors: &MirrorReport) -> String {
    let Setting { search, map_height } = Setting::default();
    format!(
        "## Mirrors and lenses\n\n{}\n\nOn {}, in a picture of {}x{}: {} pixels, {} of which show a column. Pixels that are seen at a cosine \
         below {FACING} are left out, and so are those that show what is not seen from the middle of the room, from where \
         the map is ({} of the others). One of the settings is varied, the others are {} steps, {} refinements and a map of {} rows \
         and twice as many columns.\n\n\
         Found are sight lines that end on something seen; columns are missed where another surface or none is found. Points are off, median / 95 % of \
         those found, relative to their distance from the middle of the room; directions of strokes, in degrees and farther than {EDGE_PX} px from edges, from those \
         of the exact points' surfaces as the ball shows them. What is left of the latter at every setting is that of \
         pixels beside one another. Walls are flat, and the map's planes exact there: its \
         resolution shows on columns and edges.\n\n![Error against time]({MIRRORS})\n\n{}",
        of_mirrors(mirrors),
        mirrors.about,
        mirrors.size,
        mirrors.size,
        mirrors.pixels,
        mirrors.pixels_of_columns,
        percent_to_a_tenth(mirrors.hidden),
        search.steps,
        search.refinements,
        map_height,
        tables(mirrors),
    )
}

/// A table for each varied setting, which names its first column.
fn tables(mirrors: &MirrorReport) -> String {
    let spread = |spread: &Spread, word: fn(f64) -> String| {
        [spread.median, spread.p95].map(word).join(" / ")
    };
    let table = |varied: &Varied| {
        let mut table = table!(&varied.rows, row => {
            "varied": (varied.value)(&row.setting),
            "found": percent_to_a_tenth(row.found),
            "on a wrong surface": percent_to_a_tenth(row.wrong_surface),
            "columns missed": percent_to_a_tenth(row.columns_missed),
            "points": spread(&row.position, scientific),
            "points on columns": spread(&row.position_on_columns, scientific),
            "directions": spread(&row.direction, rounded),
            "directions on columns": spread(&row.direction_on_columns, rounded),
            "specular-trace min / median": row.stage,
        });
        table.head[0] = varied.name.into();
        table.to_string()
    };
    mirrors.varied().iter().map(table).collect()
}
