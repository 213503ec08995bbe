//! The report's pictures as SVG, each declared as panels of series of points.

mod figure;
mod sequence;

use super::Report;
use super::advice::{altered, noun};
use super::drawing::{field, strokes};
use super::light::Subject;
use super::light::samples::Sample;
use super::mirrors::MirrorReport;
use super::mirrors::bench::MirrorRow;
use super::sweeps::directions;
use super::sweeps::precision::Stored;
use super::sweeps::rim::{BANDS, BallRow, FLOORS, FORESHORTENINGS};
use super::sweeps::solver::{ScaleSweep, SceneSweep, SolverRow};
use crate::params::Solver;
use crate::untrusted::Untrusted;
use figure::{FAINT, FRONT, Marks, Panel, Point, SERIES, Series, figure, figure_up_to, ticks};
use plotters::style::text_anchor::HPos;

pub(super) const FRAME: &str = "frame.svg";
pub(super) const DIRECTIONS: &str = "directions.svg";
pub(super) const RIM: &str = "rim.svg";
pub(super) const FIELDS: &str = "stroke-directions.svg";
pub(super) const STROKES: &str = "strokes.svg";
pub(super) const MIRRORS: &str = "mirrors.svg";
pub(super) const COHERENCE: &str = "coherence.svg";

/// Name of the plot of an exact scene.
pub(super) fn of_scene(scene: &SceneSweep) -> String {
    format!("{}.svg", scene.on.name)
}

/// Names of the plots of light: by number of lights, by equation.
pub(super) fn of_light(subject: &Subject) -> [String; 2] {
    // A frame may have any name.
    let name = match subject.is_frame {
        true => "",
        false => &format!("{}-", subject.on.name),
    };
    ["lights", "equations"].map(|plot| format!("{name}{plot}.svg"))
}

/// All plots, by file name.
pub(crate) fn all(report: &Report) -> Vec<(String, String)> {
    let scenes = report.scenes.iter();
    let mut plots: Vec<_> = scenes
        .map(|scene| (of_scene(scene), error_against_time(scene)))
        .collect();
    for subject in report.light.iter().flat_map(|light| &light.subjects) {
        let plots_of_light = [error_against_lights(subject), both_equations(subject)];
        plots.extend(of_light(subject).into_iter().zip(plots_of_light));
    }
    let mut add = |name: &str, plot| plots.push((name.into(), plot));
    add(FRAME, error_against_time(&report.frame));
    if let Some(directions) = &report.directions {
        add(DIRECTIONS, error_against_step(directions));
    }
    if !report.rim_of_ball.is_empty() {
        add(RIM, error_near_the_rim(&report.rim_of_ball));
    }
    if let Some(drawing) = &report.drawing {
        add(FIELDS, error_of_directions(&drawing.fields));
        add(STROKES, strokes_by_levels(&drawing.strokes));
    }
    if let Some(mirrors) = &report.mirrors {
        add(MIRRORS, error_of_mirrors(mirrors));
    }
    if let Some(coherence) = &report.coherence {
        add(COHERENCE, sequence::difference_by_frame(coherence));
    }
    plots
}

/// Largest gradient error against diffusion time, one panel per scale.
fn error_against_time(sweep: &SceneSweep) -> String {
    let legend = [
        ("Chebyshev, by tolerance (* asked for)", SERIES[0]),
        ("explicit, by step", SERIES[1]),
        ("Pareto front", FRONT),
    ];
    let point = |row: &SolverRow| {
        let value = row.setting.rsplit(' ').next().unwrap_or_default();
        let mark = if row.asked_for { "* " } else { "" };
        let label = format!("{mark}{value}");
        Point {
            is_marked: row.asked_for,
            on_front: row.on_front,
            ..Point::new(1e3 * row.diffusion.min, row.gradient.max, label)
        }
    };
    let panel = |scale: &ScaleSweep| {
        // The expansion's points are left of the steps', so their labels are too.
        let solvers = [
            (Solver::Chebyshev, SERIES[0], HPos::Right),
            (Solver::Explicit, SERIES[1], HPos::Left),
        ];
        let solvers = solvers.map(|(solver, color, labels)| {
            let mut rows: Vec<_> = scale
                .rows
                .iter()
                .filter(|row| row.solver == solver)
                .collect();
            rows.sort_by_key(|row| row.applications);
            let points = rows.into_iter().map(point);
            Series {
                labels,
                ..Series::new(color, Marks::Discs(4), points)
            }
        });
        Panel::new(&scale.scale, solvers)
    };
    let title = format!("{}: error of the diffused gradient against time", sweep.on);
    let axes = ["diffusion, ms", "largest error / max |g|"];
    figure(&title, &legend, axes, sweep.scales.iter().map(panel))
}

