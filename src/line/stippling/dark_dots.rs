//! Coverage of the paper by dots, and radii that match it to the tone.

use super::Dot;
use crate::frame::Plane;
use crate::frame::memory::Memory;
use crate::line::ink_cells::InkCells;
use glam::Vec2;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Rows that one task draws.
const ROWS: usize = 16;

/// Side of a cell in which ink is matched to the tone, in radii.
const CELL: f32 = 12.0;

/// Number of corrections of radii, and the limits of the ink factor in each.
const MENDS: usize = 8;
const MEND: [f32; 2] = [0.7, 1.5];

/// Dots of a radius with their radii corrected so that they cover `ink` on local average.
pub(super) fn mended(mut dots: Vec<Dot>, radius: f32, ink: &Plane, memory: &Memory) -> Vec<Dot> {
    let side = (CELL * radius).max(4.0);
    let wanted = InkCells::of_plane(ink, side);
    for _ in (0..MENDS).take_while(|_| !memory.is_cancelled()) {
        let drawn = covered(&dots, [ink.width(), ink.height()]);
        let drawn = InkCells::of_plane(&drawn, side);
        for dot in &mut dots {
            dot.radius *= drawn.mend(&wanted, dot.at, MEND).sqrt();
        }
    }
    dots
}

/// The share of every pixel covered by dots: each inks the paper left white by the others.
pub(super) fn covered(dots: &[Dot], [width, height]: [usize; 2]) -> Plane {
    let mut bands: Vec<Vec<Dot>> = vec![Vec::new(); height.div_ceil(ROWS)];
    for &dot in dots {
        let reach = dot.radius + 1.0;
        let first = (dot.at.y - reach).max(0.0) as usize / ROWS;
        let last = (dot.at.y + reach).max(0.0) as usize / ROWS;
        for band in bands.iter_mut().take(last + 1).skip(first) {
            band.push(dot);
        }
    }
    let mut plane = Plane::filled(width, height, 0.0);
    let rows = plane.samples_mut().par_chunks_mut(ROWS * width.max(1));
    rows.zip(&bands)
        .enumerate()
        .for_each(|(band, (rows, dots))| {
            for dot in dots {
                dot.cover(rows, width, ROWS * band);
            }
        });
    plane
}

impl Dot {
    /// Covers rows from `top` on: in all, over the whole picture, as much as its area is.
    fn cover(&self, rows: &mut [f32], width: usize, top: usize) {
        let reach = self.radius + 0.5;
        let [from, to] = [-reach, reach].map(|d| self.at + d - 0.5);
        let pixels = |from: f32, to: f32| (from.ceil() as i32)..=(to.floor() as i32);
        let share = |x: i32, y: i32| {
            let middle = Vec2::new(x as f32, y as f32) + 0.5;
            (reach - self.at.distance(middle)).clamp(0.0, (2.0 * self.radius).min(1.0))
        };
        let (mut whole, mut partly) = (0.0, 0.0);
        for y in pixels(from.y, to.y) {
            for x in pixels(from.x, to.x) {
                match share(x, y) {
                    share if share >= 1.0 => whole += 1.0,
                    share => partly += share,
                }
            }
        }
        let rest = PI * self.radius * self.radius - whole;
        let factor = if partly > 0.0 {
            (rest / partly).max(0.0)
        } else {
            1.0
        };
        for y in pixels(from.y, to.y) {
            let row = y - top as i32;
            if row < 0 || row as usize >= rows.len() / width {
                continue;
            }
            let row = &mut rows[row as usize * width..][..width];
            for x in pixels(from.x, to.x).filter(|&x| x >= 0 && (x as usize) < width) {
                let share = match share(x, y) {
                    share if share >= 1.0 => 1.0,
                    share => (share * factor).min(1.0),
                };
                let ink = &mut row[x as usize];
                *ink += (1.0 - *ink) * share;
            }
        }
    }
}
