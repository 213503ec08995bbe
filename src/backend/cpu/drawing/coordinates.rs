//! The places in which the texture of strokes lies still, carried from frame to frame.
//!
//! Each map of places was laid over the whole picture at once and has moved with the surface since. A pixel is
//! drawn by the oldest map that is sound there; what that leaves goes to younger ones in turn, and what all
//! leave to the one that comes next, which lies still in the picture until enough is asked of it: then it is
//! born, and moves too. So no surface that merely shifts or turns in the picture is ever laid anew, no stroke
//! is drawn far from its size, and where maps take turns, they do so smoothly over time and picture.

use super::sheet::Sheet;
use crate::backend::cpu::ROWS_PER_TASK;
use crate::backend::cpu::memory::Memory;
use crate::backend::cpu::passes::map_rows;
use crate::frame::{Frame, Mask, Plane, Vector2Planes, Window};
use crate::line::texture_coordinates::{
    Jacobian, continued, distortion, extrapolated, is_joined, jacobian, origin, soundness,
};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Maps that are kept at once, beside the next.
const MOST_MAPS: usize = 3;

/// Share of the surface that has to ask for the next map before it is born: of less, moving or not is not
/// seen.
const BIRTH: f64 = 0.01;

/// Share of the surface from which on that cannot wait for an older map to fade.
const URGENT: f64 = 0.1;

/// Frames over which a map fades that has to make room.
const FADE_FRAMES: f32 = 6.0;

/// Largest step of depth, as a share of it, between pixels of one surface, and between frames, once the
/// median of all is taken out. A surface that comes nearer by more in a frame is laid anew; behind an edge
/// that is nearer than this to its background the background keeps strokes of what covered it.
const DEPTH_STEP: f32 = 0.08;

/// Without depth: largest change of motion from frame to frame, in pixels and as a share of the motion.
const MOTION_STEP: [f32; 2] = [1.5, 0.5];

/// Pixels along each axis from one to the next that is looked at for the change of all depth.
const STRIDE: usize = 8;

/// Where the texture of strokes lies still, for every pixel of a frame: what a sequence hands on from one
/// frame to the next.
#[derive(Debug, Clone)]
pub struct TextureCoordinates {
    window: Window,
    mask: Mask,
    depth: Option<Plane>,
    /// Where there is no depth: how the frame had moved, from the second on.
    motion: Option<Vector2Planes>,
    /// Oldest first.
    maps: Vec<PlaceMap>,
    /// Share of the map that comes next, where any is asked of it.
    next: Option<Plane>,
    /// How many maps were born.
    born: u32,
}

/// A map of places that moves with the surface.
#[derive(Debug, Clone)]
struct PlaceMap {
    /// Pixel coordinates, rows down, in which the texture lies still.
    place: Vector2Planes,
    /// Share of the drawing, 0..1; `None` is 1.
    share: Option<Plane>,
    /// 1; falls to 0 where the map has to make room.
    fade: f32,
    generation: u32,
}

impl TextureCoordinates {
    /// Those of a first frame: the texture lies as in a still picture.
    pub fn new(frame: &Frame) -> Self {
        Self {
            window: frame.data_window,
            mask: frame.mask.clone(),
            depth: frame.depth.clone(),
            motion: None,
            maps: vec![PlaceMap::laid(0, frame)],
            next: None,
            born: 1,
        }
    }

    /// Those of the next frame, whose surface has come by `motion` since: pixels, x right, y up.
    ///
    /// # Panics
    /// If `motion` has not the size of the frame.
    pub fn advanced(&self, frame: &Frame, motion: &Vector2Planes) -> Self {
        self.advanced_in(frame, motion, &Memory::default())
    }

    pub(super) fn advanced_in(
        &self,
        frame: &Frame,
        motion: &Vector2Planes,
        memory: &Memory,
    ) -> Self {
        let step = Step::new(self, frame, motion);
        let known = step.known();
        let hidden = Hidden::find(&known, frame);
        let maps = self.maps.iter().filter_map(|map| {
            let fade = match map.fade < 1.0 {
                true => map.fade - FADE_FRAMES.recip(),
                false => 1.0,
            };
            (fade > 0.0).then(|| PlaceMap {
                place: step.carried(map, &known, &hidden, memory),
                share: None,
                fade,
                generation: map.generation,
            })
        });
        let mut next = Self {
            window: frame.data_window,
            mask: frame.mask.clone(),
            depth: frame.depth.clone(),
            motion: frame.depth.is_none().then(|| motion.clone()),
            maps: maps.collect(),
            next: None,
            born: self.born,
        };
        next.share_out(frame, memory);
        next
    }

