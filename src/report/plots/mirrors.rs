//! Mirrors: where sight lines are found to end, against time.

use super::SERIES;
use super::points::{Point, drawn};
use crate::report::mirrors::{MirrorReport, Row};

/// An error of a row.
type Error = fn(&Row) -> f64;

/// What is measured of each setting, and what the plot calls it.
const LINES: [(&str, Error); 3] = [
    ("astray, share of pixels", Row::astray),
    ("points, 95 %", |row| row.position.p95),
    ("points, median", |row| row.position.median),
];

/// Sight lines gone astray and errors of the points found against time, a panel for each thing that is varied.
pub fn error_of_mirrors(mirrors: &MirrorReport) -> String {
    let legend: Vec<_> = LINES.iter().map(|(name, _)| *name).zip(SERIES).collect();
    let panel = |caption: &str, rows: &[Row], label: fn(&Row) -> String| {
        let points = LINES.iter().map(|(_, error)| {
            let point = |row: &Row| Point {
                place: (1e3 * row.stage.min, error(row)),
                label: label(row),
                on_front: false,
            };
            rows.iter().map(point).collect()
        });
        (caption.to_string(), points.collect())
    };
    let panels = vec![
        panel("by steps of the search", &mirrors.steps, |row| {
            row.setting.search.steps.to_string()
        }),
        panel("by refinements", &mirrors.refinements, |row| {
            row.setting.search.refinements.to_string()
        }),
        panel("by rows of the map", &mirrors.map_heights, |row| {
            row.setting.map_height.to_string()
        }),
    ];
    let title = format!(
        "mirror ball in a room with columns, {0}x{0}: what is found of it",
        mirrors.size
    );
    let axes = ["specular-trace, ms", "error"];
    drawn(&title, &legend, axes, panels)
}
