//! The places in which the texture of strokes lies still, carried from frame to frame.
//!
//! Each map of places was laid over the whole picture at once and has moved with the surface since. A pixel is
//! drawn by the oldest map that is sound there; what that leaves goes to younger ones in turn, and what all
//! leave to the one that comes next, which lies still in the picture until enough is asked of it: then it is
//! born, and moves too. So no surface that merely shifts or turns in the picture is ever laid anew, no stroke
//! is drawn far from its size, and where maps take turns, they do so smoothly over time and picture.

use crate::engine::cpu::memory::Memory;
use crate::frame::{Frame, Mask, Plane, Vector2Planes, Window};
use crate::line::streamlines::Seed;
use crate::line::texture_coordinates::hidden::Hidden;
use crate::line::texture_coordinates::origin;
use crate::line::texture_coordinates::places::{MovingSurface, PlaceMap};
use crate::line::texture_coordinates::shares::Weighed;
use crate::line::texture_coordinates::sheet::PlacedTexture;
use crate::line::texture_coordinates::step::Step;

/// Maps that are kept at once, beside the next.
const MOST_MAPS: usize = 3;

/// Share of the surface that has to ask for the next map before it is born: of less, moving or not is not
/// seen.
const BIRTH: f64 = 0.01;

/// Share of the surface from which on that cannot wait for an older map to fade.
const URGENT: f64 = 0.1;

/// Frames over which a map fades that has to make room.
const FADE_FRAMES: f32 = 6.0;

/// State that a frame of a sequence takes from the previous one; the first has none.
#[derive(Debug, Clone, Copy, Default)]
pub struct SequenceInputs<'a> {
    /// Where the texture of strokes lay.
    pub before: Option<&'a TextureCoordinates>,
    /// How far, in pixels, the surface seen at each pixel has come since: x right, y up.
    pub motion: Option<&'a Vector2Planes>,
}

/// Where the texture of strokes lies still, for every pixel of a frame: what a sequence hands on from one
/// frame to the next.
#[derive(Debug, Clone)]
pub struct TextureCoordinates {
    pub(crate) window: Window,
    pub(crate) mask: Mask,
    pub(crate) depth: Option<Plane>,
    /// Where there is no depth: how the frame had moved, from the second on.
    pub(crate) motion: Option<Vector2Planes>,
    /// Oldest first.
    pub(crate) maps: Vec<PlaceMap>,
    /// Share of the map that comes next, where any is asked of it.
    pub(crate) next: Option<Plane>,
    /// How many maps were born.
    pub(crate) born: u32,
    /// Where strokes that are laid one by one were started, family by family, in pixels of the window.
    pub(crate) seeds: Vec<Vec<Seed>>,
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
            seeds: Vec::new(),
        }
    }

    /// Those of a frame of a sequence.
    pub(crate) fn of(frame: &Frame, sequence: SequenceInputs, memory: &Memory) -> Self {
        match sequence.before.zip(sequence.motion) {
            Some((before, motion)) => before.advanced(frame, motion, memory),
            None => Self::new(frame),
        }
    }

    /// Those of the next frame, whose surface has moved by `motion` since, in pixels, x right, y up.
    fn advanced(&self, frame: &Frame, motion: &Vector2Planes, memory: &Memory) -> Self {
        let step = Step::new(self.window, self.surface(), frame, motion);
        let origins = step.origins();
        let hidden = Hidden::find(&origins, MovingSurface::of(frame, Some(motion)));
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
            seeds: Vec::new(),
        };
        next.share_out(frame, motion, memory);
        next
    }

    /// The pixels of `frame` whose surface was wholly seen in the frame before too, where `motion` comes from.
    pub fn seen_before(&self, frame: &Frame, motion: &Vector2Planes) -> Mask {
        let origins = Step::new(self.window, self.surface(), frame, motion).origins();
        Mask::new(origins.map(|origin| origin.whole))
    }

    /// The surface that the maps are of.
    pub(crate) fn surface(&self) -> MovingSurface<'_> {
        MovingSurface {
            covered: self.mask.plane(),
            depth: self.depth.as_ref(),
            motion: self.motion.as_ref(),
        }
    }

    /// The surface of the drawing.
    pub(crate) fn sheets(&self) -> Vec<PlacedTexture<'_>> {
        let surface = self.surface();
        let moving = self.maps.iter().map(|map| PlacedTexture {
            place: Some((&map.place, surface)),
            origin: [0.0; 2],
            share: map.share.as_ref(),
        });
        let next = self.next.as_ref().map(|share| PlacedTexture {
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
    fn share_out(&mut self, frame: &Frame, motion: &Vector2Planes, memory: &Memory) {
        let covered = self.mask.count() as f64;
        let surface = MovingSurface::of(frame, Some(motion));
        let mut weighed = Weighed::of(&self.maps, &self.mask, &surface, memory);
        let asked = weighed.asked();
        if asked > URGENT * covered && self.maps.len() == MOST_MAPS {
            self.maps.remove(weighed.least_used());
            weighed = Weighed::of(&self.maps, &self.mask, &surface, memory);
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