    /// The pixels of `frame` whose surface was seen in the frame before too, where `motion` comes from.
    pub fn seen_before(&self, frame: &Frame, motion: &Vector2Planes) -> Mask {
        Mask::new(Step::new(self, frame, motion).known())
    }

    /// What the drawing is made of.
    pub(super) fn sheets(&self) -> Vec<Sheet<'_>> {
        let moving = self.maps.iter().map(|map| Sheet {
            place: Some((&map.place, &self.mask)),
            origin: [0.0; 2],
            share: map.share.as_ref(),
        });
        let next = self.next.as_ref().map(|share| Sheet {
            place: None,
            origin: origin(self.born),
            share: Some(share),
        });
        moving.chain(next).collect()
    }

    /// Shares of the maps in the drawing, oldest first, and of the one that comes next: their means over
    /// the surface.
    pub fn mean_shares(&self) -> Vec<f64> {
        let covered = self.mask.count().max(1) as f64;
        let mean = |share: &Plane| {
            let sum: f64 = share.samples().iter().map(|&s| f64::from(s)).sum();
            sum / covered
        };
        let maps = self.maps.iter();
        let maps = maps.map(|map| map.share.as_ref().map_or(1.0, mean));
        maps.chain(self.next.as_ref().map(mean)).collect()
    }

    /// Gives every map its share, lets the next be born where it is time, and old ones go.
    fn share_out(&mut self, frame: &Frame, memory: &Memory) {
        let covered = self.mask.count() as f64;
        let mut weighed = Weighed::of(&self.maps, &self.mask, memory);
        let asked = *weighed.totals.last().expect("the next has a share");
        if asked > BIRTH * covered {
            let used = weighed.totals[..self.maps.len()].iter();
            let least = used.enumerate().min_by(|a, b| a.1.total_cmp(b.1));
            if let Some((least, _)) = least.filter(|_| self.maps.len() == MOST_MAPS) {
                let fading = self.maps.iter().any(|map| map.fade < 1.0);
                if asked > URGENT * covered {
                    self.maps.remove(least);
                } else if !fading {
                    self.maps[least].fade -= FADE_FRAMES.recip();
                }
            }
            if self.maps.len() < MOST_MAPS {
                self.maps.push(PlaceMap::laid(self.born, frame));
                self.born += 1;
            }
            weighed = Weighed::of(&self.maps, &self.mask, memory);
        }
        let Weighed { mut shares, totals } = weighed;
        let next = shares.pop().filter(|_| totals[self.maps.len()] > 0.0);
        let alone = self.maps.len() == 1 && next.is_none();
        for ((map, share), &total) in self.maps.iter_mut().zip(shares).zip(&totals) {
            map.share = Some(share).filter(|_| !alone);
            // Nothing is asked of it any more, and it grows no sounder.
            map.fade = if total > 0.0 { map.fade } else { 0.0 };
        }
        self.maps.retain(|map| map.fade > 0.0);
        self.next = next;
    }
}

impl PlaceMap {
    /// A map that is laid over `frame` as it is.
    fn laid(generation: u32, frame: &Frame) -> Self {
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let [left, top] = origin_in(generation, frame.data_window);
        Self {
            place: Vector2Planes {
                x: Plane::from_fn(width, height, |x, _| left + x as f32),
                y: Plane::from_fn(width, height, |_, y| top + y as f32),
            },
            share: None,
            fade: 1.0,
            generation,
        }
    }
}

/// The place of the centre of the first pixel of `window`.
fn origin_in(generation: u32, window: Window) -> [f32; 2] {
    let [x, y] = origin(generation);
    [x + window.x0 as f32 + 0.5, y + window.y0 as f32 + 0.5]
}

/// The place that a map gives a pixel.
#[inline(always)]
fn place_at(map: &Vector2Planes, x: usize, y: usize) -> [f32; 2] {
    [map.x.at(x, y), map.y.at(x, y)]
}

/// The Jacobian of a map at a pixel, by those of its neighbours that are `covered`.
#[inline(always)]
pub(super) fn jacobian_at(
    map: &Vector2Planes,
    covered: &Plane<bool>,
    x: usize,
    y: usize,
) -> Jacobian {
    let at = |x: usize, y: usize| covered.at(x, y).then(|| place_at(map, x, y));
    let before = |i: usize| i.checked_sub(1);
    let after = |i: usize, length: usize| Some(i + 1).filter(|&i| i < length);
    jacobian(
        place_at(map, x, y),
        [
            before(x).and_then(|x| at(x, y)),
            after(x, covered.width()).and_then(|x| at(x, y)),
        ],
        [
            before(y).and_then(|y| at(x, y)),
            after(y, covered.height()).and_then(|y| at(x, y)),
        ],
    )
}

