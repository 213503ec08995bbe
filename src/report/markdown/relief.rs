//! Height and occlusion.

use super::{or_blank, table};
use crate::report::numbers::{milliseconds, scientific};
use crate::report::relief::ReliefReport;

pub(super) fn section(report: &ReliefReport) -> String {
    let size = report.size;
    let heights = table!(&report.heights, row => {
        "surface": row.surface,
        "tolerance": or_blank((row.tolerance > 0.0).then(|| scientific(row.tolerance.into()))),
        "rounds": row.rounds,
        "time": milliseconds(row.seconds),
        "largest error": scientific(row.largest),
        "root mean square": scientific(row.mean),
    });
    let skies = table!(&report.skies, row => {
        "slices": row.slices,
        "radius px": row.radius_px,
        "time": milliseconds(row.seconds),
        "error": scientific(row.error),
    });
    format!(
        "## Height and occlusion\n\nThe height of waves, from exact slopes, {size}x{size}: errors are in \
         relation to its range.\n\n{heights}\n\
         The sky at the bottom of a groove with sides of 45 degrees, against its closed form.\n\n{skies}"
    )
}
