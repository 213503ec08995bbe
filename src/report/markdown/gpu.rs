//! The section on the device beside the CPU.

use super::{pair, table};
use crate::backend::Product;
use crate::report::Report;
use crate::report::advice::scientific;
use crate::report::gpu::{GpuReport, GpuRow, ProductRow};

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
        }) => {
            let software = if *is_software { ", in software" } else { "" };
            format!(
                "## On a GPU\n\n{device}{software}. Its errors stand beside those of the CPU, in the tables of the frame and of the \
                 scenes; in software, what was not asked for and would take long is left out. Copies to it and from it and its kernels, min / median, for a picture of the curvature; `all` has the time of \
                 telling it what to run too.{}\n\n{}How far what it makes is from what the CPU makes, relative to the largest value of \
                 each plane, of directions and ink on average:\n\n{}",
                clock(report),
                times(report),
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

fn differences(products: &[ProductRow]) -> String {
    let rows = products.iter().map(|row| {
        vec![
            in_words(row.product),
            scientific(row.difference),
            row.frame.clone(),
            scientific(row.tolerance),
            if row.is_within { "yes" } else { "**no**" }.into(),
        ]
    });
    let head = ["product", "largest difference", "in", "allowed", "within"];
    table(&head, rows)
}

/// A name of several words put together, as words.
fn in_words(product: Product) -> String {
    let name = format!("{product:?}");
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(letter.to_lowercase());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_named_in_words() {
        assert_eq!(in_words(Product::MappedCurvature), "mapped curvature");
        assert_eq!(in_words(Product::Weights), "weights");
    }
}