/// From one frame to the next.
struct Step<'a> {
    before: &'a TextureCoordinates,
    frame: &'a Frame,
    motion: &'a Vector2Planes,
    /// Depth now over depth before, in the median.
    depth_ratio: f32,
}

/// Where a pixel's surface was in the frame before: between four pixels.
struct Taps {
    /// The one left above.
    left: isize,
    top: isize,
    /// How far right and below of it.
    across: f32,
    down: f32,
}

/// A pixel between which and its neighbours a surface was, and its weight.
#[derive(Clone, Copy)]
struct Tap {
    x: usize,
    y: usize,
    weight: f32,
    /// From it to where the surface was.
    offset: [f32; 2],
}

/// Weights below this are those of rounding.
const LEAST_WEIGHT: f32 = 1e-4;

impl<'a> Step<'a> {
    fn new(before: &'a TextureCoordinates, frame: &'a Frame, motion: &'a Vector2Planes) -> Self {
        let size = |plane: &Plane| (plane.width(), plane.height());
        let expected = (frame.mask.width(), frame.mask.height());
        assert!(
            size(&motion.x) == expected && size(&motion.y) == expected,
            "motion has the size of its frame"
        );
        let mut step = Self {
            before,
            frame,
            motion,
            depth_ratio: 1.0,
        };
        step.depth_ratio = step.median_depth_ratio();
        step
    }

    /// Where the surface seen at a pixel was in the frame before, in pixels of its planes; `None` out of them.
    #[inline(always)]
    fn taps(&self, x: usize, y: usize) -> Option<Taps> {
        let (now, then) = (self.frame.data_window, self.before.window);
        let from = |at: usize, shift: i32, moved: f32, length: usize| {
            let from = at as f64 + f64::from(shift) - f64::from(moved);
            // A motion that is not a number leads nowhere either.
            (from > -1.0 && from < length as f64).then(|| (from.floor(), from))
        };
        let (width, height) = (self.before.mask.width(), self.before.mask.height());
        let (left, u) = from(x, now.x0 - then.x0, self.motion.x.at(x, y), width)?;
        let (top, v) = from(y, now.y0 - then.y0, -self.motion.y.at(x, y), height)?;
        Some(Taps {
            left: left as isize,
            top: top as isize,
            across: (u - left) as f32,
            down: (v - top) as f32,
        })
    }

    /// Those of the four pixels that count and show the surface now seen at (`x`, `y`); whether all do.
    #[inline(always)]
    fn of_surface(&self, x: usize, y: usize) -> ([Option<Tap>; 4], bool) {
        let Some(taps) = self.taps(x, y) else {
            return ([None; 4], false);
        };
        let mask = &self.before.mask;
        let mut found = [None; 4];
        let mut whole = true;
        for (k, tap) in found.iter_mut().enumerate() {
            let (right, below) = (k % 2, k / 2);
            let offset = [taps.across - right as f32, taps.down - below as f32];
            let weight = (1.0 - offset[0].abs()) * (1.0 - offset[1].abs());
            if weight < LEAST_WEIGHT {
                continue;
            }
            let (u, v) = (taps.left + right as isize, taps.top + below as isize);
            let inside =
                (0..mask.width() as isize).contains(&u) && (0..mask.height() as isize).contains(&v);
            let (u, v) = (u as usize, v as usize);
            if inside && mask.at(u, v) && self.is_same_surface([x, y], [u, v]) {
                *tap = Some(Tap {
                    x: u,
                    y: v,
                    weight,
                    offset,
                });
            } else {
                whole = false;
            }
        }
        (found, whole)
    }

    #[inline(always)]
    fn is_same_surface(&self, now: [usize; 2], then: [usize; 2]) -> bool {
        if let (Some(depth), Some(before)) = (&self.frame.depth, &self.before.depth) {
            let before = self.depth_ratio * before.at(then[0], then[1]);
            return is_one_depth(depth.at(now[0], now[1]), before);
        }
        let Some(before) = &self.before.motion else {
            return true;
        };
        let motion = [&self.motion.x, &self.motion.y].map(|plane| plane.at(now[0], now[1]));
        let before = [&before.x, &before.y].map(|plane| plane.at(then[0], then[1]));
        let change = (motion[0] - before[0]).hypot(motion[1] - before[1]);
        change <= MOTION_STEP[0] + MOTION_STEP[1] * motion[0].hypot(motion[1])
    }

