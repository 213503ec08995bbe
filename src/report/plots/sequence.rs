//! Differences of drawings from frame to frame.

use super::figure::{FAINT, GRID, INK, SERIES, svg, text};
use crate::report::coherence::{Coherence, CoherenceRow};
use plotters::prelude::*;

type Difference = fn(&CoherenceRow) -> f64;

/// Differences of a row, and their names in the plot.
const LINES: [(&str, Difference); 4] = [
    ("still in the picture", |row| row.still),
    ("carried", |row| row.carried),
    ("floor", |row| row.floor),
    ("lines", |row| row.lines),
];

/// Mean differences of ink by frame, one line per kind and one for the floor.
pub(super) fn difference_by_frame(coherence: &Coherence) -> String {
    let rows = &coherence.rows;
    let legend: Vec<_> = LINES.iter().map(|(name, _)| *name).zip(SERIES).collect();
    let values = rows.iter().flat_map(|row| LINES.map(|(_, of)| of(row)));
    let most = values.fold(0.0, f64::max).max(1e-3);
    let frames = || rows.iter().map(|row| f64::from(row.frame));
    let first = frames().fold(f64::INFINITY, f64::min);
    let last = frames().fold(0.0, f64::max);
    let title = "the sequence: difference between a drawing and the one before, moved along";
    svg(title, &legend, 1, |_, area| {
        let mut chart = ChartBuilder::on(area)
            .margin(14)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d(first - 0.5..last + 0.5, 0.0..1.1 * most)?;
        chart
            .configure_mesh()
            .axis_style(FAINT)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .label_style(text(13, INK))
            .axis_desc_style(text(14, INK))
            .x_labels(rows.len().min(12))
            .x_label_formatter(&|frame| format!("{frame:.0}"))
            .y_label_formatter(&|ink| format!("{ink:.2}"))
            .x_desc("frame")
            .y_desc("mean difference of ink")
            .draw()?;
        for ((_, of), color) in LINES.into_iter().zip(SERIES) {
            let points = || rows.iter().map(|row| (f64::from(row.frame), of(row)));
            chart.draw_series(LineSeries::new(points(), color.stroke_width(2)))?;
            chart.draw_series(points().map(|at| Circle::new(at, 4, color.filled())))?;
        }
        Ok(())
    })
}
