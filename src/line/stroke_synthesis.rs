//! Stroke synthesis: strokes drawn one at a time on a tile that repeats, in lanes, each where the paper is still white.

use super::paper::rough;
use super::random::Random;
use crate::params::{Stroke, Style};

/// The drawn texels of a [`super::tonal_art_map::TonalArtMap`].
pub(super) struct DrawnTexels {
    pub(super) side: usize,
    pub(super) texels_per_px: f32,
    /// Tones at which each texel begins to take ink and is full, 0..1.
    pub(super) ramps: Vec<[f32; 2]>,
}

/// Number of strokes laid end to end across the square: fewer would reveal the repetition.
const STROKES_ACROSS: f32 = 6.0;

/// Fewest and most texels along a side: a quarter of a million in all stay in the cache.
const MIN_SIDE: usize = 128;
const MAX_SIDE: usize = 512;

/// Thinnest stroke in texels: thinner ones show as grey either way.
const MIN_WIDTH: f32 = 0.5;

impl DrawnTexels {
    pub(super) fn drawn(stroke: &Stroke, style: Style, random: &mut Random) -> Self {
        let wanted = STROKES_ACROSS * stroke.length_px;
        let side = (wanted.ceil() as usize).next_power_of_two();
        let side = side.clamp(MIN_SIDE, MAX_SIDE);
        let texels_per_px = (side as f32 / wanted).min(1.0);
        let mut painter = Painter {
            habits: Habits::new(stroke, texels_per_px, side),
            side,
            ramps: vec![[f32::INFINITY; 2]; side * side],
            starts: Vec::new(),
            random,
        };
        painter.fill();
        let Painter {
            mut ramps, random, ..
        } = painter;
        if style == Style::Pencil {
            soften(&mut ramps, side, random);
        }
        rank(&mut ramps);
        Self {
            side,
            texels_per_px,
            ramps,
        }
    }
}

/// A stroke's sizes in texels, and its ways.
#[derive(Clone, Copy)]
struct Habits {
    half_width: f32,
    length: f32,
    spacing: f32,
    wobble: f32,
    swell: f32,
}

impl Habits {
    fn new(stroke: &Stroke, texels_per_px: f32, side: usize) -> Self {
        let most = side as f32 / 2.0;
        let width = (stroke.width_px * texels_per_px).clamp(MIN_WIDTH, most / 2.0);
        let length = (stroke.length_px * texels_per_px).clamp(2.0 * width, most);
        Self {
            half_width: 0.5 * width,
            length,
            spacing: (stroke.spacing_px * texels_per_px).clamp(width, most),
            wobble: stroke.wobble,
            swell: 0.6 * stroke.pressure,
        }
    }

    /// Delay with which a stroke reaches this many half widths from its middle.
    fn reaches(&self, half_widths: f32) -> f32 {
        let within = half_widths.min(1.0);
        let past = half_widths - within;
        // A nib leaves a line of some width at once.
        let swelled = (within - NIB).max(0.0) / (1.0 - NIB);
        self.swell * swelled + (0.02 + 0.5 * (self.swell + 0.2)) * past + 0.005 * half_widths
    }
}

/// Share of its width that a stroke has however softly it is pressed.
const NIB: f32 = 0.5;

struct Painter<'a> {
    habits: Habits,
    side: usize,
    ramps: Vec<[f32; 2]>,
    /// Position of each lane, and of the start of its strokes.
    starts: Vec<(f32, f32)>,
    random: &'a mut Random,
}

