//! Dots of a sequence: those of the previous frame stay on the surface. Where tone or perspective has brought them too
//! close some go, and where it leaves room others come, by shrinking and growing over a few frames.

use super::LaidDot;
use super::spread::{DotDensity, diffused, spaced};
use crate::frame::Mask;
use crate::frame::memory::Memory;
use crate::line::placed::Placed;
use glam::Vec2;

/// Frames over which a dot grows to its size, or shrinks to nothing.
const FADE_FRAMES: f32 = 4.0;

/// Smallest distance of a dot to others, as a share of that wanted, at which it stays. The distances that `spaced`
/// leaves between dots are hardly ever less.
const ROOM_TO_STAY: f32 = 0.6;

/// Smallest distance at which a dot comes: dots at random no closer than this, with no room for another, are as many as
/// wanted, as their discs of half this radius fill 0.547 of the paper (random sequential adsorption):
/// sqrt(4/pi * 0.547) = 0.835.
const ROOM_TO_COME: f32 = 0.835;

/// Numbers of dots tried, as multiples of those wanted.
const TRIES: u64 = 8;

/// The dots of a frame with these ones from the previous frame, where they are now. A dot that comes on a surface that
/// was not seen before has its full size.
pub(super) fn settled(
    carried: &[LaidDot],
    field: &DotDensity,
    was_seen: &Mask,
    seed: u64,
    memory: &Memory,
) -> Vec<LaidDot> {
    let mut placed = Placed::new(field.size(), field.cell_side());
    let mut has_room = |at: Vec2, room: f32| {
        let apart = field.apart(at);
        let is_free = apart.is_some_and(|apart| placed.is_free(at, room * apart, |_| true));
        if is_free {
            placed.add(at, 0, 0);
        }
        is_free
    };
    let grown = |dot: &LaidDot, by: f32| LaidDot {
        share: (dot.share + by / FADE_FRAMES).min(1.0),
        is_going: by < 0.0,
        ..*dot
    };
    let (mut dots, mut going) = (Vec::with_capacity(carried.len()), Vec::new());
    let (was_going, was_staying): (Vec<&LaidDot>, Vec<&LaidDot>) =
        carried.iter().partition(|dot| dot.is_going);
    let staying = was_staying.into_iter().map(|dot| (dot, ROOM_TO_STAY));
    let returning = was_going.into_iter().map(|dot| (dot, ROOM_TO_COME));
    for (dot, room) in staying.chain(returning) {
        match has_room(dot.at, room) {
            true => dots.push(grown(dot, 1.0)),
            false => going.push(grown(dot, -1.0)),
        }
    }
    let mut places: Vec<Vec2> = dots.iter().map(|dot| dot.at).collect();
    let count = dots.len() as u64;
    for i in 0..TRIES {
        // Other places in every frame, or what comes into view would show the same ones again and again.
        let tried = diffused(field, seed ^ (count << 3 | i), memory);
        places.extend(tried.into_iter().filter(|&at| has_room(at, ROOM_TO_COME)));
    }
    let places = spaced(places, dots.len(), field, memory);
    let coming = places[dots.len()..].iter().map(|&at| {
        let share = if was_seen.plane().nearest(at) {
            FADE_FRAMES.recip()
        } else {
            1.0
        };
        LaidDot {
            at,
            share,
            is_going: false,
        }
    });
    dots.extend(coming);
    dots.extend(going.into_iter().filter(|dot| dot.share > 0.0));
    dots
}
