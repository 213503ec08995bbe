//! Drawings on the page.

use super::super::drawing::{Angles, DrawingReport, field, strokes, tone};
use super::{pair, table};
use crate::params::{FieldParams, MAX_LEVELS, StrokeParams};
use crate::report::advice::rounded;

/// Name of the plot of directions.
pub const FIELD_PLOT: &str = "stroke-directions.svg";
/// Name of the plot of levels and sets.
pub const STROKES_PLOT: &str = "strokes.svg";

pub(super) fn section(drawing: &DrawingReport) -> String {
    let fields: String = drawing.fields.iter().map(field).collect();
    format!(
        "## Drawing\n\nOn cards: the surface of a frame in one even tone, a half, so that a drawing tells of strokes alone.\n\n\
         ### Directions of strokes\n\n\
         Averaged so many times, in a field one of whose pixels is so many pixels of the picture wide; {} and {} are what `hatch` \
         takes. Angles are in degrees, mean / 95 % / max: from the field of full resolution, averaged as often, and from \
         the exact directions where they are known. Turn is the mean from pixel to pixel: the calmer the less. Bold: on the \
         Pareto front of time and the 95 % from full resolution.\n\n![Error against time]({FIELD_PLOT})\n\n{fields}{}{}",
        FieldParams::default().passes,
        FieldParams::default().cell_px,
        levels(&drawing.strokes),
        tones(&drawing.tones),
    )
}

fn angles(angles: &Angles) -> String {
    [angles.mean, angles.p95, angles.max]
        .map(rounded)
        .join(" / ")
}

fn field(sweep: &field::Sweep) -> String {
    let rows = sweep.rows.iter().map(|row| {
        let cell = match row.on_front {
            true => format!("**{}**", row.cell_px),
            false => row.cell_px.to_string(),
        };
        vec![
            row.passes.to_string(),
            cell,
            angles(&row.from_full),
            row.from_exact.as_ref().map_or("unknown".into(), angles),
            rounded(row.turn),
            pair(row.stage),
        ]
    });
    let head = [
        "passes",
        "px of the picture",
        "from full resolution",
        "from exact",
        "turn",
        "direction-field min / median",
    ];
    format!(
        "On {}, {}x{}, {} pixels covered:\n\n{}",
        sweep.name,
        sweep.width,
        sweep.height,
        sweep.covered,
        table(&head, rows)
    )
}

fn levels(sweep: &strokes::Sweep) -> String {
    let rows = sweep.rows.iter().map(|row| {
        vec![
            row.sets.to_string(),
            row.levels.to_string(),
            angles(&row.from_field),
            format!("{:.0} %", 100.0 * row.unbroken),
            format!("{:.1} %", 100.0 * row.blotches),
            pair(row.stage),
        ]
    });
    let head = [
        "sets",
        "levels",
        "from the field",
        "unbroken",
        "blotches",
        "hatching min / median",
    ];
    let usual = StrokeParams::default();
    format!(
        "### Levels and sets of strokes\n\nOn {}, {}x{}, in {} pixels whose surroundings are covered. Angles in degrees, mean / 95 % / \
         max, are of strokes as drawn (the direction along which ink changes least) from the field that they follow, which {MAX_LEVELS} \
         levels are within half a degree of. Strokes are unbroken as far as ink is like that a sixth of a stroke farther along \
         the field: 100 % is a straight hatching. Blotches are the error of tone over some two strokes' distances, root mean square; \
         a straight hatching has {:.1} %. `hatch` takes {} levels and {} set.\n\n![Strokes by levels]({STROKES_PLOT})\n\n{}",
        sweep.name,
        sweep.width,
        sweep.height,
        sweep.pixels,
        100.0 * sweep.straight_blotches,
        usual.levels,
        usual.sets,
        table(&head, rows)
    )
}

fn tones(rows: &[tone::Row]) -> String {
    let worst = rows.iter().map(|row| row.worst).fold(0.0, f64::max);
    let rows = rows.iter().map(|row| {
        vec![
            format!("{:?}", row.style).to_lowercase(),
            row.tone.to_string(),
            format!("{:.4}", row.drawn),
            format!("{:+.2} %", 100.0 * (row.drawn - f64::from(row.tone))),
            format!("{:.2} %", 100.0 * row.worst),
            row.worst_angle.to_string(),
        ]
    });
    let head = [
        "style",
        "tone",
        "drawn",
        "error",
        "largest at one angle",
        "degrees",
    ];
    let angles: Vec<_> = tone::ANGLES.iter().map(f32::to_string).collect();
    format!(
        "### Tones\n\nA flat card of one tone, hatched at {} degrees: its mean, and the largest error at one of the angles. None \
         is off by more than {:.2} %.\n\n{}",
        angles.join(", "),
        100.0 * worst,
        table(&head, rows)
    )
}
