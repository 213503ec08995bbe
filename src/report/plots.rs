//! The report's pictures, as SVG: error against time with the Pareto front, and error near the rim.

use super::advice::scientific;
use super::sweeps::directions;
use super::sweeps::precision::Stored;
use super::sweeps::rim::{BANDS, BallRow, FLOORS, FORESHORTENINGS};
use super::sweeps::solver::{Row, ScaleSweep, SceneSweep};
use crate::params::Solver;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

type Drawn<T = ()> = std::result::Result<T, DrawingAreaErrorKind<std::io::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

const INK: RGBColor = RGBColor(40, 44, 52);
const FAINT: RGBColor = RGBColor(120, 126, 136);
const GRID: RGBColor = RGBColor(232, 234, 238);
const FRONT: RGBColor = RGBColor(240, 196, 60);
/// Colours that the colour-blind tell apart (Okabe and Ito), in the order of the series.
const SERIES: [RGBColor; 4] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(170, 80, 140),
];
/// Size of a panel in pixels.
const PANEL: (u32, u32) = (460, 350);
const HEADER: u32 = 70;
const FONT: &str = "sans-serif";

/// Largest error of the gradient against the time of diffusion, a panel per scale.
pub fn error_against_time(sweep: &SceneSweep) -> String {
    let title = format!(
        "{}, {}x{}: error of the diffused gradient against time",
        sweep.name, sweep.width, sweep.height
    );
    let mut legend = vec![
        ("Chebyshev, by tolerance (* asked for)", SERIES[0]),
        ("explicit, by step", SERIES[1]),
        ("Pareto front", FRONT),
    ];
    if sweep.scales.iter().any(|scale| !scale.on_gpu.is_empty()) {
        legend.push(("on the GPU", SERIES[2]));
    }
    let panels: Vec<_> = sweep
        .scales
        .iter()
        .filter(|scale| scale.rows.iter().any(drawable))
        .collect();
    let errors = panels
        .iter()
        .flat_map(|scale| scale.rows.iter().chain(rows_on_gpu(scale)))
        .filter(|row| drawable(row));
    let range = decades(errors.map(|row| row.gradient.max));
    figure(&title, &legend, panels.len(), |i, area| {
        solver_panel(area, panels[i], range.clone())
    })
}

/// Mean error of the trace on a ball by n_z, a panel per foreshortening and a line per floor.
pub fn error_near_the_rim(rows: &[BallRow]) -> String {
    let names = FLOORS.map(|floor| format!("min_nz {floor}"));
    let legend: Vec<_> = names.iter().map(String::as_str).zip(SERIES).collect();
    let means = rows.iter().flat_map(|row| &row.bands).map(|band| band.mean);
    let range = decades(means);
    let title = "ball: relative error of the curvature by n_z, with no diffusion";
    figure(title, &legend, FORESHORTENINGS.len(), |i, area| {
        rim_panel(area, rows, FORESHORTENINGS[i], range.clone())
    })
}

/// What 95 in 100 directions on an ellipsoid stay below, by step, a line per rounding of the normals.
pub fn error_against_step(sweep: &directions::Sweep) -> String {
    let legend = [
        ("float normals", SERIES[0]),
        ("half floats", SERIES[1]),
        ("8 bits", SERIES[2]),
        ("dashed: auto, from its least step to its greatest", FAINT),
    ];
    let range = decades(sweep.rows.iter().map(|row| row.p95));
    // No two directions are more than 90 degrees apart.
    let range = range.start..range.end.min(100.0);
    let title = format!(
        "{}, {}x{}: error of the directions of curvature by step",
        sweep.name, sweep.width, sweep.height
    );
    figure(&title, &legend, 1, |_, area| {
        direction_panel(area, sweep, range.clone())
    })
}

/// What a device gave.
fn rows_on_gpu(scale: &ScaleSweep) -> impl Iterator<Item = &Row> {
    scale.on_gpu.iter().map(|on_gpu| &on_gpu.row)
}

