//! Accuracy of tones: a flat card drawn in one tone.

use super::Card;
use crate::Result;
use crate::params::{Fallback, FieldParams, LineParams, ShapeParams, StrokeParams, Style};
use crate::report::scenes::Scene;
use crate::report::timing::Effort;
use serde::Serialize;

/// Tones tried, from black to white.
pub(crate) const TONES: [f32; 9] = [0.0, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 1.0];

/// Stroke angles in degrees: on a level, and at several positions between levels.
pub(crate) const ANGLES: [f32; 5] = [0.0, 33.75, 39.0, 95.6, 177.0];

/// The card's size: several periods of the texture.
const CARD: [usize; 2] = [640, 480];

/// One tone in one style.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct ToneRow {
    pub style: Style,
    /// The target tone: 1 is paper.
    pub tone: f32,
    /// The mean tone drawn, over all angles.
    pub drawn: f64,
    /// The largest error of the mean at one angle.
    pub worst: f64,
    pub worst_angle: f32,
}

pub(super) fn rows() -> Result<Vec<ToneRow>> {
    let [width, height] = CARD;
    let once = Effort::new(1, 0);
    let mut bench = Card::new(
        &Scene::plane(width, height).frame,
        ShapeParams::default(),
        once,
    );
    let mut rows = Vec::new();
    for style in [Style::Pen, Style::Pencil] {
        for tone in TONES {
            bench.paint(tone);
            rows.push(row(&bench, style, tone)?);
        }
    }
    Ok(rows)
}

fn row(bench: &Card, style: Style, tone: f32) -> Result<ToneRow> {
    let mut row = ToneRow {
        style,
        tone,
        drawn: 0.0,
        worst: 0.0,
        worst_angle: ANGLES[0],
    };
    for angle in ANGLES {
        let ink = bench.ink(LineParams {
            field: FieldParams {
                fallback: Fallback::Angle(angle),
                ..FieldParams::default()
            },
            strokes: StrokeParams {
                style,
                ..StrokeParams::default()
            },
            ..LineParams::default()
        })?;
        let ink = ink.samples();
        let covered: f64 = ink.iter().map(|&v| f64::from(v)).sum();
        let drawn = 1.0 - covered / ink.len() as f64;
        row.drawn += drawn / ANGLES.len() as f64;
        let error = (drawn - f64::from(tone)).abs();
        if error > row.worst {
            (row.worst, row.worst_angle) = (error, angle);
        }
    }
    Ok(row)
}
