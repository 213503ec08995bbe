//! Error of light against time.

use super::points::{Point, drawn};
use super::{FRONT, SERIES};
use crate::report::advice::noun;
use crate::report::light::Subject;
use crate::report::light::equations;
use crate::report::light::samples;

const AXES: [&str; 2] = ["lighting, ms", "error of 99 % / white"];

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
    drawn(&title, &legend, AXES, panels.collect())
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
    drawn(&title, &legend, AXES, panels.collect())
}