/// Whether a row has a place on logarithmic axes.
fn drawable(row: &Row) -> bool {
    row.gradient.max > 0.0 && row.gradient.max.is_finite() && row.diffusion.min > 0.0
}

/// The whole powers of ten around `values`.
fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = values.filter(|v| v.is_finite() && *v > 0.0);
    let (lo, hi) = finite.fold((f64::INFINITY, 0.0_f64), |(lo, hi), v| {
        (lo.min(v), hi.max(v))
    });
    if lo > hi {
        return 1e-3..1.0;
    }
    10_f64.powf(lo.log10().floor())..10_f64.powf((hi.log10() + 0.15).ceil())
}

/// A title, a legend, and panels in two columns.
fn figure(
    title: &str,
    legend: &[(&str, RGBColor)],
    panels: usize,
    panel: impl Fn(usize, &Area) -> Drawn,
) -> String {
    let columns = panels.clamp(1, 2);
    let rows = panels.div_ceil(columns).max(1);
    let size = (
        PANEL.0 * columns.max(2) as u32,
        HEADER + PANEL.1 * rows as u32,
    );
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let draw = || -> Drawn {
            root.fill(&WHITE)?;
            let (header, body) = root.split_vertically(HEADER);
            draw_header(&header, title, legend)?;
            let areas = body.split_evenly((rows, columns));
            for (i, area) in areas.iter().enumerate().take(panels) {
                panel(i, area)?;
            }
            root.present()
        };
        draw().expect("a string takes any picture");
    }
    svg
}

fn text(size: i32, color: RGBColor) -> TextStyle<'static> {
    (FONT, size).into_font().color(&color)
}

fn draw_header(area: &Area, title: &str, legend: &[(&str, RGBColor)]) -> Drawn {
    area.draw(&Text::new(title.to_string(), (18, 12), text(18, INK)))?;
    let mut x = 20;
    for (name, color) in legend {
        area.draw(&Rectangle::new([(x, 46), (x + 22, 52)], color.filled()))?;
        area.draw(&Text::new((*name).to_string(), (x + 28, 42), text(14, INK)))?;
        // Letters of 14 pixels are 7 to 8 wide.
        x += 28 + 8 * name.len() as i32 + 18;
    }
    Ok(())
}

/// The axes of a panel, both logarithmic, with ticks at 1, 2 and 5 below if no others are given.
macro_rules! axes {
    ($area:expr, $caption:expr, $x:expr, $y:expr, $x_name:expr, $y_name:expr) => {{
        let ticks = ticks(&$x, &[1.0, 2.0, 5.0]);
        axes!($area, $caption, $x, ticks, $y, $x_name, $y_name)
    }};
    ($area:expr, $caption:expr, $x:expr, $x_ticks:expr, $y:expr, $x_name:expr, $y_name:expr) => {{
        let (x, y): (Range<f64>, Range<f64>) = ($x, $y);
        let (x_ticks, y_ticks) = ($x_ticks, ticks(&y, &[1.0]));
        let mut chart = ChartBuilder::on($area)
            .caption($caption, text(16, INK))
            .margin(14)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d(
                x.log_scale().with_key_points(x_ticks),
                y.log_scale().with_key_points(y_ticks),
            )?;
        chart
            .configure_mesh()
            .axis_style(FAINT)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .label_style(text(13, INK))
            .axis_desc_style(text(14, INK))
            .x_labels(20)
            .y_labels(20)
            .x_label_formatter(&|v| plain(*v))
            .y_label_formatter(&|v| power_of_ten(*v))
            .x_desc($x_name)
            .y_desc($y_name)
            .draw()?;
        chart
    }};
}

/// The multiples `of` of powers of ten that lie in `range`.
fn ticks(range: &Range<f64>, of: &[f64]) -> Vec<f64> {
    let decades = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let all = decades.flat_map(|e| of.iter().map(move |m| m * 10_f64.powi(e)));
    // The bounds are powers of ten themselves, met up to rounding.
    all.filter(|v| range.start * (1.0 - 1e-9) <= *v && *v <= range.end * (1.0 + 1e-9))
        .collect()
}