impl Painter<'_> {
    /// Draws lanes of strokes at the distance for light tones, then lanes midway between those, until they touch.
    fn fill(&mut self) {
        let Habits {
            half_width,
            spacing,
            ..
        } = self.habits;
        let side = self.side as f32;
        let mut lanes = (side / spacing).round().max(1.0) as usize;
        let mut between = 0.0;
        let mut from = 0.0;
        loop {
            let pitch = side / lanes as f32;
            // The tone reached by the lanes so far when pressed hard.
            let to = (2.0 * half_width * side / pitch / side).min(1.0);
            for lane in 0..lanes {
                let place = radical_inverse(lane, lanes);
                let y = (lane as f32 + between) * pitch;
                self.lane(y, pitch, |jitter| {
                    from + (to - from) * (place + jitter).clamp(0.0, 1.0)
                });
            }
            if between > 0.0 {
                lanes *= 2;
            }
            between = 0.5;
            from = to;
            if pitch < 1.5 * half_width || to >= 1.0 {
                break;
            }
        }
    }

    /// Draws strokes end to end along a lane; `order` turns a random number into the time each appears.
    fn lane(&mut self, y: f32, pitch: f32, order: impl Fn(f32) -> f32) {
        let side = self.side as f32;
        let count = (side / self.habits.length).round().max(1.0);
        let step = side / count;
        let start = self.start(y, pitch);
        for i in 0..count as usize {
            let along = start + i as f32 + STRAY * self.random.signed();
            let y = y + 0.6 * self.habits.wobble * pitch * self.random.signed();
            let half_length = 0.5 * step * (OVERLAP + 0.2 * self.random.signed());
            let order = order(ORDER_JITTER * self.random.signed());
            self.draw([along * step, y], half_length, order);
        }
    }

    /// Start of a lane's strokes, in strokes, 0..1: of several random candidates the one farthest from the starts in
    /// adjacent lanes, so that ends do not form a hole.
    fn start(&mut self, y: f32, pitch: f32) -> f32 {
        let side = self.side as f32;
        let near = |&&(other, _): &&(f32, f32)| {
            let apart = (other - y).abs();
            apart.min(side - apart) < BESIDE * pitch
        };
        let beside: Vec<f32> = self.starts.iter().filter(near).map(|lane| lane.1).collect();
        let room = |start: f32| {
            let apart = beside.iter().map(|other| (other - start).abs());
            apart
                .map(|apart| apart.min(1.0 - apart))
                .fold(0.5, f32::min)
        };
        let tries: [f32; TRIES] = std::array::from_fn(|_| self.random.unit());
        let best = tries
            .into_iter()
            .max_by(|a, b| room(*a).total_cmp(&room(*b)));
        let best = best.expect("there are several");
        self.starts.push((y, best));
        best
    }

    /// Draws a stroke about its middle that appears at this tone.
    fn draw(&mut self, [x, y]: [f32; 2], half: f32, order: f32) {
        let habits = self.habits;
        let random = &mut *self.random;
        let wobble = habits.wobble;
        let slant = 0.05 * wobble * random.signed();
        let bow = 0.04 * wobble * random.signed();
        let waves = std::f32::consts::PI * (1.0 + 2.0 * random.unit());
        let phase = std::f32::consts::TAU * random.unit();
        let sway = 0.012 * wobble * half.min(40.0) * random.unit();
        let width = habits.half_width * (1.0 + 0.25 * wobble * random.signed());
        let reach = MOST_RELUCTANT * width + 1.0;
        let latest = habits.reaches(MOST_RELUCTANT);
        for column in (x - half).floor() as i32..=(x + half).ceil() as i32 {
            let along = (column as f32 + 0.5 - x) / half;
            let end = along.abs();
            if end >= 1.0 {
                continue;
            }
            let bent = slant * along + bow * (along * along - 0.33);
            let spine = y + half * bent + sway * (waves * along + phase).sin();
            let width = width * (1.0 - end.powi(4)).sqrt().max(0.15);
            let order = order + 0.5 * habits.swell * end.powi(6);
            for row in (spine - reach).floor() as i32..=(spine + reach).ceil() as i32 {
                let away = (row as f32 + 0.5 - spine).abs();
                let begin = habits.reaches((away - 0.5).max(0.0) / width);
                let full = habits.reaches((away + 0.5) / width);
                if begin <= latest {
                    self.ink(column, row, [order + begin, order + full]);
                }
            }
        }
    }

    fn ink(&mut self, column: i32, row: i32, ramp: [f32; 2]) {
        let wrap = self.side - 1;
        let at = (row as usize & wrap) * self.side + (column as usize & wrap);
        let texel = &mut self.ramps[at];
        *texel = [texel[0].min(ramp[0]), texel[1].min(ramp[1])];
    }
}

/// Distance in lanes up to which lanes are adjacent, and number of candidates. More of either make a slanting pattern
/// of ends, and strokes seem to slant.
const BESIDE: f32 = 1.2;
const TRIES: usize = 3;

/// Random offset of a stroke along its lane, in strokes.
const STRAY: f32 = 0.15;

/// Length of a stroke relative to its share of a lane: strokes end to end leave a gap as often as not.
const OVERLAP: f32 = 1.05;

/// Random variation of a stroke's time relative to its lane's, as a share of all lanes.
const ORDER_JITTER: f32 = 0.12;

/// The position, 0..1, of the i-th of `count` items in an order whose every prefix is evenly spread.
fn radical_inverse(i: usize, count: usize) -> f32 {
    let bits = usize::BITS - count.next_power_of_two().leading_zeros() - 1;
    match bits {
        0 => 0.0,
        _ => (i.reverse_bits() >> (usize::BITS - bits)) as f32 / (1_u64 << bits) as f32,
    }
}

/// Half widths past which no pressure spreads a stroke.
const MOST_RELUCTANT: f32 = 1.3;

/// Graphite: greys come before black, unevenly by the grain of the paper.
fn soften(ramps: &mut [[f32; 2]], side: usize, random: &mut Random) {
    let grain = grain(side, random);
    for (ramp, grain) in ramps.iter_mut().zip(grain) {
        if ramp[0].is_finite() {
            ramp[0] += 0.25 * grain;
            ramp[1] = ramp[1].max(ramp[0]) + 0.2 + 0.35 * grain;
        }
    }
}

/// The grain of paper, which repeats with the square.
fn grain(side: usize, random: &mut Random) -> Vec<f32> {
    let white: Vec<f32> = (0..side * side).map(|_| random.unit()).collect();
    let wrap = |at: usize, by: i32| at.wrapping_add_signed(by as isize) & (side - 1);
    (0..side * side)
        .map(|i| {
            let (x, y) = (i % side, i / side);
            rough(|dx, dy| white[wrap(y, dy) * side + wrap(x, dx)], SPREAD)
        })
        .collect()
}

/// Contrast of the grain for graphite.
const SPREAD: f32 = 1.6;

/// Ranks the thresholds of all texels: even steps from the first to the last to take ink.
fn rank(ramps: &mut [[f32; 2]]) {
    let finite = |v: f32| v.is_finite();
    let top = ramps
        .iter()
        .map(|r| r[1])
        .filter(|&v| finite(v))
        .fold(0.0, f32::max)
        .max(1e-6);
    for ramp in ramps.iter_mut() {
        // Texels reached by no stroke take ink last.
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

/// Steps of ranks.
const RANKS: usize = 1 << 14;
