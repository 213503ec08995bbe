//! The page's section on drawings.

use super::{bold_if, percent, percent_to_a_tenth, table};
use crate::params::{FieldParams, MAX_LEVELS, StrokeParams};
use crate::report::drawing::{DrawingReport, field, strokes, tone};
use crate::report::numbers::rounded;
use crate::report::plots::{FIELDS, STROKES};

pub(super) fn section(drawing: &DrawingReport) -> String {
    let fields: String = drawing.fields.iter().map(field).collect();
    let usual = FieldParams::default();
    format!(
        "## Drawing\n\nOn cards: the surface of a frame in one even tone, a half, so that a drawing shows its strokes alone.\n\n\
         ### Directions of strokes\n\n\
         Averaged so many times, in a field one of whose pixels is so many pixels of the picture wide; {} and {} are what `hatch` \
         takes. Angles are in degrees, mean / 95 % / max: from the field of full resolution, averaged as often, and from \
         the exact directions where they are known. Turn is the mean from pixel to pixel: the calmer the less. Bold: on the \
         Pareto front of time and the 95 % from full resolution.\n\n![Error against time]({FIELDS})\n\n{fields}{}{}",
        usual.passes,
        usual.cell_px,
        levels(&drawing.strokes),
        tones(&drawing.tones),
    )
}

fn field(sweep: &field::Sweep) -> String {
    let table = table!(&sweep.rows, row => {
        "passes": row.passes,
        "px of the picture": bold_if(row.on_front, row.cell_px),
        "from full resolution": row.from_full,
        "from exact": row.from_exact.map_or("unknown".into(), |angles| angles.to_string()),
        "turn": rounded(row.turn),
        "direction-field min / median": row.stage,
    });
    format!(
        "On {}, {} pixels covered:\n\n{table}",
        sweep.on.markdown(),
        sweep.on.covered,
    )
}

fn levels(sweep: &strokes::Sweep) -> String {
    let table = table!(&sweep.rows, row => {
        "sets": row.sets,
        "levels": row.levels,
        "from the field": row.from_field,
        "unbroken": percent(row.unbroken),
        "blotches": percent_to_a_tenth(row.blotches),
        "hatching min / median": row.stage,
    });
    let usual = StrokeParams::default();
    format!(
        "### Levels and sets of strokes\n\nOn {}, in {} pixels whose surroundings are covered. Angles in degrees, mean / 95 % / \
         max, are of strokes as drawn (the direction along which ink changes least) from the field that they follow, which {MAX_LEVELS} \
         levels are within half a degree of. Strokes are unbroken as far as ink is like that a sixth of a stroke farther along \
         the field: 100 % is a straight hatching. Blotches are the error of tone over some two strokes' distances, root mean square; \
         a straight hatching has {}. `hatch` takes {} levels and {} set.\n\n![Strokes by levels]({STROKES})\n\n{table}",
        sweep.on.markdown(),
        sweep.pixels,
        percent_to_a_tenth(sweep.straight_blotches),
        usual.levels,
        usual.sets,
    )
}

fn tones(rows: &[tone::ToneRow]) -> String {
    let worst = rows.iter().map(|row| row.worst).fold(0.0, f64::max);
    let table = table!(rows, row => {
        "style": format!("{:?}", row.style).to_lowercase(),
        "tone": row.tone,
        "drawn": format!("{:.4}", row.drawn),
        "error": format!("{:+.2} %", 100.0 * (row.drawn - f64::from(row.tone))),
        "largest at one angle": format!("{:.2} %", 100.0 * row.worst),
        "degrees": row.worst_angle,
    });
    format!(
        "### Tones\n\nA flat card of one tone, hatched at {} degrees: its mean, and the largest error at one of the angles. None \
         is off by more than {:.2} %.\n\n{table}",
        tone::ANGLES.map(|angle| angle.to_string()).join(", "),
        100.0 * worst,
    )
}