mod coherence;
mod drawing;
mod light;
mod mirrors;
mod pictures;
mod points;

pub use coherence::difference_by_frame;
pub use drawing::{error_of_directions, strokes_by_levels};
pub use light::{both_equations, error_against_lights};
pub use mirrors::error_of_mirrors;
pub use pictures::error_of_pictures;

fn solver_panel(area: &Area, sweep: &ScaleSweep, errors: Range<f64>) -> Drawn {
    let rows: Vec<_> = sweep.rows.iter().filter(|row| drawable(row)).collect();
    let on_gpu: Vec<_> = rows_on_gpu(sweep).filter(|row| drawable(row)).collect();
    let times = rows
        .iter()
        .chain(&on_gpu)
        .map(|row| 1e3 * row.diffusion.min);
    let (first, last) = times.fold((f64::INFINITY, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
    // Room for labels at both sides.
    let times = first / 2.2..last * 2.2;
    let caption = sweep.scale.as_str();
    let mut chart = axes!(
        area,
        caption,
        times,
        errors,
        "diffusion, ms",
        "largest error / max |g|"
    );

    let mut front: Vec<_> = rows
        .iter()
        .filter(|row| row.on_front)
        .map(|row| position(row))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, FRONT.mix(0.6).stroke_width(9)))?;
    for (solver, color) in [
        (Solver::Chebyshev, SERIES[0]),
        (Solver::Explicit, SERIES[1]),
    ] {
        let mut line: Vec<_> = rows.iter().filter(|row| row.solver == solver).collect();
        line.sort_by_key(|row| row.applications);
        let points = line.iter().map(|row| position(row));
        chart.draw_series(LineSeries::new(points, color.mix(0.55).stroke_width(2)))?;
        for row in &line {
            chart.draw_series([Circle::new(position(row), 4, color.filled())])?;
            if row.on_front {
                chart.draw_series([Circle::new(position(row), 7, color.stroke_width(2))])?;
            }
        }
        // The expansion's points lie to the left of the steps', and so do their labels.
        let (side, offset) = match solver {
            Solver::Chebyshev => (HPos::Right, (-11, 5)),
            Solver::Explicit => (HPos::Left, (10, -3)),
        };
        for (label, place) in labels(&line) {
            let style = text(12, color).pos(Pos::new(side, VPos::Bottom));
            chart.draw_series([EmptyElement::at(place) + Text::new(label, offset, style)])?;
        }
    }
    let on_gpu = on_gpu.iter().map(|row| position(row));
    chart.draw_series(on_gpu.map(|at| TriangleMarker::new(at, 6, SERIES[2].filled())))?;
    Ok(())
}

/// Time in milliseconds and error.
fn position(row: &Row) -> (f64, f64) {
    (1e3 * row.diffusion.min, row.gradient.max)
}

/// Labels of points: those that would fall on the one before are left out, what was asked for never.
fn labels(line: &[&&Row]) -> Vec<(String, (f64, f64))> {
    let mut kept: Vec<(String, (f64, f64))> = Vec::new();
    for row in line {
        let (time, error) = position(row);
        let apart =
            |(t, e): (f64, f64)| (time / t).ln().abs() > 0.3 || (error / e).ln().abs() > 1.2;
        if row.asked_for || kept.iter().all(|(_, place)| apart(*place)) {
            let value = row.setting.rsplit(' ').next().unwrap_or_default();
            let mark = if row.asked_for { "* " } else { "" };
            kept.push((format!("{mark}{value}"), (time, error)));
        }
    }
    kept
}

