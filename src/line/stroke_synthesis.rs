//! Strokes drawn one by one on a square that repeats, each where the paper is emptiest.

use super::random::Random;
use crate::params::{Stroke, Style};

/// What a [`super::tonal_art_map::TonalArtMap`] is made of.
pub(super) struct Canvas {
    pub(super) side: usize,
    pub(super) texels_per_px: f32,
    /// Where each texel begins to take ink and where it is full, 0..1.
    pub(super) ramps: Vec<[f32; 2]>,
}

/// Strokes that lie end to end on a square: fewer would show that it repeats.
const STROKES_ACROSS: f32 = 6.0;

/// Thinnest stroke in texels: what is thinner shows as grey either way.
const MIN_WIDTH: f32 = 0.5;

impl Canvas {
    pub(super) fn drawn(stroke: &Stroke, style: Style, seed: u64, max_side: usize) -> Self {
        let wanted = STROKES_ACROSS * stroke.length_px;
        let side = (wanted.ceil() as usize).next_power_of_two();
        let side = side.clamp(max_side / 4, max_side);
        let texels_per_px = (side as f32 / wanted).min(1.0);
        let habits = Habits::new(stroke, texels_per_px, side);
        let mut random = Random::new(seed);
        let mut canvas = Painter::new(side, &habits);
        let total = habits.total;
        for i in 0..total {
            let mark = canvas.emptiest(&habits, &mut random);
            canvas.draw(&mark, habits.order(i), &habits, &mut random);
        }
        let mut ramps = canvas.ramps;
        if style == Style::Pencil {
            soften(&mut ramps, side, &mut random);
        }
        rank(&mut ramps);
        Self {
            side,
            texels_per_px,
            ramps,
        }
    }
}

/// A stroke's sizes in texels and its place in the order.
struct Habits {
    half_width: f32,
    length: f32,
    wobble: f32,
    swell: f32,
    /// Strokes that reach the spacing of light tones, and when.
    first: f32,
    first_order: f32,
    total: usize,
}

impl Habits {
    fn new(stroke: &Stroke, texels_per_px: f32, side: usize) -> Self {
        let width = (stroke.width_px * texels_per_px).max(MIN_WIDTH);
        let length = (stroke.length_px * texels_per_px).clamp(2.0 * width, side as f32 / 2.0);
        let spacing = (stroke.spacing_px * texels_per_px).max(width);
        let area = (side * side) as f32;
        let first = area / (spacing * length);
        let total = COVERS * area / (width * length);
        Self {
            half_width: 0.5 * width,
            length,
            wobble: stroke.wobble,
            swell: 0.6 * stroke.pressure,
            first,
            first_order: width / spacing * (1.0 - stroke.pressure),
            total: total.ceil() as usize,
        }
    }

    /// When the i-th stroke appears, 0..1.
    fn order(&self, i: usize) -> f32 {
        let (i, total) = (i as f32, self.total as f32);
        if i < self.first {
            self.first_order * i / self.first
        } else {
            let rest = (i - self.first) / (total - self.first).max(1.0);
            self.first_order + (1.0 - self.first_order) * rest
        }
    }
}

/// How many times all strokes together would cover the paper.
const COVERS: f32 = 2.5;

/// Where a stroke lies: its middle, and its shape.
struct Mark {
    x: f32,
    y: f32,
}

/// Places a stroke is tried at.
const TRIALS: usize = 16;

struct Painter {
    side: usize,
    ramps: Vec<[f32; 2]>,
    /// How crowded the paper is, in cells.
    crowd: Vec<f32>,
    columns: usize,
    rows: usize,
}

impl Painter {
    fn new(side: usize, habits: &Habits) -> Self {
        let cells = |texels: f32| {
            let count = (side as f32 / texels.max(1.0)) as usize;
            count.next_power_of_two().clamp(4, side)
        };
        let columns = cells(habits.length / 6.0);
        let rows = cells(habits.half_width);
        Self {
            side,
            ramps: vec![[f32::INFINITY; 2]; side * side],
            crowd: vec![0.0; columns * rows],
            columns,
            rows,
        }
    }

    fn cells_along(&self, mark: &Mark, habits: &Habits) -> (usize, usize, usize) {
        let per_column = self.columns as f32 / self.side as f32;
        let from = (mark.x - 0.5 * habits.length).rem_euclid(self.side as f32) * per_column;
        let count = (habits.length * per_column).ceil() as usize + 1;
        let row = mark.y * self.rows as f32 / self.side as f32;
        (
            from as usize,
            count.min(self.columns),
            row as usize % self.rows,
        )
    }

    fn crowding(&self, mark: &Mark, habits: &Habits) -> f32 {
        let (from, count, row) = self.cells_along(mark, habits);
        let row = &self.crowd[row * self.columns..][..self.columns];
        (from..from + count).map(|c| row[c % self.columns]).sum()
    }

    /// The least crowded of several places.
    fn emptiest(&mut self, habits: &Habits, random: &mut Random) -> Mark {
        let side = self.side as f32;
        let mut best: Option<(f32, Mark)> = None;
        for _ in 0..TRIALS {
            let mark = Mark {
                x: side * random.unit(),
                y: side * random.unit(),
            };
            let crowding = self.crowding(&mark, habits);
            if best.as_ref().is_none_or(|(least, _)| crowding < *least) {
                best = Some((crowding, mark));
            }
        }
        let (_, mark) = best.expect("there are trials");
        self.crowd_around(&mark, habits);
        mark
    }

