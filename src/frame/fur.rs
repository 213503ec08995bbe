//! Fur and hair: strands so thin that a pixel's normal tells nothing of the next one's.

use super::clutter::share_around;
use super::enlarged::around_pixel;
use super::repair::squares::mean_over_squares;
use super::{Frame, Plane};

/// Most normals of fur are this far apart, in radians, from those in the next column, and in the next row.
const TURN: f32 = 0.1;
const MOST: f32 = 0.6;

/// Squares of differences over two pixels are at most so many times those over one, of normals and of depth: they are twice
/// them at edges, and four times them on forms. Of fur they are as many.
const NORMALS_APART: f32 = 1.7;
const DEPTH_APART: f32 = 1.6;

/// From this share of such places on, within twice their reach, the rough pixels between them and beside them are fur too.
const BESIDE: f32 = 0.1;

impl Frame {
    /// Where there is fur, judged within `reach` pixels.
    pub(super) fn fur(&self, depth: &Plane, reach: usize) -> Plane<bool> {
        let size = [depth.width(), depth.height()];
        // Squares of the differences of normals, and of depths, to a pixel; none beyond the picture.
        let apart = |[x, y]: [usize; 2], [i, k]: [usize; 2]| {
            let is_covered = i < size[0] && k < size[1] && self.mask.at(x, y) && self.mask.at(i, k);
            if !is_covered {
                return [0.0; 2];
            }
            let turn = self.normal.at(x, y) - self.normal.at(i, k);
            let behind = depth.at(x, y) - depth.at(i, k);
            [turn.length_squared() as f32, behind * behind]
        };
        let turns = |at, other| apart(at, other)[0] > TURN * TURN;
        let share = [[1, 0], [0, 1]].map(|[right, below]| {
            let turned = Plane::of_pixels(size[0], size[1], |x, y| {
                turns([x, y], [x + right, y + below])
            });
            share_around(&turned, reach)
        });
        let is_even = |of: usize, most: f32| {
            let [near, far] = [1, 2].map(|by| {
                let all = Plane::of_pixels(size[0], size[1], |x, y| {
                    apart([x, y], [x + by, y])[of] + apart([x, y], [x, y + by])[of]
                });
                mean_over_squares(&all, reach)
            });
            move |x, y| far.at(x, y) < most * near.at(x, y)
        };
        let (bends, slopes) = (is_even(0, NORMALS_APART), is_even(1, DEPTH_APART));
        let strewn = Plane::of_pixels(size[0], size[1], |x, y| {
            let is_rough = share.iter().all(|share| share.at(x, y) > MOST);
            is_rough && bends(x, y) && slopes(x, y)
        });
        let beside = share_around(&strewn, 2 * reach);
        let rough = Plane::of_pixels(size[0], size[1], |x, y| {
            let mut others = around_pixel([x, y], size, 1);
            beside.at(x, y) > BESIDE && others.any(|other| turns([x, y], other))
        });
        share_around(&rough, 1).map(|share| share > 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes};
    use glam::DVec3;

    const SIZE: [usize; 2] = [160, 120];

    /// Even noise about 0, up to 1 either way, another for every `seed`.
    fn noise(x: usize, y: usize, seed: u32) -> f64 {
        let mixed =
            (x as u32).wrapping_mul(73_856_093) ^ (y as u32).wrapping_mul(19_349_663) ^ seed;
        let mixed = (mixed ^ mixed >> 13).wrapping_mul(1_274_126_177);
        f64::from((mixed ^ mixed >> 16) & 0xffff) / 32_767.5 - 1.0
    }

    /// Pixels of fur of a ball at depth 3 whose normals and depth have so much noise right of its middle.
    fn fur_of_ball(turned: f64, strewn: f64) -> Plane<bool> {
        let place = |x: usize, y: usize| [x as f64 - 80.0, 60.0 - y as f64].map(|at| at / 50.0);
        let height = |x, y| {
            let [across, up] = place(x, y);
            (1.0 - across * across - up * up).max(0.0).sqrt()
        };
        let is_rough = |x: usize| x >= 80;
        let noisy = |x, y, seed, most: f64| {
            if is_rough(x) {
                most * noise(x, y, seed)
            } else {
                0.0
            }
        };
        let normal = |x, y| {
            let [across, up] = place(x, y);
            let stray = [1, 2, 3].map(|seed| noisy(x, y, seed, turned));
            (DVec3::new(across, up, height(x, y)) + DVec3::from(stray)).normalize()
        };
        let depth = Plane::from_fn(SIZE[0], SIZE[1], |x, y| {
            (3.0 - height(x, y) + noisy(x, y, 4, strewn)) as f32
        });
        let mask = Mask::new(Plane::from_fn(SIZE[0], SIZE[1], |x, y| height(x, y) > 0.0));
        let normals = Vector3Planes::from_fn(SIZE[0], SIZE[1], normal);
        Frame::of_normals(normals, mask).fur(&depth, 4)
    }

    fn count(fur: &Plane<bool>, columns: std::ops::Range<usize>) -> usize {
        let rows = (0..fur.height()).map(|y| &fur.row(y)[columns.clone()]);
        rows.flatten().filter(|&&is_fur| is_fur).count()
    }

    #[test]
    fn strands_are_fur_and_forms_are_not() {
        let fur = fur_of_ball(0.5, 0.1);
        // Half of the disc of radius 50, but for its border.
        let half = 0.5 * std::f64::consts::PI * 50.0 * 50.0;
        assert!(count(&fur, 80..160) as f64 > 0.9 * half);
        assert_eq!(count(&fur, 0..79), 0);
        // Noise in normals alone is no fur, nor is one in depth, nor a ball; at its rim it turns by more than a tenth.
        for (turned, strewn) in [(0.5, 0.0), (0.0, 0.1), (0.0, 0.0)] {
            assert_eq!(count(&fur_of_ball(turned, strewn), 0..160), 0);
        }
    }
}