    /// What the depth of most of the frame changed by: a camera may move fast.
    fn median_depth_ratio(&self) -> f32 {
        let (Some(depth), Some(before)) = (&self.frame.depth, &self.before.depth) else {
            return 1.0;
        };
        let mask = &self.before.mask;
        let mut ratios = Vec::new();
        for y in (0..self.frame.mask.height()).step_by(STRIDE) {
            for x in (0..self.frame.mask.width()).step_by(STRIDE) {
                let covered = self.frame.mask.at(x, y);
                let Some(taps) = self.taps(x, y).filter(|_| covered) else {
                    continue;
                };
                let (u, v) = (taps.left.max(0) as usize, taps.top.max(0) as usize);
                if mask.at(u, v) {
                    ratios.push(depth.at(x, y) / before.at(u, v));
                }
            }
        }
        ratios.retain(|ratio| ratio.is_finite() && *ratio > 0.0);
        if ratios.is_empty() {
            return 1.0;
        }
        let middle = ratios.len() / 2;
        *ratios.select_nth_unstable_by(middle, f32::total_cmp).1
    }

    /// The pixels whose surface was seen in the frame before.
    fn known(&self) -> Plane<bool> {
        let mask = &self.frame.mask;
        let mut known = Plane::filled(mask.width(), mask.height(), false);
        let rows = known.samples_mut().par_chunks_mut(mask.width().max(1));
        let rows = rows.enumerate().with_min_len(ROWS_PER_TASK);
        rows.for_each(|(y, row)| {
            for run in mask.runs(y) {
                for x in run {
                    row[x] = self.of_surface(x, y).0.iter().any(Option::is_some);
                }
            }
        });
        known
    }

    /// The places of `map`, moved to this frame.
    fn carried(
        &self,
        map: &PlaceMap,
        known: &Plane<bool>,
        hidden: &Hidden,
        memory: &Memory,
    ) -> Vector2Planes {
        let mask = &self.frame.mask;
        let [left, top] = origin_in(map.generation, self.frame.data_window);
        let [mut xs, mut ys] = map_rows(mask, memory, |y, [xs, ys]| {
            for run in mask.runs(y) {
                for x in run {
                    let still = [left + x as f32, top + y as f32];
                    let place = self.place(map, x, y).unwrap_or(still);
                    [xs[x], ys[x]] = place;
                }
            }
        });
        let moved = Vector2Planes { x: xs, y: ys };
        let filled = hidden.found.iter().map(|&(at, root)| {
            let [x, y] = hidden.pixel(root);
            let [u, v] = hidden.pixel(at);
            let offset = [u as f32 - x as f32, v as f32 - y as f32];
            let by = jacobian_at(&moved, known, x, y);
            (at as usize, continued(place_at(&moved, x, y), &by, offset))
        });
        let filled: Vec<_> = filled.collect();
        Vector2Planes { x: xs, y: ys } = moved;
        for (at, [x, y]) in filled {
            xs.samples_mut()[at] = x;
            ys.samples_mut()[at] = y;
        }
        Vector2Planes { x: xs, y: ys }
    }

    /// The place that the surface seen at a pixel had before.
    #[inline(always)]
    fn place(&self, map: &PlaceMap, x: usize, y: usize) -> Option<[f32; 2]> {
        let (taps, whole) = self.of_surface(x, y);
        let nearest = taps.iter().flatten();
        let nearest = nearest.max_by(|a, b| a.weight.total_cmp(&b.weight))?;
        let here = place_at(&map.place, nearest.x, nearest.y);
        let of_taps = taps.map(|tap| tap.map(|tap| (tap, place_at(&map.place, tap.x, tap.y))));
        let joined = |&(_, place): &(Tap, [f32; 2])| is_joined(here, place);
        if whole && of_taps.iter().flatten().all(joined) {
            // Weights of all that count add up to 1 but for rounding, taken out here.
            let mut moved = here;
            for (tap, place) in of_taps.iter().flatten() {
                moved[0] += tap.weight * (place[0] - here[0]);
                moved[1] += tap.weight * (place[1] - here[1]);
            }
            return Some(moved);
        }
        let by = jacobian_at(&map.place, self.before.mask.plane(), nearest.x, nearest.y);
        Some(extrapolated(here, &by, nearest.offset))
    }
}

/// Whether two depths, of neighbours or of one pixel in two frames, can be of one surface.
#[inline(always)]
fn is_one_depth(a: f32, b: f32) -> bool {
    // Depths that are no numbers part nothing.
    let parted = (a - b).abs() > DEPTH_STEP * a.abs().min(b.abs());
    !parted
}

