//! Short strokes along the directions of curvature, on a grid.

use crate::plan::outcome::Outcome;

/// Spacing of strokes in pixels, at step 1.
const GRID: usize = 14;

/// A stroke centred on `middle`, in pixels of the shown picture, y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arrow {
    pub(super) middle: [f32; 2],
    /// Half of the stroke, as a vector.
    pub(super) half: [f32; 2],
}

/// Strokes along the larger principal curvature, from a result with every `step`th pixel.
pub(super) fn arrows(outcome: &Outcome, step: usize) -> Vec<Arrow> {
    let Some(direction) = &outcome.shape.direction else {
        return Vec::new();
    };
    let grid = (GRID / step).max(2);
    let half = 0.42 * grid as f32;
    let (width, height) = (direction.x.width(), direction.x.height());
    let rows = (grid / 2..height).step_by(grid);
    let places = rows.flat_map(|y| (grid / 2..width).step_by(grid).map(move |x| (x, y)));
    let arrow = |(x, y)| {
        let [dx, dy] = [direction.x.at(x, y), direction.y.at(x, y)];
        (dx != 0.0 || dy != 0.0).then_some(Arrow {
            middle: [x as f32 + 0.5, y as f32 + 0.5],
            half: [half * dx, -half * dy],
        })
    };
    places.filter_map(arrow).collect()
}
