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
        let origins = step.origins();
        let hidden = Hidden::find(&origins, frame);
        let maps = self.maps.iter().filter_map(|map| {
            let fade = match map.fade < 1.0 {
                true => map.fade - FADE_FRAMES.recip(),
                false => 1.0,
            };
            (fade > 0.0).then(|| PlaceMap {
                place: step.carried(map, &origins, &hidden, memory),
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

    /// The pixels of `frame` whose surface was wholly seen in the frame before too, where `motion` comes from.
    pub fn seen_before(&self, frame: &Frame, motion: &Vector2Planes) -> Mask {
        let origins = Step::new(self, frame, motion).origins();
        Mask::new(origins.map(|origin| origin.whole))
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
        let asked = weighed.asked();
        if asked > URGENT * covered && self.maps.len() == MOST_MAPS {
            self.maps.remove(weighed.least_used());
            weighed = Weighed::of(&self.maps, &self.mask, memory);
        }
        if asked > BIRTH * covered {
            if self.maps.len() < MOST_MAPS {
                // It serves perfectly where it was laid: what was asked of the next is its own.
                self.maps.push(PlaceMap::laid(self.born, frame));
                self.born += 1;
            } else if self.maps.iter().all(|map| map.fade == 1.0) {
                self.maps[weighed.least_used()].fade -= FADE_FRAMES.recip();
            }
        }
        let Weighed { mut shares, totals } = weighed;
        self.next = match shares.len() > self.maps.len() {
            true => shares.pop().filter(|_| asked > 0.0),
            false => None,
        };
        let alone = self.maps.len() == 1 && self.next.is_none();
        let mut served = Vec::new();
        for ((mut map, share), total) in self.maps.drain(..).zip(shares).zip(totals) {
            // A map of which nothing is asked grows no sounder.
            if total > 0.0 {
                map.share = Some(share).filter(|_| !alone);
                served.push(map);
            }
        }
        self.maps = served;
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

/// The place that a map gives the pixel of an index.
#[inline(always)]
fn place_at(map: &Vector2Planes, at: usize) -> [f32; 2] {
    [map.x.samples()[at], map.y.samples()[at]]
}

/// The Jacobian of a map at a pixel, by those of its neighbours that are `covered`.
#[inline(always)]
pub(super) fn jacobian_at(
    map: &Vector2Planes,
    covered: &Plane<bool>,
    x: usize,
    y: usize,
) -> Jacobian {
    let (width, height) = (covered.width(), covered.height());
    let at = y * width + x;
    let place =
        |inside: bool, at: usize| (inside && covered.samples()[at]).then(|| place_at(map, at));
    jacobian(
        place_at(map, at),
        [
            place(x > 0, at.wrapping_sub(1)),
            place(x + 1 < width, at + 1),
        ],
        [
            place(y > 0, at.wrapping_sub(width)),
            place(y + 1 < height, at + width),
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

/// Where the surface of a pixel was in the frame before: between four pixels.
#[derive(Debug, Clone, Copy, Default)]
struct Origin {
    /// Column and row of the left upper one; one less than the first may be meant.
    left: i32,
    top: i32,
    /// How far right and below of it.
    across: f32,
    down: f32,
    /// Which of the four show that surface, a bit each, row by row.
    seen: u8,
    /// Whether all of them do that have a weight.
    whole: bool,
}

/// Weights below this are those of rounding.
const LEAST_WEIGHT: f32 = 1e-4;

impl Origin {
    /// From one of the four pixels to where the surface was.
    #[inline(always)]
    fn offset(&self, k: usize) -> [f32; 2] {
        [self.across - (k % 2) as f32, self.down - (k / 2) as f32]
    }

    #[inline(always)]
    fn weight(&self, k: usize) -> f32 {
        let [x, y] = self.offset(k);
        (1.0 - x.abs()) * (1.0 - y.abs())
    }

    /// Column and row of one of the four, if it has a weight and lies within `width` x `height`.
    #[inline(always)]
    fn pixel(&self, k: usize, width: usize, height: usize) -> Option<[usize; 2]> {
        let (x, y) = (self.left + (k % 2) as i32, self.top + (k / 2) as i32);
        let inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
        inside.then_some([x as usize, y as usize])
    }

    #[inline(always)]
    fn is_seen(&self, k: usize) -> bool {
        self.seen >> k & 1 == 1
    }
}

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

    /// Between which pixels the surface of a pixel was; `None` outside all of them.
    #[inline(always)]
    fn between(&self, x: usize, y: usize) -> Option<Origin> {
        let (now, then) = (self.frame.data_window, self.before.window);
        let from = |at: usize, shift: i32, moved: f32, length: usize| {
            let from = at as f64 + f64::from(shift) - f64::from(moved);
            // A motion that is not a number leads nowhere either.
            (from > -1.0 && from < length as f64).then(|| (from.floor(), from))
        };
        let (width, height) = (self.before.mask.width(), self.before.mask.height());
        let (left, u) = from(x, now.x0 - then.x0, self.motion.x.at(x, y), width)?;
        let (top, v) = from(y, now.y0 - then.y0, -self.motion.y.at(x, y), height)?;
        Some(Origin {
            left: left as i32,
            top: top as i32,
            across: (u - left) as f32,
            down: (v - top) as f32,
            seen: 0,
            whole: false,
        })
    }

    /// The same, with which of these pixels show that surface.
    #[inline(always)]
    fn origin(&self, x: usize, y: usize) -> Origin {
        let Some(mut origin) = self.between(x, y) else {
            return Origin::default();
        };
        let mask = &self.before.mask;
        origin.whole = true;
        for k in 0..4 {
            if origin.weight(k) < LEAST_WEIGHT {
                continue;
            }
            let pixel = origin.pixel(k, mask.width(), mask.height());
            let seen =
                pixel.filter(|&[u, v]| mask.at(u, v) && self.is_same_surface([x, y], [u, v]));
            origin.seen |= u8::from(seen.is_some()) << k;
            origin.whole &= seen.is_some();
        }
        origin
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
                let origin = self.between(x, y).filter(|_| covered);
                let pixel = origin.and_then(|o| o.pixel(0, mask.width(), mask.height()));
                if let Some([u, v]) = pixel.filter(|&[u, v]| mask.at(u, v)) {
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

    /// Where every covered pixel's surface was.
    fn origins(&self) -> Plane<Origin> {
        let mask = &self.frame.mask;
        let mut origins = Plane::filled(mask.width(), mask.height(), Origin::default());
        let rows = origins.samples_mut().par_chunks_mut(mask.width().max(1));
        let rows = rows.enumerate().with_min_len(ROWS_PER_TASK);
        rows.for_each(|(y, row)| {
            for run in mask.runs(y) {
                for x in run {
                    row[x] = self.origin(x, y);
                }
            }
        });
        origins
    }

    /// The places of `map`, moved to this frame.
    fn carried(
        &self,
        map: &PlaceMap,
        origins: &Plane<Origin>,
        hidden: &Hidden,
        memory: &Memory,
    ) -> Vector2Planes {
        let mask = &self.frame.mask;
        let [left, top] = origin_in(map.generation, self.frame.data_window);
        let [x, y] = map_rows(mask, memory, |y, [xs, ys]| {
            let origins = origins.row(y);
            for run in mask.runs(y) {
                for x in run {
                    let still = [left + x as f32, top + y as f32];
                    [xs[x], ys[x]] = self.place(map, &origins[x]).unwrap_or(still);
                }
            }
        });
        let mut moved = Vector2Planes { x, y };
        hidden.fill(&mut moved);
        let [x, y] = map_rows(mask, memory, |y, [xs, ys]| {
            for run in mask.runs(y) {
                for x in run {
                    [xs[x], ys[x]] = calmed(&moved, mask.plane(), x, y);
                }
            }
        });
        memory.take_back([moved.x, moved.y]);
        Vector2Planes { x, y }
    }

    /// The place that a surface had before.
    #[inline(always)]
    fn place(&self, map: &PlaceMap, origin: &Origin) -> Option<[f32; 2]> {
        if origin.seen == 0 {
            return None;
        }
        let mask = self.before.mask.plane();
        let (width, height) = (mask.width(), mask.height());
        let nearest = (0..4).filter(|&k| origin.is_seen(k));
        let nearest = nearest.max_by(|&a, &b| origin.weight(a).total_cmp(&origin.weight(b)))?;
        let [x, y] = origin.pixel(nearest, width, height)?;
        let here = place_at(&map.place, y * width + x);
        let (mut moved, mut joined) = (here, origin.whole);
        for k in (0..4).filter(|&k| origin.is_seen(k) && k != nearest) {
            let [u, v] = origin.pixel(k, width, height)?;
            let there = place_at(&map.place, v * width + u);
            joined &= is_joined(here, there);
            let weight = origin.weight(k);
            moved[0] += weight * (there[0] - here[0]);
            moved[1] += weight * (there[1] - here[1]);
        }
        if joined {
            return Some(moved);
        }
        let by = jacobian_at(&map.place, mask, x, y);
        Some(extrapolated(here, &by, origin.offset(nearest)))
    }
}

/// A place without the roughness that motion brings in from frame to frame: averaged with those around,
/// as far as they are of the same surface and lie in pairs on opposite sides. What is a shift, a turn or any
/// other affine map stays as it is.
#[inline(always)]
fn calmed(map: &Vector2Planes, covered: &Plane<bool>, x: usize, y: usize) -> [f32; 2] {
    let (width, height) = (covered.width(), covered.height());
    let at = y * width + x;
    let here = place_at(map, at);
    let mut calm = here;
    if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
        return calm;
    }
    for (step, weight) in [
        (1, 0.125),
        (width, 0.125),
        (width + 1, 0.0625),
        (width - 1, 0.0625),
    ] {
        let (before, after) = (at - step, at + step);
        if covered.samples()[before] && covered.samples()[after] {
            let [a, b] = [before, after].map(|at| place_at(map, at));
            if is_joined(here, a) && is_joined(here, b) {
                calm[0] += weight * ((a[0] - here[0]) + (b[0] - here[0]));
                calm[1] += weight * ((a[1] - here[1]) + (b[1] - here[1]));
            }
        }
    }
    calm
}

/// Whether two depths, of neighbours or of one pixel in two frames, can be of one surface.
#[inline(always)]
fn is_one_depth(a: f32, b: f32) -> bool {
    // Depths that are no numbers part nothing.
    let parted = (a - b).abs() > DEPTH_STEP * a.abs().min(b.abs());
    !parted
}

/// Pixels that were not seen before, as far as some next to them were that are of the same surface.
struct Hidden {
    known: Plane<bool>,
    /// In the order of their distance from what is known.
    pixels: Vec<HiddenPixel>,
}

struct HiddenPixel {
    at: usize,
    /// The nearest pixel that was seen before.
    root: usize,
    /// Pixels beside it of the same surface.
    beside: Vec<usize>,
}

/// How often places of hidden pixels are averaged with those around them: it takes out the seams between
/// those that go on from different pixels.
const RELAXATIONS: usize = 24;

impl Hidden {
    fn find(origins: &Plane<Origin>, frame: &Frame) -> Self {
        let known = origins.map(|origin| origin.seen != 0);
        let samples = known.samples().iter().zip(frame.mask.plane().samples());
        let hidden = samples.enumerate();
        let hidden = hidden.filter(|(_, (known, covered))| **covered && !**known);
        let mut taken = known.clone();
        let mut front = VecDeque::new();
        for (at, _) in hidden {
            let mut around = neighbours(at, frame).into_iter();
            if let Some(root) = around.find(|&next| known.samples()[next]) {
                taken.samples_mut()[at] = true;
                front.push_back((at, root));
            }
        }
        let mut pixels = Vec::new();
        while let Some((at, root)) = front.pop_front() {
            let beside = neighbours(at, frame);
            for &next in &beside {
                if !taken.samples()[next] {
                    taken.samples_mut()[next] = true;
                    front.push_back((next, root));
                }
            }
            pixels.push(HiddenPixel { at, root, beside });
        }
        Self { known, pixels }
    }

    /// Lets the places of a map go on into the hidden.
    fn fill(&self, map: &mut Vector2Planes) {
        let width = self.known.width();
        let column_row = |at: usize| [(at % width) as f32, (at / width) as f32];
        let way = |from: usize, to: usize| {
            let ([x, y], [u, v]) = (column_row(from), column_row(to));
            [u - x, v - y]
        };
        let turns = self.pixels.iter().map(|pixel| {
            let root = pixel.root;
            jacobian_at(map, &self.known, root % width, root / width)
        });
        let turns: Vec<Jacobian> = turns.collect();
        let set = |map: &mut Vector2Planes, at: usize, [x, y]: [f32; 2]| {
            map.x.samples_mut()[at] = x;
            map.y.samples_mut()[at] = y;
        };
        for (pixel, by) in self.pixels.iter().zip(&turns) {
            let root = place_at(map, pixel.root);
            let place = continued(root, by, way(pixel.root, pixel.at));
            set(map, pixel.at, place);
        }
        for _ in 0..RELAXATIONS {
            let relaxed = self.pixels.iter().zip(&turns).map(|(pixel, by)| {
                let mut sum = [0.0; 2];
                for &next in &pixel.beside {
                    let there = place_at(map, next);
                    let here = continued(there, by, way(next, pixel.at));
                    sum = [sum[0] + here[0], sum[1] + here[1]];
                }
                sum.map(|sum| sum / pixel.beside.len() as f32)
            });
            let relaxed: Vec<_> = relaxed.collect();
            for (pixel, place) in self.pixels.iter().zip(relaxed) {
                set(map, pixel.at, place);
            }
        }
    }
}

/// The covered pixels around one, those that share a side first, that are of the same surface.
fn neighbours(at: usize, frame: &Frame) -> Vec<usize> {
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
    let mask = &frame.mask;
    let (width, height) = (mask.width() as isize, mask.height() as isize);
    let (x, y) = (at as isize % width, at as isize / width);
    let of_surface = |&[dx, dy]: &[isize; 2]| {
        let (u, v) = (x + dx, y + dy);
        if !(0..width).contains(&u) || !(0..height).contains(&v) {
            return None;
        }
        let next = (v * width + u) as usize;
        let depth = frame.depth.as_ref().map(Plane::samples);
        let is_one = depth.is_none_or(|depth| is_one_depth(depth[at], depth[next]));
        (mask.plane().samples()[next] && is_one).then_some(next)
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
    /// What is asked of the next map.
    fn asked(&self) -> f64 {
        self.totals.last().copied().unwrap_or(0.0)
    }

    /// The map that serves least.
    fn least_used(&self) -> usize {
        let used = self.totals[..self.totals.len() - 1].iter().enumerate();
        let least = used.min_by(|a, b| a.1.total_cmp(b.1));
        least.map_or(0, |(i, _)| i)
    }

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
