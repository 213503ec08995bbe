//! Whether a surface bends: what curvature shows of it, as opposed to flat faces between sharp edges.

use crate::frame::Frame;
use glam::DVec3;

/// Distance at which normals are compared, as a share of the picture's size, the root of its area.
const APART: f32 = 1.0 / 140.0;

/// Turns over that distance, in radians, that are a bend: less is flat, more an edge.
const BEND: [f64; 2] = [0.25 / 140.0, 0.35];

/// By how much more a bend turns on one side than on the other at the most, and the most of its turn that lies in half of
/// the distance: an edge that is spread over some pixels has all of it there.
const EVEN: f64 = 3.0;
const HALF_WAY: f64 = 0.75;

/// Pixels looked at along rows and columns.
const LOOKED_AT: usize = 128;

/// The share of pixels that bend on a surface that does. Measured: 0 on a street of flat walls, .02 on machined parts, .11
/// to .97 on figures, cloth and leaves.
const LEAST: f64 = 0.01;

/// Whether normals turn evenly over a hundredth of the surface.
pub(crate) fn bends(frame: &Frame) -> bool {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let size = frame.display_window.size_px();
    let apart = ((APART * size).round() as usize).max(1);
    let [across, down] = [width, height].map(|side| (side / LOOKED_AT).max(1));
    let normal = |x: usize, y: usize| {
        let is_known = frame.mask.has(x, y);
        is_known
            .then(|| frame.normal.at(x, y))
            .filter(|normal| normal.is_finite())
    };
    let (mut seen, mut bent) = (0, 0);
    for y in (apart..height).step_by(down) {
        for x in (apart..width).step_by(across) {
            let Some(here) = normal(x, y) else { continue };
            let both = |apart: usize| {
                [
                    [normal(x - apart, y), normal(x + apart, y)],
                    [normal(x, y - apart), normal(x, y + apart)],
                ]
            };
            let sides = both(apart).into_iter().zip(both(apart / 2));
            seen += 1;
            bent += usize::from(
                sides
                    .into_iter()
                    .any(|(sides, half)| is_bend(here, sides, half)),
            );
        }
    }
    bent as f64 > LEAST * seen as f64
}

/// Whether a normal lies in an even turn between those on both sides, and those half-way there.
fn is_bend(here: DVec3, sides: [Option<DVec3>; 2], half: [Option<DVec3>; 2]) -> bool {
    let turns = |sides: [Option<DVec3>; 2]| {
        let [before, after] = [sides[0]?, sides[1]?].map(|there| here.angle_between(there));
        Some([before, after])
    };
    let (Some(turns), Some(half)) = (turns(sides), turns(half)) else {
        return false;
    };
    let [least, most] = [turns[0].min(turns[1]), turns[0].max(turns[1])];
    let is_even = least > BEND[0] && most < BEND[1] && most < EVEN * least;
    is_even && (0..2).all(|side| half[side] < HALF_WAY * turns[side])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes};

    fn of(normal: impl Fn(f64, f64) -> DVec3) -> bool {
        let normal = Vector3Planes::from_fn(700, 700, |x, y| normal(x as f64, y as f64));
        bends(&Frame::of_normals(normal, Mask::full(700, 700)))
    }

    #[test]
    fn balls_bend_and_boxes_do_not() {
        let ball = |x: f64, y: f64| {
            let (x, y) = ((x - 349.5) / 525.0, (349.5 - y) / 525.0);
            DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())
        };
        // Faces of 20 pixels, turned by 30 degrees in turn, the sine of which is .5.
        let folds = |x: f64, _: f64| {
            DVec3::new(
                if (x as usize / 20).is_multiple_of(2) {
                    0.5
                } else {
                    -0.5
                },
                0.0,
                0.75_f64.sqrt(),
            )
        };
        // From face to face 20 degrees, over two pixels as in an enlarged picture; normals are compared 5 pixels apart.
        let spread = |x: f64, _: f64| {
            let across = ((x % 40.0 - 20.0).abs() - 10.0).clamp(-1.0, 1.0);
            let turned = 10.0_f64.to_radians() * across;
            DVec3::new(turned.sin(), 0.0, turned.cos())
        };
        assert!(of(ball));
        assert!(!of(folds) && !of(spread));
        assert!(!of(|_, _| DVec3::Z));
        assert!(!of(|_, _| DVec3::NAN));
    }
}
