//! Positions in the fixed stroke texture, carried from frame to frame.
//!
//! Each map of positions was laid over the whole picture at once and has moved with the surface since. A pixel is drawn
//! by the oldest map that is sound there; the remaining share goes to younger ones in turn, and the last of it to the
//! next one, which stays fixed in the picture until enough is needed of it: then it is born, and moves too. So a
//! surface that merely shifts or rotates in the picture is never laid anew, no stroke is drawn far from its size, and
//! maps take over smoothly in time and in the picture.

use crate::frame::memory::Memory;
use crate::frame::{Frame, Mask, Plane, Vector2Planes};
use crate::line::texture_coordinates::hidden::Hidden;
use crate::line::texture_coordinates::origin;
use crate::line::texture_coordinates::places::{MovingSurface, PlaceMap};
use crate::line::texture_coordinates::shares::Weighed;
use crate::line::texture_coordinates::sheet::PlacedTexture;
use crate::line::texture_coordinates::step::FrameStep;
pub(crate) use crate::plan::drawing::{SequenceInputs, TextureCoordinates};

/// Most maps kept at once, beside the next one.
const MOST_MAPS: usize = 3;

/// Share of the surface that must need the next map before it is born: on a smaller share, moving and fixed look the
/// same.
const BIRTH: f64 = 0.01;

/// Share of the surface from which the next map cannot wait for an older one to fade.
const URGENT: f64 = 0.1;

/// Frames over which a map fades that has to make room.
const FADE_FRAMES: f32 = 6.0;

impl TextureCoordinates {
    /// Coordinates of a first frame: the texture is placed as in a still picture.
    pub fn new(frame: &Frame) -> Self {
        Self {
            window: frame.data_window,
            mask: frame.mask.clone(),
            depth: frame.depth.clone(),
            motion: None,
            maps: vec![PlaceMap::laid(0, frame)],
            next: None,
            born: 1,
            lines: Vec::new(),
            directions: Vec::new(),
            dots: Vec::new(),
        }
    }

    /// Coordinates of a frame of a sequence.
    pub(crate) fn of(frame: &Frame, sequence: SequenceInputs, memory: &Memory) -> Self {
        match sequence.before.zip(sequence.motion) {
            Some((before, motion)) => before.advanced(frame, motion, memory),
            None => Self::new(frame),
        }
    }

    /// Coordinates of the next frame, whose surface has moved by `motion` since, in pixels, x right, y up.
    fn advanced(&self, frame: &Frame, motion: &Vector2Planes, memory: &Memory) -> Self {
        let step = FrameStep::new(self.window, self.surface(), frame, motion);
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
            lines: Vec::new(),
            directions: Vec::new(),
            dots: Vec::new(),
        };
        next.share_out(frame, motion, memory);
        next
    }

    /// The pixels of `frame` whose surface was fully visible in the previous frame too, by `motion`.
    pub fn seen_before(&self, frame: &Frame, motion: &Vector2Planes) -> Mask {
        let origins = FrameStep::new(self.window, self.surface(), frame, motion).origins();
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

    /// Shares of the maps in the drawing, oldest first, and of the next one: their means over the surface.
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

    /// Gives every map its share, lets the next be born when it is time, and removes old ones.
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
                // It is perfectly sound where it was laid: it takes over the share of the next.
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
            // A map without a share does not become sounder.
            if total > 0.0 {
                map.share = Some(share).filter(|_| !alone);
                served.push(map);
            }
        }
        self.maps = served;
    }
}