    fn crowd_around(&mut self, mark: &Mark, habits: &Habits) {
        let (from, count, row) = self.cells_along(mark, habits);
        let reach = self.rows / 2;
        let near = CROWD_NEAR.min(reach);
        for away in 0..=near {
            let push = 1.0 / (1.0 + (away * away) as f32);
            let sides: &[usize] = match away {
                0 => &[row],
                _ => &[
                    (row + away) % self.rows,
                    (row + self.rows - away) % self.rows,
                ],
            };
            for row in sides {
                let row = &mut self.crowd[row * self.columns..][..self.columns];
                for c in from..from + count {
                    row[c % self.columns] += push;
                }
            }
        }
    }

    /// Draws one stroke that appears at `order`.
    fn draw(&mut self, mark: &Mark, order: f32, habits: &Habits, random: &mut Random) {
        let wobble = habits.wobble;
        let half = 0.5 * habits.length * (1.0 + 0.35 * wobble * random.signed());
        let slant = 0.06 * wobble * random.signed();
        let bow = 0.05 * wobble * random.signed();
        let (waves, phase) = (
            1.0 + 2.0 * random.unit(),
            std::f32::consts::TAU * random.unit(),
        );
        let sway = 0.012 * wobble * habits.length.min(80.0) * random.unit();
        let press = 1.0 + 0.25 * wobble * random.signed();
        let width = habits.half_width * press;
        let reach = MOST_RELUCTANT * width + 1.0;
        let (first, last) = (
            (mark.x - half).floor() as i32,
            (mark.x + half).ceil() as i32,
        );
        for column in first..=last {
            let along = (column as f32 + 0.5 - mark.x) / half;
            let end = along.abs();
            if end >= 1.0 {
                continue;
            }
            let spine = mark.y
                + slant * along * half
                + bow * half * (along * along - 0.33)
                + sway * (waves * std::f32::consts::PI * along + phase).sin();
            let taper = (1.0 - end.powi(4)).sqrt();
            let late = order + habits.swell * 0.5 * end.powi(6);
            let width = width * taper.max(0.15);
            let rows = (spine - reach).floor() as i32..=(spine + reach).ceil() as i32;
            for row in rows {
                let away = (row as f32 + 0.5 - spine).abs();
                let begin = habits.reaches((away - 0.5).max(0.0) / width);
                let full = habits.reaches((away + 0.5) / width);
                if begin > habits.reaches(MOST_RELUCTANT) {
                    continue;
                }
                let wrap = self.side - 1;
                let at = (row as usize & wrap) * self.side + (column as usize & wrap);
                let ramp = &mut self.ramps[at];
                ramp[0] = ramp[0].min(late + begin);
                ramp[1] = ramp[1].min(late + full);
            }
        }
    }
}

/// Cells away up to which a stroke crowds others.
const CROWD_NEAR: usize = 24;

/// Half widths past which no pressure spreads a stroke.
const MOST_RELUCTANT: f32 = 3.0;

impl Habits {
    /// How much later than its middle a stroke reaches this many half widths away.
    fn reaches(&self, half_widths: f32) -> f32 {
        let within = half_widths.min(1.0);
        let past = half_widths - within;
        self.swell * within + (0.02 + 0.5 * (self.swell + 0.2)) * past + 0.005 * half_widths
    }
}

/// Graphite: greys come before black, and the grain of the paper takes it unevenly.
fn soften(ramps: &mut [[f32; 2]], side: usize, random: &mut Random) {
    let grain = grain(side, random);
    for (ramp, grain) in ramps.iter_mut().zip(grain) {
        if ramp[0].is_finite() {
            ramp[0] += 0.25 * grain;
            ramp[1] = ramp[1].max(ramp[0]) + 0.2 + 0.35 * grain;
        }
    }
}

/// The grain of paper: noise of a pixel or two, 0..1.
fn grain(side: usize, random: &mut Random) -> Vec<f32> {
    let white: Vec<f32> = (0..side * side).map(|_| random.unit()).collect();
    let wrap = side - 1;
    let at = |x: usize, y: usize| white[(y & wrap) * side + (x & wrap)];
    (0..side * side)
        .map(|i| {
            let (x, y) = (i % side, i / side);
            let around = at(x + 1, y) + at(x + side - 1, y) + at(x, y + 1) + at(x, y + side - 1);
            let mean = 0.4 * at(x, y) + 0.15 * around;
            (0.5 + 1.6 * (mean - 0.5)).clamp(0.0, 1.0)
        })
        .collect()
}

/// Puts thresholds in the order of all texels: even steps from the first to the last to take ink.
fn rank(ramps: &mut [[f32; 2]]) {
    let finite = |v: f32| v.is_finite();
    let top = ramps
        .iter()
        .map(|r| r[1])
        .filter(|&v| finite(v))
        .fold(0.0, f32::max)
        .max(1e-6);
    for ramp in ramps.iter_mut() {
        // What no stroke reached takes ink last.
        *ramp = ramp.map(|v| if finite(v) { v / top } else { 1.0 });
    }
    let mut counts = vec![0_u32; RANKS + 1];
    let bin = |v: f32| v * RANKS as f32;
    for &[begin, full] in ramps.iter() {
        counts[bin(0.5 * (begin + full)) as usize] += 1;
    }
    let total = ramps.len() as f32;
    let mut below = 0;
    let mut shares: Vec<f32> = counts
        .iter()
        .map(|&count| {
            let share = below as f32 / total;
            below += count;
            share
        })
        .collect();
    shares.push(1.0);
    let ranked = |v: f32| {
        let at = bin(v);
        let i = (at as usize).min(RANKS);
        shares[i] + (at - i as f32) * (shares[i + 1] - shares[i])
    };
    for ramp in ramps.iter_mut() {
        *ramp = ramp.map(ranked);
    }
}

/// Steps that ranks are told in.
const RANKS: usize = 1 << 14;
