//! Panels of settings as points: what they give by what they take.

use super::{Area, Drawn, FRONT, SERIES, decades, figure, plain, power_of_ten, text, ticks};
use super::{FAINT, GRID, INK};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// A setting on a plot.
pub(super) struct Point {
    /// What it takes, as time in milliseconds, and what it gives, as an error.
    pub(super) place: (f64, f64),
    /// What is written beside it.
    pub(super) label: String,
    /// Whether it is on the Pareto front of its series.
    pub(super) on_front: bool,
}

impl Point {
    /// Whether it has a place on logarithmic axes.
    fn is_drawable(&self) -> bool {
        let (time, error) = self.place;
        time > 0.0 && error > 0.0 && error.is_finite()
    }
}

/// A figure of panels, each with a caption and a line per series, and a name for both axes.
pub(super) fn drawn(
    title: &str,
    legend: &[(&str, RGBColor)],
    axes: [&str; 2],
    mut panels: Vec<(String, Vec<Vec<Point>>)>,
) -> String {
    for series in panels.iter_mut().flat_map(|(_, series)| series) {
        series.retain(Point::is_drawable);
    }
    panels.retain(|(_, series)| series.iter().any(|points| !points.is_empty()));
    let all = panels.iter().flat_map(|(_, series)| series).flatten();
    let errors = decades(all.map(|point| point.place.1));
    figure(title, legend, panels.len(), |i, area| {
        let (caption, series) = &panels[i];
        panel(area, caption, series, errors.clone(), axes)
    })
}

fn panel(
    area: &Area,
    caption: &str,
    series: &[Vec<Point>],
    errors: Range<f64>,
    [times_name, errors_name]: [&str; 2],
) -> Drawn {
    let times = series.iter().flatten().map(|point| point.place.0);
    let (first, last) = times.fold((f64::INFINITY, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
    let times = first / 1.6..last * 2.2;
    let ticked = match last / first > 200.0 {
        true => ticks(&times, &[1.0]),
        false => ticks(&times, &[1.0, 2.0, 5.0]),
    };
    let mut chart = axes!(
        area,
        caption,
        times,
        ticked,
        errors,
        times_name,
        errors_name
    );
    for (points, color) in series.iter().zip(SERIES) {
        let mut front: Vec<_> = points.iter().filter(|p| p.on_front).collect();
        front.sort_by(|a, b| a.place.0.total_cmp(&b.place.0));
        let front = front.iter().map(|point| point.place);
        chart.draw_series(LineSeries::new(front, FRONT.mix(0.6).stroke_width(9)))?;
        let line = points.iter().map(|point| point.place);
        chart.draw_series(LineSeries::new(line, color.mix(0.55).stroke_width(2)))?;
        let mut labelled: Option<(f64, f64)> = None;
        for point in points {
            chart.draw_series([Circle::new(point.place, 4, color.filled())])?;
            // A label that would fall on the one before is left out.
            let apart = labelled.is_none_or(|(time, error)| {
                (point.place.0 / time).ln().abs() > 0.25 || (point.place.1 / error).ln().abs() > 0.7
            });
            if apart {
                labelled = Some(point.place);
                let style = text(12, color).pos(Pos::new(HPos::Left, VPos::Bottom));
                let label = Text::new(point.label.clone(), (8, -4), style);
                chart.draw_series([EmptyElement::at(point.place) + label])?;
            }
        }
    }
    Ok(())
}
