//! The page's section on the device compared with the CPU.

use super::{or_blank, place, table, yes_or};
use crate::report::Report;
use crate::report::beside::GpuReport;
use crate::report::gpu::ProductRow;
use crate::report::numbers::scientific;
use crate::report::pictures::{COMPARED, PictureRow, Reference};
use crate::report::plots::PICTURES;
use crate::report::sweeps::solver::GpuRow;
use crate::untrusted::Untrusted;

/// The section; empty in a build without device support.
pub(super) fn section(report: &Report) -> String {
    let (device, is_software, products, rows) = match &report.gpu {
        None => return String::new(),
        Some(GpuReport::NotMeasured(why)) => {
            return format!("## On a GPU\n\nNone was measured: {why}.");
        }
        Some(GpuReport::Measured {
            device,
            is_software,
            products,
            pictures,
        }) => (device, is_software, products, pictures),
    };
    let software = if *is_software { ", in software" } else { "" };
    format!(
        "## On a GPU\n\n{}{software}. Its errors stand beside those of the CPU, in the tables of the frame and of the \
         scenes; in software, what was not asked for and would take long is left out. Copies to it and from it and its kernels, min / median, for a picture of the curvature; `all` has the time of \
         recording its commands too.{}\n\n{}{}How far what it makes is from what the CPU makes, relative to the largest value of \
         each plane, of directions and ink on average:\n\n{}",
        Untrusted(device).markdown(),
        clock(report),
        times(report),
        pictures(rows),
        differences(products),
    )
}

/// Rows of the device, with the names of their frame and scale.
fn rows(report: &Report) -> impl Iterator<Item = (&str, &str, &GpuRow)> {
    let sweeps = std::iter::once(&report.frame).chain(&report.scenes);
    let scales = sweeps.flat_map(|sweep| sweep.scales.iter().map(|s| (sweep.on.name.as_str(), s)));
    scales.flat_map(|(name, scale)| {
        let rows = scale.on_gpu.iter();
        rows.map(move |row| (name, scale.scale.as_str(), row))
    })
}

fn clock(report: &Report) -> &'static str {
    match rows(report).all(|(.., row)| row.parts.has_clock()) {
        true => " Stages are timed by the device's own clock.",
        false => {
            " The device has no clock of its own: kernels are timed all together, and stand in for the diffusion."
        }
    }
}

fn times(report: &Report) -> String {
    let stages = |row: &GpuRow| {
        let stages = row
            .parts
            .stages
            .iter()
            .map(|stage| format!("{} {}", stage.stage, stage.times));
        stages.collect::<Vec<_>>().join("; ")
    };
    let table = table!(rows(report), (name, scale, row) => {
        "frame": Untrusted(name).markdown(),
        "scale": scale,
        "setting": format!("{:?}, {}", row.row.solver, row.row.setting),
        "upload": row.parts.upload,
        "compute": row.parts.compute,
        "read-back": row.parts.read_back,
        "all": row.row.whole,
        "compute, by stage": stages(row),
    });
    table.to_string()
}

/// Times and errors of relit pictures and drawings.
fn pictures(rows: &[PictureRow]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let rows = rows.iter().flat_map(|row| {
        let timed = &row.on_gpu.timed;
        let gpu = (
            row,
            "GPU",
            Some(&row.on_gpu.errors),
            Some(&timed.parts),
            timed.whole,
        );
        [
            (
                row,
                "CPU",
                row.on_cpu.errors.as_ref(),
                None,
                row.on_cpu.whole,
            ),
            gpu,
        ]
    });
    let reference = |row: &PictureRow| match row.reference {
        Reference::DoublePrecision => "double precision",
        Reference::Cpu => "the CPU",
    };
    let table = table!(rows, (row, by, errors, on_gpu, whole) => {
        "picture": row.picture,
        "by": by,
        "error from": or_blank(errors.map(|_| reference(row))),
        "mean / 99 % / max": or_blank(errors),
        "worst at": or_blank(errors.map(place)),
        "not finite": or_blank(errors.map(|e| e.non_finite)),
        "upload": or_blank(on_gpu.map(|parts| parts.upload)),
        "compute": or_blank(on_gpu.map(|parts| parts.compute)),
        "read-back": or_blank(on_gpu.map(|parts| parts.read_back)),
        "all": whole,
    });
    format!(
        "New light and drawings of the frame by both. Errors of new light, on a white and glossy surface, are those of the worst channel at up \
         to {COMPARED} pixels, relative to the luminance that 98 in 100 of them stay below; the reference is double precision from the \
         Hessian and the gain that the CPU found. Drawings have no other reference than what the CPU draws: their errors are of ink, \
         0 to 1.\n\n![Error against time]({PICTURES})\n\n{table}"
    )
}

fn differences(products: &[ProductRow]) -> String {
    let table = table!(products, row => {
        "product": row.product.row().name,
        "largest difference": scientific(row.difference),
        "in": Untrusted(&row.frame).markdown(),
        "allowed": scientific(row.tolerance),
        "within": yes_or("**no**", row.is_within),
    });
    table.to_string()
}
