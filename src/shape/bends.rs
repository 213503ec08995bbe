//! Whether a surface bends: what curvature shows of it, as opposed to flat faces between sharp edges.

use crate::frame::Frame;
use glam::DVec3;

/// Distance at which normals are compared, as a share of the picture's size, the root of its area.
const APART: f32 = 1.0 / 140.0;

/// Turns over that distance, in radians, that are a bend: less is flat, more an edge.
const BEND: [f64; 2] = [0.25 / 140.0, 0.35];

/// By how much more a bend turns on one side than on the other at the most.
const EVEN: f64 = 3.0;

/// Pixels looked at along rows and columns.
const LOOKED_AT: usize = 128;

/// The share of pixels that bend on a surface that does. Measured: 0 on a street of flat walls, .03 on machined parts, .17
/// to .97 on figures, cloth and leaves.
const LEAST: f64 = 0.01;

/// Whether normals turn evenly over a hundredth of the surface.
pub(crate) fn bends(frame: &Frame) -> bool {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let window = frame.display_window;
    let size = ((window.width() * window.height()) as f32).sqrt();
    let apart = ((APART * size).round() as usize).max(1);
    let [across, down] = [width, height].map(|side| (side / LOOKED_AT).max(1));
    let normal = |x: usize, y: usize| {
        let is_known = x < width && y < height && frame.mask.at(x, y);
        is_known
            .then(|| frame.normal.at(x, y))
            .filter(|normal| normal.is_finite())
    };
    let (mut seen, mut bent) = (0, 0);
    for y in (apart..height).step_by(down) {
        for x in (apart..width).step_by(across) {
            let Some(here) = normal(x, y) else { continue };
            let sides = [
                [normal(x - apart, y), normal(x + apart, y)],
                [normal(x, y - apart), normal(x, y + apart)],
            ];
            seen += 1;
            bent += usize::from(sides.iter().any(|sides| is_bend(here, *sides)));
        }
    }
    bent as f64 > LEAST * seen as f64
}

/// Whether a normal lies in an even turn from the one before it to the one after.
fn is_bend(here: DVec3, sides: [Option<DVec3>; 2]) -> bool {
    let [Some(before), Some(after)] = sides else {
        return false;
    };
    let turns = [before, after].map(|there| here.angle_between(there));
    let [least, most] = [turns[0].min(turns[1]), turns[0].max(turns[1])];
    least > BEND[0] && most < BEND[1] && most < EVEN * least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes};

    fn of(normal: impl Fn(f64, f64) -> DVec3) -> bool {
        let normal = Vector3Planes::from_fn(200, 200, |x, y| normal(x as f64, y as f64));
        bends(&Frame::of_normals(normal, Mask::full(200, 200)))
    }

    #[test]
    fn balls_bend_and_boxes_do_not() {
        let ball = |x: f64, y: f64| {
            let (x, y) = ((x - 99.5) / 150.0, (99.5 - y) / 150.0);
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
        assert!(of(ball));
        assert!(!of(folds));
        assert!(!of(|_, _| DVec3::Z));
        assert!(!of(|_, _| DVec3::NAN));
    }
}
