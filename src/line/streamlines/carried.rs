//! Lines of the previous frame: where they are in this one, and as far as there still is room for them.

use super::{Drawer, LaidLine, MOST_ON_EDGE, MOST_TURN, Tool};
use crate::frame::Frame;
use crate::line::carried::Carrier;
use crate::line::placed::Point;
use crate::line::texture_coordinates::cpu::SequenceInputs;
use glam::Vec2;
use rayon::prelude::*;

/// Distances of points, in steps, from which one is put between them, below which one goes, and from which a line is torn.
const FAR: f32 = 1.5;
const NEAR: f32 = 0.5;
const TORN: f32 = 6.0;

/// Smallest distance of lines carried over to others, as a share of that wanted: they stay until tone or perspective makes
/// it clearly less than it is when lines are placed.
const ROOM: f32 = 0.45;

/// Pieces of a line that was cut are at least so many times as long as the shortest line.
const PIECE: f32 = 5.0;

/// A line where it is in this frame, or a piece of it.
pub(super) struct Carried {
    line: LaidLine,
    is_whole: bool,
}

/// Lines of the previous frame, by family, where they are visible in this one.
pub(super) fn carried_lines(
    sequence: Option<SequenceInputs>,
    frame: &Frame,
    tool: &Tool,
) -> Vec<Vec<Carried>> {
    let Some((before, carrier)) = Carrier::of(sequence, frame) else {
        return Vec::new();
    };
    let of_line = |line: &LaidLine| {
        let points = line.points.iter().map(|&at| carrier.carried(at));
        pieces(points, line.seed, tool.step)
    };
    let of_family = |lines: &Vec<LaidLine>| lines.par_iter().flat_map_iter(of_line).collect();
    before.lines.iter().map(of_family).collect()
}

/// The pieces of a line at these points, about a step apart; where there is none it is torn.
fn pieces(points: impl Iterator<Item = Option<Vec2>>, seed: i32, step: f32) -> Vec<Carried> {
    let mut pieces: Vec<LaidLine> = Vec::new();
    let mut is_torn = true;
    let mut tears = 0;
    for (index, point) in (0..).zip(points) {
        let Some(at) = point else {
            tears += 1;
            is_torn = true;
            continue;
        };
        let before = pieces.last_mut().filter(|_| !is_torn);
        let before = before.map(|piece| (piece.points[piece.points.len() - 1], piece));
        match before {
            Some((last, piece)) if last.distance(at) < TORN * step => {
                let steps = last.distance(at) / step;
                if steps > NEAR {
                    let count = if steps > FAR { steps.round() } else { 1.0 };
                    let between = (1..count as usize).map(|i| last.lerp(at, i as f32 / count));
                    piece.points.extend(between);
                    piece.points.push(at);
                }
                if index == seed {
                    piece.seed = piece.points.len() as i32 - 1;
                }
            }
            before => {
                tears += usize::from(before.is_some());
                pieces.push(LaidLine {
                    points: vec![at],
                    seed: seed - index,
                });
            }
        }
        is_torn = false;
    }
    let is_whole = tears == 0;
    let carried = |line| Carried { line, is_whole };
    pieces.into_iter().map(carried).collect()
}

