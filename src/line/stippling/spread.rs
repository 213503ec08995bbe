//! Dots distributed by tone, and spaced apart.

use super::super::random::Random;
use crate::frame::Plane;
use crate::frame::memory::Memory;
use crate::line::placed::Placed;
use glam::Vec2;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Ink from which dots overlap, and the factor for additional ones, times the square of the excess: where all paper is
/// covered, the areas of hexagonally packed dots add up to 1.21 of it.
const OVERLAPS_FROM: f32 = 0.55;
const OVERLAP: f32 = 1.3;

/// Dots in a cell of error diffusion at most.
const MOST_IN_CELL: f32 = 0.5;

/// Random part of the threshold of error diffusion, in dots.
const CHANCE: f32 = 0.5;

/// Number of rounds in which dots repel each other, and the step as a share of the missing distance.
const ROUNDS: usize = 10;
const PUSH: f32 = 0.3;

/// The distance wanted, relative to the root of the paper area per dot: 1.07 in a hexagonal order.
const APART: f32 = 1.0;

/// The farthest that a dot pushes, in radii.
const FARTHEST: f32 = 16.0;

/// Sum of the dots' areas needed to cover this share of the paper.
pub(super) fn laid(covered: f32) -> f32 {
    covered + OVERLAP * (covered - OVERLAPS_FROM).max(0.0).powi(2)
}

/// The positions once dots have repelled each other, all but the first few, which stay.
pub(super) fn spaced(
    mut places: Vec<Vec2>,
    fixed: usize,
    field: &DotDensity,
    memory: &Memory,
) -> Vec<Vec2> {
    let rounds = if fixed < places.len() { ROUNDS } else { 0 };
    for _ in (0..rounds).take_while(|_| !memory.is_cancelled()) {
        places = pushed(&places, fixed, field);
    }
    places
}

/// Number of dots wanted by position.
pub(super) struct DotDensity<'a> {
    ink: &'a Plane,
    /// Radius and area of a dot.
    pub(super) radius: f32,
    area: f32,
}

impl<'a> DotDensity<'a> {
    /// The dots of a radius that cover `ink`, 0..1, of the paper.
    pub(super) fn new(ink: &'a Plane, radius: f32) -> Self {
        Self {
            ink,
            radius,
            area: PI * radius * radius,
        }
    }

    pub(super) fn size(&self) -> [usize; 2] {
        [self.ink.width(), self.ink.height()]
    }

    /// Side of cells to look for other dots in.
    pub(super) fn cell_side(&self) -> f32 {
        (2.0 * self.radius).max(1.0)
    }

    /// The distance wanted between dots at a place; `None` where no ink is wanted.
    pub(super) fn apart(&self, at: Vec2) -> Option<f32> {
        let density = self.at(at);
        (density > 0.0).then(|| (APART / density.sqrt()).min(FARTHEST * self.radius))
    }

    /// Dots in a pixel of this ink.
    fn density(&self, ink: f32) -> f32 {
        // NaN counts as none.
        if ink > 0.0 {
            laid(ink.min(1.0)) / self.area
        } else {
            0.0
        }
    }

    /// Dots in the pixel of a place, 0 beyond the paper.
    pub(super) fn at(&self, at: Vec2) -> f32 {
        self.density(self.ink.within(at).unwrap_or(0.0))
    }
}

/// Dots by error diffusion [FS], in serpentine rows, on a finer grid if a pixel takes several.
pub(super) fn diffused(field: &DotDensity, seed: u64, memory: &Memory) -> Vec<Vec2> {
    let mut random = Random::new(seed);
    let most = laid(1.0) / field.area;
    let parts = (most / MOST_IN_CELL).sqrt().ceil().max(1.0) as usize;
    let width = field.ink.width() * parts;
    let mut errors = [vec![0.0_f32; width + 2], vec![0.0_f32; width + 2]];
    let mut dots = Vec::new();
    let part = 1.0 / parts as f32;
    for y in (0..field.ink.height() * parts).take_while(|_| !memory.is_cancelled()) {
        let [own, below] = &mut errors;
        below.fill(0.0);
        for column in 0..width {
            let (x, ahead) = match y % 2 {
                0 => (column, 1),
                _ => (width - 1 - column, -1),
            };
            let wanted = field.density(field.ink.at(x / parts, y / parts)) * part * part;
            let error = if wanted > 0.0 {
                let sum = wanted + own[x + 1];
                let is_dot = sum > 0.5 + CHANCE * random.signed() * 0.5;
                if is_dot {
                    let within = Vec2::new(random.unit(), random.unit());
                    dots.push((Vec2::new(x as f32, y as f32) + within) * part);
                }
                sum - f32::from(u8::from(is_dot))
            } else {
                // Where dots begin, the first one comes as soon as it would amid others.
                0.5 * random.signed()
            };
            let beside = |offset: isize| (x as isize + 1 + offset * ahead) as usize;
            own[beside(1)] += error * (7.0 / 16.0);
            below[beside(-1)] += error * (3.0 / 16.0);
            below[beside(0)] += error * (5.0 / 16.0);
            below[beside(1)] += error * (1.0 / 16.0);
        }
        errors.swap(0, 1);
    }
    dots
}

/// Every dot but the first few pushed away from dots that are too close, unless no ink is wanted there.
fn pushed(places: &[Vec2], fixed: usize, field: &DotDensity) -> Vec<Vec2> {
    let cells = by_cell(places, field);
    let farthest = FARTHEST * field.radius;
    let moved = |(number, &at): (usize, &Vec2)| {
        if number < fixed {
            return at;
        }
        let apart = field.apart(at).unwrap_or(farthest);
        let mut push = Vec2::ZERO;
        cells.near(at, apart).for_each(|other| {
            if other.line as usize != number {
                let away = at - other.at;
                let distance = away.length();
                push += away / distance.max(1e-3) * (apart - distance);
            }
        });
        let next = at + (PUSH * push).clamp_length_max(0.5 * apart);
        if field.at(next) > 0.0 { next } else { at }
    };
    places.par_iter().enumerate().map(moved).collect()
}

/// Positions by cell, with their numbers for those of lines.
pub(super) fn by_cell(places: &[Vec2], field: &DotDensity) -> Placed {
    let mut cells = Placed::new(field.size(), field.cell_side());
    // Those of a cell are seen in the order of numbers.
    for (number, &at) in places.iter().enumerate().rev() {
        cells.add(at, number as u32, 0);
    }
    cells
}
