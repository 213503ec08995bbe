//! Borders between objects: lines along the cracks where another object begins, though depth and normals go on.

use crate::frame::{Frame, Plane};
use crate::line::contours::cracks::{Crack, DOWN, RIGHT};
use crate::line::contours::ground::Ground;
use crate::line::contours::log_depth;
use crate::line::contours::network::{Line, Spot};
use crate::line::contours::silhouettes::along;
use crate::params::ContourParams;
use glam::Vec2;

/// Their strength: that of a jump of depth half-way between the faintest and the plainest.
const STRENGTH: f32 = 0.5;

/// The lines between the objects of these `numbers` that keep away from other lines.
pub(crate) fn lines(
    numbers: &Plane,
    others: &Ground,
    frame: &Frame,
    params: &ContourParams,
) -> Vec<Line> {
    let mut cracks = cracks(numbers, others, frame);
    if cracks.is_empty() {
        return Vec::new();
    }
    cracks.sort_unstable_by_key(|c| (c.corner, c.step));
    along(&cracks, frame, params)
}

/// The cracks between objects beside which no other line runs.
fn cracks(numbers: &Plane, others: &Ground, frame: &Frame) -> Vec<Crack> {
    let (width, height) = (numbers.width(), numbers.height());
    let object = |x: usize, y: usize| {
        let number = numbers.at(x, y);
        (number > 0.0 && others.is_free(y * width + x)).then_some(number)
    };
    let crack = |[x, y]: [usize; 2], step: usize, at: Vec2| Crack {
        corner: (y * (width + 1) + x) as u32,
        step,
        spot: Spot {
            at,
            strength: STRENGTH,
            log_depth: log_depth(frame, at).unwrap_or(0.0),
            is_beside: false,
        },
    };
    let mut found = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let Some(number) = object(x, y) else {
            continue;
        };
        let differs = |x: usize, y: usize| {
            x < width && y < height && object(x, y).is_some_and(|other| other != number)
        };
        let corner = Vec2::new(x as f32, y as f32);
        if differs(x, y + 1) {
            found.push(crack([x, y + 1], RIGHT, corner + Vec2::new(0.5, 1.0)));
        }
        if differs(x + 1, y) {
            found.push(crack([x + 1, y], DOWN, corner + Vec2::new(1.0, 0.5)));
        }
    }
    found
}