/// Pixels that were not seen before, and the nearest that were and are of the same surface.
struct Hidden {
    width: usize,
    /// Pixel and root, by index.
    found: Vec<(u32, u32)>,
}

impl Hidden {
    fn find(known: &Plane<bool>, frame: &Frame) -> Self {
        let (mask, width) = (&frame.mask, known.width());
        let samples = known.samples().iter().zip(mask.plane().samples());
        let hidden = samples
            .enumerate()
            .filter(|(_, (known, covered))| **covered && !**known)
            .map(|(i, _)| i);
        let hidden: Vec<usize> = hidden.collect();
        let mut found = Vec::with_capacity(hidden.len());
        if hidden.is_empty() {
            return Self { width, found };
        }
        let mut taken = known.clone();
        let mut front = VecDeque::new();
        for &at in &hidden {
            let neighbours = neighbours(at, known, frame);
            let root = neighbours.into_iter().find(|&n| known.samples()[n]);
            if let Some(root) = root {
                taken.samples_mut()[at] = true;
                front.push_back((at, root));
            }
        }
        while let Some((at, root)) = front.pop_front() {
            found.push((at as u32, root as u32));
            for next in neighbours(at, known, frame) {
                if !taken.samples()[next] {
                    taken.samples_mut()[next] = true;
                    front.push_back((next, root));
                }
            }
        }
        Self { width, found }
    }

    fn pixel(&self, index: u32) -> [usize; 2] {
        [index as usize % self.width, index as usize / self.width]
    }
}

/// The covered neighbours of a pixel that are of the same surface, those that share a side first.
fn neighbours(at: usize, known: &Plane<bool>, frame: &Frame) -> Vec<usize> {
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
    let (width, height) = (known.width() as isize, known.height() as isize);
    let (x, y) = (at as isize % width, at as isize / width);
    let of_surface = |&[dx, dy]: &[isize; 2]| {
        let (u, v) = (x + dx, y + dy);
        if !(0..width).contains(&u) || !(0..height).contains(&v) {
            return None;
        }
        let next = (v * width + u) as usize;
        let depth = frame.depth.as_ref().map(Plane::samples);
        let is_one = depth.is_none_or(|depth| is_one_depth(depth[at], depth[next]));
        (frame.mask.plane().samples()[next] && is_one).then_some(next)
    };
    AROUND.iter().filter_map(of_surface).collect()
}

/// The shares of maps, and last of the one that comes next.
struct Weighed {
    shares: Vec<Plane>,
    /// Their sums over the surface.
    totals: Vec<f64>,
}

impl Weighed {
    fn of(maps: &[PlaceMap], mask: &Mask, memory: &Memory) -> Self {
        let mut shares: Vec<Plane> = (0..=maps.len()).map(|_| memory.plane(mask)).collect();
        let width = mask.width().max(1);
        let mut rows: Vec<Vec<&mut [f32]>> = (0..mask.height()).map(|_| Vec::new()).collect();
        for share in &mut shares {
            let of_share = share.samples_mut().chunks_mut(width);
            rows.iter_mut()
                .zip(of_share)
                .for_each(|(rows, row)| rows.push(row));
        }
        let sums = rows.into_par_iter().enumerate().with_min_len(ROWS_PER_TASK);
        let sums: Vec<Vec<f64>> = sums
            .map(|(y, rows)| row_of_shares(maps, mask, y, rows))
            .collect();
        let mut totals = vec![0.0; shares.len()];
        for sums in sums {
            totals
                .iter_mut()
                .zip(sums)
                .for_each(|(total, sum)| *total += sum);
        }
        Self { shares, totals }
    }
}

/// Shares of row `y`, and their sums.
fn row_of_shares(maps: &[PlaceMap], mask: &Mask, y: usize, mut rows: Vec<&mut [f32]>) -> Vec<f64> {
    let mut sums = vec![0.0; rows.len()];
    for run in mask.runs(y) {
        for x in run {
            let mut left = 1.0;
            for (i, map) in maps.iter().enumerate() {
                let mut share = 0.0;
                if left > 0.0 {
                    let by = jacobian_at(&map.place, mask.plane(), x, y);
                    share = left * map.fade * soundness(distortion(&by));
                }
                rows[i][x] = share;
                sums[i] += f64::from(share);
                left -= share;
            }
            rows[maps.len()][x] = left;
            sums[maps.len()] += f64::from(left);
        }
    }
    sums
}
