//! The drawings of a sequence on the page.

use super::super::coherence::{Coherence, Row};
use super::table;

/// Name of the plot of differences by frame.
pub const COHERENCE_PLOT: &str = "coherence.svg";

/// The section; empty without a sequence.
pub(super) fn section(coherence: Option<&Coherence>) -> String {
    let Some(Coherence { rows, means }) = coherence else {
        return String::new();
    };
    let differences = |values: [f64; 3]| values.map(|value| format!("{value:.4}"));
    let row = |row: &Row| {
        let [still, carried, floor] = differences([row.still, row.carried, row.floor]);
        vec![
            row.frame.to_string(),
            format!("{:.1}", row.motion_px),
            format!("{:.0} %", 100.0 * row.seen_before),
            still,
            carried,
            floor,
            format!("{:.0} %", 100.0 * row.oldest_share),
        ]
    };
    let [still, carried, floor] = differences(*means);
    let blank = String::new;
    let all = vec![
        "mean".into(),
        blank(),
        blank(),
        still,
        carried,
        floor,
        blank(),
    ];
    let head = [
        "frame",
        "motion px",
        "seen before",
        "still in the picture",
        "carried",
        "floor",
        "drawn by the oldest map",
    ];
    format!(
        "## Drawings of the sequence\n\n\
         Each drawing, moved as the surface did, against the next: mean absolute difference of ink, 0 to 1, over the \
         pixels seen in both. Strokes lie still in the picture, or are carried along with the surface. Moving a \
         drawing blurs it; the floor is what that costs alone, on a card of one tone and one direction whose texture \
         moves as the frame does.\n\n{}\n![Differences from frame to frame]({COHERENCE_PLOT})\n",
        table(&head, rows.iter().map(row).chain([all])),
    )
}