impl Drawer<'_> {
    /// Places what there is room for of a line of the previous frame, but for short pieces.
    pub(super) fn carry(&mut self, carried: &Carried) {
        let (points, seed) = (&carried.line.points, carried.line.seed);
        let mut from = 0;
        while from < points.len() {
            let (line, placed) = (self.lines.len() as u32, self.placed.points.len());
            // Points on an edge up to here.
            let mut on_edge = 0;
            let mut to = from;
            while to < points.len() {
                let is_on_edge = self.wanted.is_edge(points[to]);
                // Off an edge again a line has begun beside it.
                let is_across = !is_on_edge && on_edge > 0 && on_edge < to - from;
                on_edge = if is_on_edge { on_edge + 1 } else { 0 };
                let (index, before) = (to as i32 - seed, points[from..to].last().copied());
                if is_across
                    || self.length(on_edge) > MOST_ON_EDGE
                    || !self.stays(before, points[to], (line, index))
                {
                    break;
                }
                self.placed.add(points[to], line, index);
                to += 1;
            }
            let share = match carried.is_whole && to - from == points.len() {
                true => 1.0,
                false => PIECE,
            };
            let count = (to - from).max(1);
            if count > 1 && self.length(count - 1) >= share * self.tool.shortest {
                self.lines.push(points[from..to].to_vec());
                self.seeds.push(seed - from as i32);
            } else {
                self.placed.keep(placed);
            }
            from += count;
        }
    }

    /// The length of so many steps.
    fn length(&self, steps: usize) -> f32 {
        steps as f32 * self.tool.step
    }

    /// Whether a point of a line may stay: where ink is wanted, along the field from the one before if there is one between
    /// them, and not too close to other lines.
    fn stays(&self, before: Option<Vec2>, at: Vec2, (line, index): (u32, i32)) -> bool {
        let Some(ink) = self.ink_at(at) else {
            return false;
        };
        let is_along = |before: Vec2| {
            let along = (at - before).normalize_or_zero();
            let field = self.direction(before.midpoint(at), along);
            field.is_none_or(|field| field.dot(along) > MOST_TURN)
        };
        if !before.is_none_or(is_along) {
            return false;
        }
        let distance = ROOM * self.tool.spacing(ink);
        let behind = (2.0 * distance / self.tool.step) as i32 + 2;
        let others = |p: &Point| p.line != line || (p.index - index).abs() > behind;
        self.placed.is_free(at, distance, others)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Plane, Vector2Planes};
    use crate::line::streamlines::{Streamline, Wanted, streamlines};

    #[test]
    fn a_line_that_is_torn_goes_on_in_pieces_of_its_step() {
        // Points of one step drawn out to two, the eighth hidden: two pieces of 13 and of 15 points with one between each
        // two, begun at point 10, which is the fifth of the second piece.
        let points = (0..16).map(|i| (i != 7).then(|| Vec2::new(2.0 * i as f32, 3.0)));
        let carried = pieces(points, 10, 1.0);
        let found = carried.iter().map(|piece| &piece.line);
        let counts: Vec<_> = found.map(|line| (line.points.len(), line.seed)).collect();
        assert_eq!(counts, [(13, 10), (15, 4)]);
        assert!(carried.iter().all(|piece| !piece.is_whole));
        let steps = carried[1].line.points.windows(2);
        assert!(
            steps
                .into_iter()
                .all(|pair| pair[0].distance(pair[1]) == 1.0)
        );
        // Drawn together to a quarter, every third point is more than half a step from the last one kept.
        let points = (0..16).map(|i| Some(Vec2::new(0.25 * i as f32, 3.0)));
        let carried = pieces(points, 3, 1.0);
        assert_eq!(carried[0].line.points.len(), 6);
        assert_eq!((carried[0].line.seed, carried[0].is_whole), (1, true));
    }

    /// Directions along circles around a place far below, shifted, and ink.
    fn paper(shift: Vec2) -> (Vector2Planes, Plane) {
        let direction = move |x: usize, y: usize| {
            let away = Vec2::new(x as f32 - 130.0, 700.0 - y as f32);
            (away + shift * Vec2::new(-1.0, 1.0)).perp().normalize()
        };
        let field = Vector2Planes {
            x: Plane::from_fn(300, 300, |x, y| direction(x, y).x),
            y: Plane::from_fn(300, 300, |x, y| direction(x, y).y),
        };
        (field, Plane::filled(300, 300, 0.3))
    }

    fn moved(lines: Vec<Streamline>, seeds: &[i32], shift: Vec2, tool: &Tool) -> Vec<Carried> {
        let carried = lines.into_iter().zip(seeds).flat_map(|(line, &seed)| {
            let points = line.points.into_iter().map(|at| Some(at + shift));
            pieces(points, seed, tool.step)
        });
        carried.collect()
    }

    #[test]
    fn a_still_drawing_stays_as_it_is_and_one_that_is_moved_keeps_its_lines() {
        // An edge of nine pixels, which lines run on to by no more than before.
        let conductance = Plane::from_fn(300, 300, |x, _| f32::from(u8::from(x.abs_diff(120) > 4)));
        let pen = Tool::pen(1.4, 0.5, 20.0, 400.0);
        for tool in [pen, Tool::burin([0.35, 5.5], 5.0, 400.0)] {
            let draw = |shift: Vec2, first: &[Carried]| {
                let (field, ink) = paper(shift);
                let wanted = Wanted {
                    ink: &ink,
                    conductance: (shift == Vec2::ZERO).then_some(&conductance),
                    cancel: None,
                };
                streamlines(&field, wanted, &tool, first)
            };
            let (before, seeds) = draw(Vec2::ZERO, &[]);
            let still = moved(before.clone(), &seeds, Vec2::ZERO, &tool);
            assert_eq!(draw(Vec2::ZERO, &still), (before.clone(), seeds.clone()));
            // Moved, lines have the room they had: all stay but those in strips of 7 and of 5 pixels that leave, 4 %.
            let shift = Vec2::new(7.0, 5.0);
            let first = moved(before, &seeds, shift, &tool);
            let middle = |points: &[Vec2]| points[points.len() / 2];
            let middles: Vec<Vec2> = first.iter().map(|c| middle(&c.line.points)).collect();
            let stay = |lines: &[Streamline]| {
                let points: Vec<Vec2> = lines.iter().flat_map(|line| line.points.clone()).collect();
                middles.iter().filter(|at| points.contains(at)).count()
            };
            let [kept, anew] = [&first[..], &[]].map(|first| stay(&draw(shift, first).0));
            assert!(
                10 * kept >= 9 * middles.len(),
                "{kept} of {}",
                middles.len()
            );
            assert!(anew < kept / 2, "{anew} of {kept}");
        }
    }

    #[test]
    fn a_still_drawing_stays_where_directions_turn_at_once() {
        // Squares of 12 pixels, of directions 65 degrees apart: many lines begin and end at their borders, and a line that
        // was begun where directions are mixed took the one there, not that of the step before.
        let angle = |x: usize, y: usize| [10.0_f32, 75.0][(x / 12 + y / 12) % 2].to_radians();
        let field = Vector2Planes {
            x: Plane::from_fn(300, 300, |x, y| angle(x, y).cos()),
            y: Plane::from_fn(300, 300, |x, y| angle(x, y).sin()),
        };
        let ink = Plane::from_fn(300, 300, |x, y| [0.3, 0.6, 0.0][(x / 7 + y / 9) % 3]);
        let wanted = Wanted {
            ink: &ink,
            conductance: None,
            cancel: None,
        };
        let pen = Tool::pen(1.4, 0.5, 20.0, 400.0);
        for tool in [pen, Tool::burin([0.12, 1.9], 1.75, 400.0)] {
            let (before, seeds) = streamlines(&field, wanted, &tool, &[]);
            let still = moved(before.clone(), &seeds, Vec2::ZERO, &tool);
            assert_eq!(streamlines(&field, wanted, &tool, &still), (before, seeds));
        }
    }
}
