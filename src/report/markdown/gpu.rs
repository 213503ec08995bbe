//! The section on the device beside the CPU.

use super::{pair, place, table};
use crate::report::Report;
use crate::report::advice::scientific;
use crate::report::compare::Errors;
use crate::report::gpu::{GpuReport, GpuRow, ProductRow};
use crate::report::pictures::{COMPARED, PictureRow, Reference};

/// Name of the plot of new light and drawings.
pub const PICTURES_PLOT: &str = "pictures.svg";

/// What a device took, and how far it is from the CPU; nothing in a build that knows of none.
pub(super) fn section(report: &Report) -> String {
    match &report.gpu {
        None => String::new(),
        Some(GpuReport::NotMeasured(why)) => {
            format!("## On a GPU\n\nNone was measured: {why}.")
        }
        Some(GpuReport::Measured {
            device,
            is_software,
            products,
            pictures: rows,
        }) => {
            let software = if *is_software { ", in software" } else { "" };
            format!(
                "## On a GPU\n\n{device}{software}. Its errors stand beside those of the CPU, in the tables of the frame and of the \
                 scenes; in software, what was not asked for and would take long is left out. Copies to it and from it and its kernels, min / median, for a picture of the curvature; `all` has the time of \
                 telling it what to run too.{}\n\n{}{}How far what it makes is from what the CPU makes, relative to the largest value of \
                 each plane, of directions and ink on average:\n\n{}",
                clock(report),
                times(report),
                pictures(rows),
                differences(products),
            )
        }
    }
}

/// Rows of the device, with the names of their frame and their scale.
fn rows(report: &Report) -> impl Iterator<Item = (&str, &str, &GpuRow)> {
    let sweeps = std::iter::once(&report.frame).chain(&report.scenes);
    let scales = sweeps.flat_map(|sweep| sweep.scales.iter().map(|s| (sweep.name.as_str(), s)));
    scales.flat_map(|(name, scale)| {
        let rows = scale.on_gpu.iter();
        rows.map(move |row| (name, scale.scale.as_str(), row))
    })
}

fn clock(report: &Report) -> &'static str {
    match rows(report).all(|(.., row)| row.has_clock()) {
        true => " Stages are told by the device's own clock.",
        false => {
            " The device has no clock of its own: kernels are timed all together, and stand in for the diffusion."
        }
    }
}

fn times(report: &Report) -> String {
    let rows = rows(report).map(|(name, scale, row)| {
        let stages = row.stages.iter();
        let stages: Vec<_> = stages
            .map(|stage| format!("{} {}", stage.stage, pair(stage.times)))
            .collect();
        vec![
            name.into(),
            scale.into(),
            format!("{:?}, {}", row.row.solver, row.row.setting),
            pair(row.upload),
            pair(row.compute),
            pair(row.read_back),
            pair(row.row.whole),
            stages.join("; "),
        ]
    });
    let head = [
        "frame",
        "scale",
        "setting",
        "upload",
        "compute",
        "read-back",
        "all",
        "compute, by stage",
    ];
    table(&head, rows)
}

/// What new light and drawings take, and how far off they are.
fn pictures(rows: &[PictureRow]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let rows = rows.iter().flat_map(|row| {
        let timed = &row.on_gpu.timed;
        let copies = [timed.upload, timed.compute, timed.read_back].map(pair);
        let none = [const { String::new() }; 3];
        let cpu = picture_cells(row, "CPU", row.on_cpu.errors.as_ref(), none);
        let gpu = picture_cells(row, "GPU", Some(&row.on_gpu.errors), copies);
        [(cpu, row.on_cpu.whole), (gpu, timed.whole)].map(|(mut cells, whole)| {
            cells.push(pair(whole));
            cells
        })
    });
    let head = [
        "picture",
        "by",
        "error from",
        "mean / 99 % / max",
        "worst at",
        "not finite",
        "upload",
        "compute",
        "read-back",
        "all",
    ];
    format!(
        "New light and drawings of the frame by both. Errors of new light, on a white and glossy surface, are those of the worst channel at up \
         to {COMPARED} pixels, relative to the luminance that 98 in 100 of them stay below; the reference is double precision from the \
         Hessian and the gain that the CPU found. Drawings have no other reference than what the CPU draws: their errors are of ink, \
         0 to 1.\n\n![Error against time]({PICTURES_PLOT})\n\n{}",
        table(&head, rows)
    )
}

fn picture_cells(
    row: &PictureRow,
    by: &str,
    errors: Option<&Errors>,
    times: [String; 3],
) -> Vec<String> {
    let reference = match row.reference {
        Reference::DoublePrecision => "double precision",
        Reference::Cpu => "the CPU",
    };
    let errors = match errors {
        Some(e) => [
            reference.into(),
            [e.mean, e.p99, e.max].map(scientific).join(" / "),
            place(e),
            e.non_finite.to_string(),
        ],
        None => [const { String::new() }; 4],
    };
    let names = [row.picture.clone(), by.into()];
    names.into_iter().chain(errors).chain(times).collect()
}

fn differences(products: &[ProductRow]) -> String {
    let rows = products.iter().map(|row| {
        vec![
            row.product.row().name.into(),
            scientific(row.difference),
            row.frame.clone(),
            scientific(row.tolerance),
            if row.is_within { "yes" } else { "**no**" }.into(),
        ]
    });
    let head = ["product", "largest difference", "in", "allowed", "within"];
    table(&head, rows)
}
