//! Drawings: directions against time, strokes by levels.

use super::points::{Point, drawn};
use super::{FRONT, SERIES};
use crate::report::drawing::{field, strokes};

/// Angle from full resolution against time, by pixels of the picture to one of the field; a panel per frame.
pub fn error_of_directions(sweeps: &[field::Sweep]) -> String {
    let legend = [
        ("by px of the picture to one of the field", SERIES[0]),
        ("Pareto front", FRONT),
    ];
    let panels = sweeps.iter().map(|sweep| {
        let resolutions = &sweep.rows[..field::CELLS_PX.len()];
        let points = resolutions.iter().map(|row| Point {
            place: (1e3 * row.stage.min, row.from_full.p95),
            label: row.cell_px.to_string(),
            on_front: row.on_front,
        });
        (sweep.name.clone(), vec![points.collect()])
    });
    let axes = ["direction-field, ms", "95 % within, degrees"];
    let title = "directions of strokes: angle from the field of full resolution";
    drawn(title, &legend, axes, panels.collect())
}

/// How well strokes follow the field and how far they run, by levels, a line per number of sets.
pub fn strokes_by_levels(sweep: &strokes::Sweep) -> String {
    let names = strokes::SETS.map(|sets| match sets {
        1 => "1 set".to_string(),
        _ => format!("{sets} sets"),
    });
    let legend: Vec<_> = names.iter().map(String::as_str).zip(SERIES).collect();
    let panel = |caption: &str, of: fn(&strokes::Row) -> f64| {
        let series = strokes::SETS.map(|sets| {
            let rows = sweep.rows.iter().filter(|row| row.sets == sets);
            let points = rows.map(|row| Point {
                place: (f64::from(row.levels), of(row)),
                label: String::new(),
                on_front: false,
            });
            points.collect()
        });
        (caption.to_string(), Vec::from(series))
    };
    let title = format!(
        "{}, {}x{}: strokes by levels",
        sweep.name, sweep.width, sweep.height
    );
    let panels = vec![
        panel("unbroken, %", |row| 100.0 * row.unbroken),
        panel("from the field, degrees", |row| row.from_field.mean),
    ];
    drawn(&title, &legend, ["levels", ""], panels)
}
