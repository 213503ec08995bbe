//! The report as a page of Markdown.

mod coherence;
mod drawing;
mod gpu;
mod light;
mod mirrors;
mod stability;

pub use coherence::COHERENCE_PLOT;
pub use drawing::{FIELD_PLOT, STROKES_PLOT};
pub use gpu::PICTURES_PLOT;
pub use light::plot_names as light_plot_names;
pub use mirrors::MIRRORS_PLOT;

use super::Report;
use super::advice::{BUDGETS, cheapest, milliseconds, rounded, scientific, sentence};
use super::compare::Errors;
use super::sweeps::rim::{BANDS, FORESHORTENINGS};
use super::sweeps::solver::{Row, ScaleSweep, SceneSweep};
use super::timing::{Times, Utilisation};
use std::fmt::Write;

/// Name of the plot of a frame or scene.
pub fn plot_name(index: Option<usize>, report: &Report) -> String {
    match index {
        None => "frame.svg".into(),
        Some(i) => format!("{}.svg", report.scenes[i].name),
    }
}

/// Name of the plot of errors near the rim.
pub const RIM_PLOT: &str = "rim.svg";

/// Name of the plot of errors of directions.
pub const DIRECTION_PLOT: &str = "directions.svg";

/// The whole page. Its pictures are looked for beside it.
pub fn page(report: &Report) -> String {
    let mut page = String::new();
    let sections = [
        head(report),
        enough(report),
        not_needed(report),
        solvers(&report.frame, "The frame", &plot_name(None, report)),
        exact_scenes(report),
        stages(report),
        gpu::section(report),
        runs(report),
        precision(report),
        directions(report),
        rim(report),
        light::section(&report.light),
        drawing::section(&report.drawing),
        mirrors::section(&report.mirrors),
        coherence::section(report.coherence.as_ref()),
        stability::section(&report.stability),
    ];
    for section in sections.iter().filter(|section| !section.is_empty()) {
        page.push_str(section.trim_end());
        page.push_str("\n\n");
    }
    page.truncate(page.trim_end().len());
    page.push('\n');
    page
}

