//! Disocclusion: positions for surface that was not visible before.

use crate::frame::{Plane, Vector2Planes};
use crate::line::texture_coordinates::origin::Origin;
use crate::line::texture_coordinates::places::{MovingSurface, jacobian_at, place_at};
use crate::line::texture_coordinates::{continued, turn};
use std::collections::VecDeque;

/// Pixels that were not visible before, if some adjacent ones of the same surface were.
pub(crate) struct Hidden<'a> {
    known: Plane<bool>,
    surface: MovingSurface<'a>,
    /// Ordered by distance from the known pixels.
    pixels: Vec<HiddenPixel>,
}

struct HiddenPixel {
    at: usize,
    /// The nearest pixel that was visible before.
    root: usize,
    /// Pixels beside it of the same surface.
    beside: Vec<usize>,
}

/// Rounds of averaging positions of hidden pixels with their neighbours, which removes the seams between those extended
/// from different pixels.
const RELAXATIONS: usize = 6;

/// Pixels beside the hidden that are taken for hidden too: next to an edge motion is least certain.
const UNSURE: usize = 2;

/// Pixels to each side of a root whose turn is averaged.
const AROUND_ROOT: usize = 2;

impl<'a> Hidden<'a> {
    pub(crate) fn find(origins: &Plane<Origin>, surface: MovingSurface<'a>) -> Self {
        let mut known = origins.map(|origin| origin.is_known());
        let samples = known.samples().iter().zip(surface.covered.samples());
        let hidden = samples.enumerate();
        let hidden = hidden.filter(|(_, (known, covered))| **covered && !**known);
        let mut hidden: Vec<usize> = hidden.map(|(at, _)| at).collect();
        let mut edge = 0;
        for _ in 0..UNSURE {
            let from = std::mem::replace(&mut edge, hidden.len());
            for i in from..edge {
                for next in neighbours(hidden[i], &surface) {
                    if std::mem::replace(&mut known.samples_mut()[next], false) {
                        hidden.push(next);
                    }
                }
            }
        }
        let mut taken = known.clone();
        let mut front = VecDeque::new();
        for at in hidden {
            let mut around = neighbours(at, &surface).into_iter();
            if let Some(root) = around.find(|&next| known.samples()[next]) {
                taken.samples_mut()[at] = true;
                front.push_back((at, root));
            }
        }
        let mut pixels = Vec::new();
        while let Some((at, root)) = front.pop_front() {
            let beside = neighbours(at, &surface);
            for &next in &beside {
                if !taken.samples()[next] {
                    taken.samples_mut()[next] = true;
                    front.push_back((next, root));
                }
            }
            pixels.push(HiddenPixel { at, root, beside });
        }
        Self {
            known,
            surface,
            pixels,
        }
    }

    /// Extends the places of a map into hidden pixels.
    pub(crate) fn fill(&self, map: &mut Vector2Planes) {
        let width = self.known.width();
        let column_row = |at: usize| [(at % width) as f32, (at / width) as f32];
        let way = |from: usize, to: usize| {
            let ([x, y], [u, v]) = (column_row(from), column_row(to));
            [u - x, v - y]
        };
        let known = MovingSurface {
            covered: &self.known,
            ..self.surface
        };
        let turns: Vec<[f32; 2]> = self
            .pixels
            .iter()
            .map(|pixel| turn_around(map, &known, pixel.root))
            .collect();
        let set = |map: &mut Vector2Planes, at: usize, [x, y]: [f32; 2]| {
            map.x.samples_mut()[at] = x;
            map.y.samples_mut()[at] = y;
        };
        for (pixel, &turn) in self.pixels.iter().zip(&turns) {
            let root = place_at(map, pixel.root);
            let place = continued(root, turn, way(pixel.root, pixel.at));
            set(map, pixel.at, place);
        }
        let mut relax = |pixel: &HiddenPixel, turn: [f32; 2]| {
            let mut sum = [0.0; 2];
            for &next in &pixel.beside {
                let [x, y] = continued(place_at(map, next), turn, way(next, pixel.at));
                sum = [sum[0] + x, sum[1] + y];
            }
            set(
                map,
                pixel.at,
                sum.map(|sum| sum / pixel.beside.len() as f32),
            );
        };
        // Outward from the known pixels, and back.
        for _ in 0..RELAXATIONS {
            let both = || self.pixels.iter().zip(&turns);
            both().for_each(|(pixel, &turn)| relax(pixel, turn));
            both().rev().for_each(|(pixel, &turn)| relax(pixel, turn));
        }
    }
}

/// The turn of a map around a pixel, of as much as is known there.
fn turn_around(map: &Vector2Planes, known: &MovingSurface, at: usize) -> [f32; 2] {
    let (width, height) = (map.x.width(), map.x.height());
    let (column, row) = (at % width, at / width);
    let near = |at: usize, length: usize| {
        at.saturating_sub(AROUND_ROOT)..(at + AROUND_ROOT + 1).min(length)
    };
    let mut sum = [[0.0; 2]; 2];
    for y in near(row, height) {
        for x in near(column, width).filter(|x| known.joins(at, y * width + x)) {
            let by = jacobian_at(map, known, x, y);
            for (sum, by) in sum.as_flattened_mut().iter_mut().zip(by.as_flattened()) {
                *sum += by;
            }
        }
    }
    turn(&sum)
}

/// The covered pixels of the same surface around one, those that share a side first.
fn neighbours(at: usize, surface: &MovingSurface) -> Vec<usize> {
    const AROUND: [[isize; 2]; 8] = [
        [-1, 0],
        [1, 0],
        [0, -1],
        [0, 1],
        [-1, -1],
        [1, -1],
        [-1, 1],
        [1, 1],
    ];
    let covered = surface.covered;
    let (width, height) = (covered.width() as isize, covered.height() as isize);
    let (x, y) = (at as isize % width, at as isize / width);
    let of_surface = |&[dx, dy]: &[isize; 2]| {
        let (u, v) = (x + dx, y + dy);
        if !(0..width).contains(&u) || !(0..height).contains(&v) {
            return None;
        }
        let next = (v * width + u) as usize;
        surface.joins(at, next).then_some(next)
    };
    AROUND.iter().filter_map(of_surface).collect()
}