/// Mean error of the trace on a ball by n_z, one panel per foreshortening and one line per floor.
fn error_near_the_rim(rows: &[BallRow]) -> String {
    let names = FLOORS.map(|floor| format!("min_nz {floor}"));
    let legend: Vec<_> = names.iter().map(String::as_str).zip(SERIES).collect();
    let bounds = BANDS[0]..BANDS[BANDS.len() - 1];
    let ticks = ticks(&bounds, &[1.0, 2.0, 5.0]);
    let panels = FORESHORTENINGS.map(|foreshortening| {
        let rows = rows
            .iter()
            .filter(|row| row.foreshortening == foreshortening);
        let styles = SERIES.into_iter().zip([7, 6, 4, 3]);
        let series = rows.zip(styles).flat_map(|(row, (color, radius))| {
            let bands = BANDS.windows(2).zip(&row.bands);
            let points = bands.map(|(b, errors)| Point::new((b[0] * b[1]).sqrt(), errors.mean, ""));
            // Position of the floor; without foreshortening it has no effect.
            let floor = f64::from(row.min_nz);
            let takes_part = foreshortening > 0.0 && BANDS[0] < floor && floor < bounds.end;
            let floor = takes_part.then(|| Point::new(floor, 1.0, ""));
            [
                Series::new(color, Marks::Discs(radius), points),
                Series::new(color, Marks::Uprights, floor.into_iter()),
            ]
        });
        Panel {
            x: Some((bounds.clone(), ticks.clone())),
            ..Panel::new(format!("foreshortening {foreshortening}"), series)
        }
    });
    let title = "ball: relative error of the curvature by n_z, with no diffusion";
    figure(title, &legend, ["n_z", "mean relative error"], panels)
}

/// The 95th percentile of direction errors on an ellipsoid, by step, one line per rounding of the normals.
fn error_against_step(sweep: &directions::Sweep) -> String {
    let legend = [
        ("float normals", SERIES[0]),
        ("half floats", SERIES[1]),
        ("8 bits", SERIES[2]),
        ("dashed: auto, from its least step to its greatest", FAINT),
    ];
    let series = Stored::ALL
        .into_iter()
        .zip(SERIES)
        .flat_map(|(stored, color)| {
            let rows = || sweep.rows.iter().filter(move |row| row.stored == stored);
            let fixed =
                rows().filter_map(|row| Some(Point::new(row.step_px?.into(), row.error.p95, "")));
            let auto = rows().filter(|row| row.step_px.is_none());
            let auto = auto.flat_map(|row| {
                row.steps_px
                    .map(|px| Point::new(px as f64, row.error.p95, ""))
            });
            [
                Series::new(color, Marks::Discs(4), fixed),
                Series::new(color, Marks::Rings, auto),
            ]
        });
    let steps = directions::STEPS_PX.map(f64::from);
    let bounds = 0.85 * steps[0]..steps[steps.len() - 1] / 0.85;
    let panel = Panel {
        x: Some((bounds, steps.into())),
        ..Panel::new("95 % stay below", series)
    };
    let title = format!("{}: error of the directions of curvature by step", sweep.on);
    // Directions are at most 90 degrees apart.
    figure_up_to(100.0, &title, &legend, ["step, px", "degrees"], [panel])
}

/// Axes of plots of lighting error against time.
const LIGHT: [&str; 2] = ["lighting, ms", "error of 99 % / white"];

fn sample(sample: &Sample) -> Point {
    let error = sample.difference.errors.p99;
    Point::new(1e3 * sample.relight.min, error, sample.count)
}

/// The 99th percentile of errors against lighting time, by number of lights; one panel per material and method.
fn error_against_lights(subject: &Subject) -> String {
    let panels = subject.samples.iter().map(|sweep| {
        let points = sweep.rows.iter().map(|row| Point {
            on_front: row.on_front,
            ..sample(&row.sample)
        });
        let caption = format!("{}, {}", noun(sweep.surface), altered(sweep.method));
        Panel::new(caption, [Series::new(SERIES[0], Marks::Discs(4), points)])
    });
    let title = format!("{}: lights that stand for an environment", subject.on);
    let legend = [("by median cut", SERIES[0]), ("Pareto front", FRONT)];
    figure(&title, &legend, LIGHT, panels)
}

