//! New light and drawings by both backends: error against time.

use super::SERIES;
use super::points::{Point, drawn};
use crate::report::pictures::PictureRow;

/// The largest error of each picture against the time of all its stages, a panel per picture. What is a reference itself has
/// no error to be shown.
pub fn error_of_pictures(name: &str, rows: &[PictureRow]) -> String {
    let legend = [("on the CPU", SERIES[0]), ("on the GPU", SERIES[2])];
    let point = |seconds: f64, error: f64| Point {
        place: (1e3 * seconds, error),
        label: String::new(),
        on_front: false,
    };
    let panels = rows.iter().map(|row| {
        let on_cpu = row.on_cpu.errors.iter();
        let on_cpu = on_cpu.map(|errors| point(row.on_cpu.whole.min, errors.max));
        let on_gpu = point(row.on_gpu.timed.whole.min, row.on_gpu.errors.max);
        // The device has the third colour, as beside the solvers.
        let series = vec![on_cpu.collect(), Vec::new(), vec![on_gpu]];
        (row.picture.clone(), series)
    });
    let title = format!("{name}: new light and drawings");
    let axes = ["all stages, ms", "largest error"];
    drawn(&title, &legend, axes, panels.collect())
}
