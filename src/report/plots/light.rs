//! Error of light against time.

use super::{Area, Drawn, FRONT, SERIES, decades, figure, plain, power_of_ten, text, ticks};
use super::{FAINT, GRID, INK};
use crate::report::advice::noun;
use crate::report::light::Subject;
use crate::report::light::equations;
use crate::report::light::samples;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// A number of samples on a plot.
struct Point {
    /// Time in milliseconds, and error.
    place: (f64, f64),
    label: String,
    on_front: bool,
}

impl Point {
    /// Whether it has a place on logarithmic axes.
    fn is_drawable(&self) -> bool {
        let (time, error) = self.place;
        time > 0.0 && error > 0.0 && error.is_finite()
    }
}

/// What 99 pixels in 100 stay below against the time of lighting, by number of lights; a panel per
/// surface and method.
pub fn error_against_lights(subject: &Subject) -> String {
    let title = format!(
        "{}, {}x{}: lights that stand for an environment",
        subject.name, subject.width, subject.height
    );
    let legend = [("by median cut", SERIES[0]), ("Pareto front", FRONT)];
    let panels = subject.samples.iter().map(|sweep| {
        let altered = if sweep.method.warps() {
            "warped"
        } else {
            "plain"
        };
        let caption = format!("{}, {altered}", noun(sweep.surface));
        (caption, vec![sweep.rows.iter().map(of_row).collect()])
    });
    drawn(&title, &legend, panels.collect())
}

fn of_row(row: &samples::Row) -> Point {
    Point {
        place: (1e3 * row.relight.min, row.difference.errors.p99),
        label: row.count.to_string(),
        on_front: row.on_front,
    }
}

/// The same for warped light by either equation, a panel per surface.
pub fn both_equations(subject: &Subject) -> String {
    let title = format!(
        "{}, {}x{}: both equations of light warping",
        subject.name, subject.width, subject.height
    );
    let legend = [
        ("equation 1: look-ups", SERIES[1]),
        ("equation 2: lights", SERIES[0]),
    ];
    let points = |samples: &[equations::Sample]| -> Vec<Point> {
        let point = |sample: &equations::Sample| Point {
            place: (1e3 * sample.relight.min, sample.difference.errors.p99),
            label: sample.count.to_string(),
            on_front: false,
        };
        samples.iter().map(point).collect()
    };
    let panels = subject.equations.iter().map(|sweep| {
        let series = vec![points(&sweep.lights), points(&sweep.lookups)];
        (noun(sweep.surface).to_string(), series)
    });
    drawn(&title, &legend, panels.collect())
}

fn drawn(
    title: &str,
    legend: &[(&str, RGBColor)],
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
        panel(area, caption, series, errors.clone())
    })
}

fn panel(area: &Area, caption: &str, series: &[Vec<Point>], errors: Range<f64>) -> Drawn {
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
        "lighting, ms",
        "error of 99 % / white"
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