/// The same for warped light with either equation, one panel per material.
fn both_equations(subject: &Subject) -> String {
    let legend = [
        ("equation 1: look-ups", SERIES[1]),
        ("equation 2: lights", SERIES[0]),
    ];
    let series =
        |color, samples: &[Sample]| Series::new(color, Marks::Discs(4), samples.iter().map(sample));
    let panels = subject.equations.iter().map(|sweep| {
        let lookups = series(SERIES[1], &sweep.lookups);
        Panel::new(
            noun(sweep.surface),
            [series(SERIES[0], &sweep.lights), lookups],
        )
    });
    let title = format!("{}: both equations of light warping", subject.on);
    figure(&title, &legend, LIGHT, panels)
}

/// Angle to full resolution against time, by cell size of the field; one panel per frame.
fn error_of_directions(sweeps: &[field::Sweep]) -> String {
    let panels = sweeps.iter().map(|sweep| {
        let resolutions = &sweep.rows[..field::CELLS_PX.len()];
        let points = resolutions.iter().map(|row| Point {
            on_front: row.on_front,
            ..Point::new(1e3 * row.stage.min, row.from_full.p95, row.cell_px)
        });
        Panel::new(
            Untrusted(&sweep.on.name).to_string(),
            [Series::new(SERIES[0], Marks::Discs(4), points)],
        )
    });
    let legend = [
        ("by px of the picture to one of the field", SERIES[0]),
        ("Pareto front", FRONT),
    ];
    let axes = ["direction-field, ms", "95 % within, degrees"];
    let title = "directions of strokes: angle from the field of full resolution";
    figure(title, &legend, axes, panels)
}

/// How well strokes follow the field and how long they are, by levels, one line per number of sets.
fn strokes_by_levels(sweep: &strokes::Sweep) -> String {
    let names = strokes::SETS.map(|sets| match sets {
        1 => "1 set".to_string(),
        _ => format!("{sets} sets"),
    });
    let legend: Vec<_> = names.iter().map(String::as_str).zip(SERIES).collect();
    let panel = |caption: &str, of: fn(&strokes::StrokeRow) -> f64| {
        let series = strokes::SETS.into_iter().zip(SERIES).map(|(sets, color)| {
            let rows = sweep.rows.iter().filter(|row| row.sets == sets);
            let points = rows.map(|row| Point::new(row.levels.into(), of(row), ""));
            Series::new(color, Marks::Discs(4), points)
        });
        Panel::new(caption, series)
    };
    let title = format!("{}: strokes by levels", sweep.on);
    let panels = [
        panel("unbroken, %", |row| 100.0 * row.unbroken),
        panel("from the field, degrees", |row| row.from_field.mean),
    ];
    figure(&title, &legend, ["levels", ""], panels)
}

type SightLineError = fn(&MirrorRow) -> f64;

/// Errors of a mirror's sight lines, by plot name.
const SIGHT_LINES: [(&str, SightLineError); 3] = [
    ("astray, share of pixels", MirrorRow::astray),
    ("points, 95 %", |row| row.position.p95),
    ("points, median", |row| row.position.median),
];

/// Stray sight lines and errors of found points against time, one panel per varied setting.
fn error_of_mirrors(mirrors: &MirrorReport) -> String {
    let legend = [0, 1, 2].map(|i| (SIGHT_LINES[i].0, SERIES[i]));
    let panels = mirrors.varied().map(|varied| {
        let series = SIGHT_LINES.iter().zip(SERIES).map(|((_, error), color)| {
            let point = |row: &MirrorRow| {
                Point::new(
                    1e3 * row.stage.min,
                    error(row),
                    (varied.value)(&row.setting),
                )
            };
            Series::new(color, Marks::Discs(4), varied.rows.iter().map(point))
        });
        Panel::new(format!("by {}", varied.name), series)
    });
    let title = format!(
        "mirror ball in a room with columns, {0}x{0}: what is found of it",
        mirrors.size
    );
    figure(&title, &legend, ["specular-trace, ms", "error"], panels)
}
