//! Whether a layer of occlusion has grain, which few samples leave.

use crate::frame::{Frame, Mask, Plane};
use crate::kernel::quantile::quantile;

/// Pixels looked at, about, and the fewest that tell.
const SAMPLES: usize = 8192;
const FEWEST: usize = 64;

/// Shares of light that are neither none nor all: there is grain, if anywhere.
const PARTLY: std::ops::Range<f32> = 0.05..0.95;

/// Deviation of a share of light from which on it is grain.
const GRAIN: f32 = 0.02;

/// Whether the occlusion of light in a frame has grain, by its finest detail in the middle of those pixels that it hides
/// partly.
pub(crate) fn is_grainy(frame: &Frame) -> bool {
    let Some(occlusion) = &frame.light.occlusion else {
        return false;
    };
    let partly = frame
        .mask
        .sample(SAMPLES)
        .filter(|&(x, y)| PARTLY.contains(&occlusion.at(x, y)));
    let mut finest: Vec<f32> = partly
        .filter_map(|at| finest(occlusion, &frame.mask, at))
        .collect();
    let is_enough = finest.len() >= FEWEST;
    // A sample less the mean of four: 1 + 1/4 times the variance, and half of a normal distribution is within .6745 of its
    // deviation.
    let median = quantile(&mut finest, 0.5, f32::total_cmp).filter(|_| is_enough);
    median.is_some_and(|median| median > GRAIN * 0.6745 * 1.25_f32.sqrt())
}

/// The distance of a sample from the mean of the four beside it, if all are there.
fn finest(plane: &Plane, mask: &Mask, (x, y): (usize, usize)) -> Option<f32> {
    let beside = [
        (x.checked_sub(1)?, y),
        (x + 1, y),
        (x, y.checked_sub(1)?),
        (x, y + 1),
    ];
    let are_there = beside.iter().all(|&(x, y)| mask.has(x, y));
    let sum: f32 = beside
        .iter()
        .filter(|_| are_there)
        .map(|&(x, y)| plane.at(x, y))
        .sum();
    are_there.then(|| (plane.at(x, y) - 0.25 * sum).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Vector3Planes, Window};
    use glam::DVec3;

    /// A wall whose left half hides 6/10 of the light and whose right half 2/10, and this much grain.
    fn frame(grain: f32) -> Frame {
        let (width, height) = (96, 64);
        let mut state = 1_u32;
        let occlusion = Plane::from_fn(width, height, |x, _| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Evenly between -1 and 1: a deviation of .577.
            let stray = (state >> 8) as f32 / (1 << 23) as f32 - 1.0;
            let own = if x < width / 2 { 0.4 } else { 0.8 };
            own + grain * stray / 0.577
        });
        let normal = Vector3Planes::from_fn(width, height, |_, _| DVec3::Z);
        let mut frame = Frame::of_normals(normal, Mask::full(width, height));
        frame.data_window = Window::from_size(width, height);
        frame.light.occlusion = Some(occlusion);
        frame
    }

    #[test]
    fn grain_is_told_from_shade() {
        assert!(!is_grainy(&frame(0.0)) && !is_grainy(&frame(0.01)));
        assert!(is_grainy(&frame(0.04)));
        let mut none = frame(0.04);
        none.mask = Mask::full(96, 64);
        none.light.occlusion = None;
        assert!(!is_grainy(&none));
    }
}