fn direction_panel(area: &Area, sweep: &directions::Sweep, errors: Range<f64>) -> Drawn {
    let steps = directions::STEPS_PX.map(f64::from);
    let bounds = 0.85 * steps[0]..steps[steps.len() - 1] / 0.85;
    let mut chart = axes!(
        area,
        "95 % stay below",
        bounds,
        steps.to_vec(),
        errors,
        "step, px",
        "degrees"
    );
    for (stored, color) in Stored::ALL.into_iter().zip(SERIES) {
        let rows = sweep.rows.iter().filter(|row| row.stored == stored);
        let (fixed, auto): (Vec<_>, Vec<_>) = rows.partition(|row| row.step_px.is_some());
        let points: Vec<_> = fixed
            .iter()
            .filter_map(|row| Some((f64::from(row.step_px?), row.p95)))
            .collect();
        chart.draw_series(LineSeries::new(points.clone(), color.stroke_width(2)))?;
        chart.draw_series(points.iter().map(|&p| Circle::new(p, 4, color.filled())))?;
        for row in auto {
            let [least, most] = row.steps_px.map(|step| (step as f64, row.p95));
            let style = color.stroke_width(2);
            chart.draw_series(DashedLineSeries::new([least, most], 6, 5, style))?;
            chart.draw_series([least, most].map(|p| Circle::new(p, 7, style)))?;
        }
    }
    Ok(())
}

fn rim_panel(area: &Area, rows: &[BallRow], foreshortening: f32, errors: Range<f64>) -> Drawn {
    let caption = format!("foreshortening {foreshortening}");
    let bounds = BANDS[0]..BANDS[BANDS.len() - 1];
    let floor_of_plot = errors.start;
    let mut chart = axes!(
        area,
        caption.as_str(),
        bounds,
        errors.clone(),
        "n_z",
        "mean relative error"
    );
    let lines = rows
        .iter()
        .filter(|row| row.foreshortening == foreshortening);
    for ((row, color), size) in lines.zip(SERIES).zip([7, 6, 4, 3]) {
        let middles = BANDS.windows(2).map(|band| (band[0] * band[1]).sqrt());
        let points: Vec<_> = middles
            .zip(&row.bands)
            .map(|(nz, band)| (nz, band.mean.max(floor_of_plot)))
            .collect();
        chart.draw_series(LineSeries::new(
            points.iter().copied(),
            color.stroke_width(2),
        ))?;
        chart.draw_series(
            points
                .iter()
                .map(|&point| Circle::new(point, size, color.filled())),
        )?;
        // Where the floor lies; without foreshortening it takes no part.
        let floor = f64::from(row.min_nz);
        if foreshortening > 0.0 && bounds_hold(floor) {
            let line = [(floor, errors.start), (floor, errors.end)];
            chart.draw_series(DashedLineSeries::new(
                line,
                3,
                4,
                color.mix(0.7).stroke_width(1),
            ))?;
        }
    }
    Ok(())
}

fn bounds_hold(nz: f64) -> bool {
    BANDS[0] < nz && nz < BANDS[BANDS.len() - 1]
}

/// A tick without an exponent.
fn plain(value: f64) -> String {
    if value >= 1.0 {
        format!("{value:.0}")
    } else {
        format!("{}", (value * 1e4).round() / 1e4)
    }
}

/// A tick as a power of ten, 10⁻³; between powers nothing.
fn power_of_ten(value: f64) -> String {
    let exponent = value.log10();
    if (exponent - exponent.round()).abs() > 1e-6 {
        return scientific(value);
    }
    let digits = format!("{}", exponent.round() as i32);
    let raised = digits.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    });
    format!("10{}", raised.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_powers_of_ten() {
        assert_eq!(power_of_ten(1e-4), "10⁻⁴");
        assert_eq!(power_of_ten(1e12), "10¹²");
        assert_eq!((plain(20.0), plain(0.05)), ("20".into(), "0.05".into()));
    }

    #[test]
    fn ranges_are_whole_decades_around_the_values() {
        assert_eq!(
            decades([2e-4, 0.3, f64::INFINITY, 0.0].into_iter()),
            1e-4..1.0
        );
        assert_eq!(decades(std::iter::empty()), 1e-3..1.0);
    }
}
