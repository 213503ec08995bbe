//! The page's section on drawings of a sequence.

use super::{percent, table};
use crate::report::coherence::{Coherence, CoherenceRow};
use crate::report::plots::COHERENCE;

/// The section; empty without a sequence.
pub(super) fn section(coherence: Option<&Coherence>) -> String {
    let Some(Coherence { rows, means }) = coherence else {
        return String::new();
    };
    let ink = |value: f64| format!("{value:.4}");
    let of_row = |row: &CoherenceRow| {
        let differences = [row.still, row.carried, row.floor, row.lines];
        let shares = [percent(row.seen_before), percent(row.oldest_share)];
        (
            row.frame.to_string(),
            format!("{:.1}", row.motion_px),
            shares,
            differences,
        )
    };
    let blank = String::new;
    let of_all = ("mean".to_string(), blank(), [blank(), blank()], *means);
    let table = table!(rows.iter().map(of_row).chain([of_all]), (frame, motion, shares, differences) => {
        "frame": frame,
        "motion px": motion,
        "seen before": shares[0],
        "still in the picture": ink(differences[0]),
        "carried": ink(differences[1]),
        "floor": ink(differences[2]),
        "lines": ink(differences[3]),
        "drawn by the oldest map": shares[1],
    });
    format!(
        "## Drawings of the sequence\n\n\
         Each drawing, moved as the surface did, against the next: mean absolute difference of ink, 0 to 1, over the \
         pixels seen in both. Strokes lie still in the picture, or are carried along with the surface. Moving a \
         drawing blurs it; the floor is what that costs alone, on a card of one tone and one direction whose texture \
         moves as the frame does. Lines along edges and inside surfaces are found anew in every frame; theirs is the \
         difference of drawings of lines alone.\n\n{table}\n![Differences from frame to frame]({COHERENCE})\n",
    )
}
