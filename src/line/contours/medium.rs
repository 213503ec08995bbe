//! Lines in the medium of a drawing.

use crate::frame::{Frame, Plane, Window};
use crate::line::paper::{grain, graphite};
use crate::params::{StrokeParams, Style};

/// The coverage of lines drawn in the medium of strokes.
pub(crate) fn in_medium(covered: Plane, frame: &Frame, strokes: &StrokeParams) -> Plane {
    match strokes.style {
        Style::Pencil => in_graphite(covered, frame.data_window, strokes.seed),
        _ => covered,
    }
}

/// Lines as a pencil draws them on grained paper.
fn in_graphite(mut covered: Plane, window: Window, seed: u64) -> Plane {
    covered.each_row(|y, row| {
        let y = window.y0.wrapping_add(y as i32);
        for (x, coverage) in row.iter_mut().enumerate().filter(|(_, c)| **c > 0.0) {
            let x = window.x0.wrapping_add(x as i32);
            *coverage = graphite(*coverage, grain(x, y, seed));
        }
    });
    covered
}