/// A table from its head and rows.
fn table(head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    // A bar inside a cell would end it.
    let line = |cells: Vec<String>| {
        let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let names = line(head.iter().map(|name| name.to_string()).collect());
    let rule = format!("|{}\n", "---|".repeat(head.len()));
    names + &rule + &rows.into_iter().map(line).collect::<String>() + "\n"
}

fn head(report: &Report) -> String {
    let Report { machine, frame, .. } = report;
    let unoptimised = if report.optimised {
        ""
    } else {
        "\n**Built without optimisation: the times mean little.**\n"
    };
    format!(
        "# relievo report: {}\n\n\
         relievo {} on {} threads; memory {} GB/s (triad over 3 x 64 MiB), arithmetic {} Gop/s ({}, single \
         precision, as this build is vectorised).\n{unoptimised}\n\
         Frame: {}x{}, {} pixels covered, steepest slope {}.\n\n\
         Errors of slopes, and of the curvature (the trace of the Hessian, per pixel), are relative to the \
         steepest slope, max |g| before diffusion. The reference is double precision from the same input \
         and conductance. Times are without reading and writing, in the memory of earlier runs, as for the second \
         and later frames of a sequence; `min` is the least of several runs.",
        frame.name,
        report.version,
        machine.threads,
        rounded(machine.bytes_per_second / 1e9),
        rounded(machine.operations_per_second / 1e9),
        machine.multiply_add,
        frame.width,
        frame.height,
        frame.covered,
        rounded(frame.steepest),
    )
}

fn enough(report: &Report) -> String {
    let sweep = &report.frame.scales[0];
    let rows = BUDGETS.iter().map(|&budget| match cheapest(sweep, budget) {
        Some(row) => vec![
            scientific(budget),
            format!(
                "`{} {}`",
                sweep.flag,
                row.flags.as_deref().unwrap_or_default()
            ),
            row.applications.to_string(),
            milliseconds(row.diffusion.min),
            milliseconds(row.whole.min),
            scientific(row.gradient.max),
            rounded(row.grey_levels),
        ],
        None => [scientific(budget), "nothing tried".into()]
            .into_iter()
            .chain(vec!["".to_string(); 5])
            .collect(),
    });
    let head = [
        "largest error within",
        "cheapest",
        "sweeps",
        "diffusion min",
        "all stages min",
        "largest error",
        "grey levels of 255",
    ];
    format!(
        "## What is enough here\n\n{}\n\n{}",
        sentence(report),
        table(&head, rows)
    )
}

fn not_needed(report: &Report) -> String {
    let skipped: Vec<_> = report.decisions.iter().filter(|d| !d.kept).collect();
    let lines = skipped
        .iter()
        .map(|d| format!("- {}: {}\n", d.stage.name(), d.reason));
    format!(
        "## What a picture of this frame's curvature does not need\n\n{}",
        lines.collect::<String>()
    )
}

fn solvers(sweep: &SceneSweep, title: &str, plot: &str) -> String {
    let mut text = format!(
        "## {title}\n\n{}, {}x{}, {} pixels covered: {}.\n\n![Error against time]({plot})\n",
        sweep.name, sweep.width, sweep.height, sweep.covered, sweep.about
    );
    for scale in &sweep.scales {
        let _ = write!(
            text,
            "\n### {}\n\n{}",
            match scale.scale.starts_with("sigma") {
                true => scale.scale.clone(),
                false => format!("{}, sigma {} px", scale.scale, rounded(scale.sigma_px)),
            },
            solver_table(scale)
        );
    }
    text
}

const SOLVER_HEAD: [&str; 16] = [
    "solver",
    "setting",
    "sweeps",
    "allowed",
    "mean",
    "99 %",
    "max",
    "worst at",
    "overshoot",
    "not finite",
    "curvature max",
    "diffusion min / median",
    "all min / median",
    "Mpix/s",
    "bandwidth",
    "arithmetic",
];

fn solver_table(scale: &ScaleSweep) -> String {
    let closed = scale
        .rows
        .iter()
        .any(|row| row.against_closed_form.is_some());
    let mut head = SOLVER_HEAD.to_vec();
    if closed {
        head.push("curvature against closed form, mean / max");
    }
    let on_cpu = scale.rows.iter().map(|row| (row, ""));
    let on_gpu = scale.on_gpu.iter().map(|on_gpu| (&on_gpu.row, ", GPU"));
    let rows = on_cpu.chain(on_gpu).map(|(row, by)| {
        let mut cells = solver_cells(row, by);
        if closed {
            cells.push(row.against_closed_form.map_or_else(String::new, |e| {
                format!("{} / {}", scientific(e.mean), scientific(e.max))
            }));
        }
        cells
    });
    let left_out = match scale.left_out.as_slice() {
        [] => String::new(),
        settings => format!(" Left out for their time: {}.", settings.join(", ")),
    };
    table(&head, rows) + &format!("Bold: on the Pareto front. \\*: what was asked for.{left_out}\n")
}

fn solver_cells(row: &Row, by: &str) -> Vec<String> {
    // A star inside the bold would not let it end.
    let mark = if row.asked_for { " \\*" } else { "" };
    let Row { setting, .. } = row;
    vec![
        format!("{:?}{by}", row.solver),
        if row.on_front {
            format!("**{setting}**{mark}")
        } else {
            format!("{setting}{mark}")
        },
        row.applications.to_string(),
        row.allowed.map_or_else(String::new, scientific),
        scientific(row.gradient.mean),
        scientific(row.gradient.p99),
        scientific(row.gradient.max),
        place(&row.gradient),
        scientific(row.overshoot),
        (row.gradient.non_finite + row.trace.non_finite).to_string(),
        scientific(row.trace.max),
        pair(row.diffusion),
        pair(row.whole),
        rounded(row.megapixels_per_second),
        row.utilisation
            .map_or_else(String::new, |u| share(u.of_bandwidth)),
        row.utilisation
            .map_or_else(String::new, |u| share(u.of_arithmetic)),
    ]
}

fn place(errors: &Errors) -> String {
    errors
        .worst
        .map_or_else(String::new, |[x, y]| format!("{x}, {y}"))
}

fn pair(times: Times) -> String {
    format!(
        "{} / {}",
        milliseconds(times.min),
        milliseconds(times.median)
    )
}

fn share(part: f64) -> String {
    format!("{:.0} %", 100.0 * part)
}

fn exact_scenes(report: &Report) -> String {
    let scenes = report.scenes.iter().enumerate();
    scenes
        .map(|(i, scene)| {
            solvers(
                scene,
                &format!("Exact scene: {}", scene.name),
                &plot_name(Some(i), report),
            ) + "\n"
        })
        .collect()
}

fn stages(report: &Report) -> String {
    let used = |u: Option<Utilisation>| match u {
        Some(u) => vec![
            rounded(u.bytes_per_second / 1e9),
            share(u.of_bandwidth),
            rounded(u.operations_per_second / 1e9),
            share(u.of_arithmetic),
        ],
        None => vec![String::new(); 4],
    };
    let rows = report.stages.iter().map(|row| {
        let mut cells = vec![
            row.stage.to_string(),
            pair(row.times),
            rounded(row.megapixels_per_second),
        ];
        cells.extend(used(row.utilisation));
        cells
    });
    let head = [
        "stage",
        "min / median",
        "Mpix/s",
        "GB/s",
        "of bandwidth",
        "Gop/s",
        "of arithmetic",
    ];
    format!(
        "## Stages of the whole descriptor\n\nBytes and operations are what an ideal pass would move and \
         compute: every plane in and out once, a logarithm or power as 20 operations. Above 100 % a frame stays in a cache.\n\n{}",
        table(&head, rows)
    )
}

fn runs(report: &Report) -> String {
    let rows = report.runs.iter().map(|row| {
        let same = if row.same_bits { "yes" } else { "**no**" };
        vec![
            row.dimension.into(),
            row.value.clone(),
            row.scale.clone(),
            pair(row.whole),
            format!("{:.2}", row.speedup),
            same.into(),
        ]
    });
    let head = [
        "varied",
        "value",
        "scale",
        "all stages min / median",
        "speed-up",
        "same bits",
    ];
    format!(
        "## Ways of running\n\nSpeed-ups are over the first row of each kind. Tiles are of this size at most, and evened \
         out so that every thread gets as many: a whole frame is cut into one for each.\n\n{}",
        table(&head, rows)
    )
}

fn precision(report: &Report) -> String {
    let rows = report.precision.iter().map(|row| {
        let errors = |e: &Errors| {
            format!(
                "{} / {} / {}",
                scientific(e.mean),
                scientific(e.p99),
                scientific(e.max)
            )
        };
        let stored = format!("{:?}", row.stored).to_lowercase();
        vec![
            row.frame.clone(),
            stored,
            row.scale.clone(),
            errors(&row.gradient),
            errors(&row.trace),
            place(&row.trace),
            row.edges_moved.to_string(),
        ]
    });
    let head = [
        "frame",
        "stored as",
        "scale",
        "gradient mean / 99 % / max",
        "curvature mean / 99 % / max",
        "worst at",
        "edge pixels moved",
    ];
    format!(
        "## Half and byte input against float\n\nNormals (and depth, for half) rounded, renormalised as on reading, and \
         analysed; compared with the reference of the input as it came. Pixels whose conductance changed by more than one \
         half are counted as moved edges and left out of the errors.\n\n{}",
        table(&head, rows)
    )
}

fn directions(report: &Report) -> String {
    let sweep = &report.directions;
    let rows = sweep.rows.iter().map(|row| {
        let step = match (row.step_px, row.steps_px) {
            (Some(step), _) => step.to_string(),
            (None, [least, most]) if least == most => format!("auto: {least}"),
            (None, [least, most]) => format!("auto: {least} to {most}"),
        };
        vec![
            format!("{:?}", row.stored).to_lowercase(),
            step,
            rounded(row.mean),
            rounded(row.p95),
            rounded(row.max),
            pair(row.stage),
            rounded(row.megapixels_per_second),
        ]
    });
    let head = [
        "normals",
        "step px",
        "mean degrees",
        "95 %",
        "max",
        "normal-rays min / median",
        "Mpix/s",
    ];
    format!(
        "## Directions of the surface's curvature\n\nOn {}, seen along parallel lines, {}x{}, from normals alone: the angle \
         between the directions found and those of its implicit form, in {} pixels whose n_z is above 0.35 and whose \
         curvatures differ by more than a tenth. Twice the step is four times the error of the surface's own change, and half \
         that of rounding; `auto` takes its wider step only where the narrow one tells nothing.\n\n\
         ![Error against step]({DIRECTION_PLOT})\n\n{}",
        sweep.about,
        sweep.width,
        sweep.height,
        sweep.pixels,
        table(&head, rows)
    )
}

fn rim(report: &Report) -> String {
    let bands = BANDS
        .windows(2)
        .map(|b| format!("n_z {} to {}", b[0], b[1]));
    let head: Vec<String> = ["foreshortening".to_string(), "min_nz".into()]
        .into_iter()
        .chain(bands)
        .collect();
    let head: Vec<_> = head.iter().map(String::as_str).collect();
    let on_ball = report.rim_of_ball.iter().map(|row| {
        let cells = row
            .bands
            .iter()
            .map(|e| format!("{} / {}", scientific(e.mean), scientific(e.max)));
        [row.foreshortening.to_string(), row.min_nz.to_string()]
            .into_iter()
            .chain(cells)
            .collect()
    });
    let on_frame = report.rim_of_frame.iter().map(|row| {
        vec![
            row.foreshortening.to_string(),
            row.min_nz.to_string(),
            rounded(row.steepest),
            row.applications.to_string(),
            scientific(row.gradient.mean),
            scientific(row.gradient.max),
            place(&row.gradient),
            scientific(row.overshoot),
        ]
    });
    let frame_head = [
        "foreshortening",
        "min_nz",
        "max |g|",
        "sweeps",
        "mean",
        "max",
        "worst at",
        "overshoot",
    ];
    let tried: Vec<_> = FORESHORTENINGS.iter().map(f32::to_string).collect();
    format!(
        "## Near silhouettes: foreshortening and min_nz\n\nOn a ball of 4000 px radius, undiffused, the error of the curvature \
         relative to its closed form, mean / max by n_z, for foreshortenings {}. Under the floor the slope grows \
         like n_xy alone; without foreshortening there is no floor.\n\n![Error by n_z]({RIM_PLOT})\n\n{}\n\
         On the frame, by expansion at the tolerance asked for, relative to the max |g| of each row:\n\n{}",
        tried.join(", "),
        table(&head, on_ball),
        table(&frame_head, on_frame),
    )
}
