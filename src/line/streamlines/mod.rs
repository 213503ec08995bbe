//! Evenly spaced streamlines: strokes as vector lines, for plotters and for editing.
//!
//! Theory: [JL] traces a line along a field until it comes too close to another, and starts new ones beside existing
//! ones, at the distance wanted. Changes: that distance follows tone, as width over the ink wanted. After all lines are
//! placed the width of each is adapted, within the limits of its pen, to the distance of its neighbours, so that ink
//! matches the tone although lines could not be at the exact distance. Practice: lines go where ink is wanted and stop
//! where none is; they do not cross edges on which the caller wants no ink.

mod carried;
pub(crate) mod cpu;
pub(crate) mod stage;
mod swelling;
mod tool;

use super::contours::polyline::evened;
use super::direction_field::setting::OPEN;
use super::placed::{Placed, Point};
use crate::frame::{Plane, Vector2Planes};
use crate::kernel::cancel::CancelToken;
pub(crate) use crate::plan::drawing::LaidLine;
pub use crate::plan::drawing::Streamline;
use carried::Carried;
use glam::Vec2;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::ops::RangeInclusive;
use swelling::swell;
pub(crate) use tool::Tool;

/// The ink that lines are to cover.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// The share of the paper to ink; lines avoid 0.
    pub(crate) ink: &'a Plane,
    /// Conductance, where lines may run on to the middle of edges, but not over them.
    pub(crate) conductance: Option<&'a Plane>,
    /// Cancels the placement of lines; those placed so far are kept.
    pub(crate) cancel: Option<&'a CancelToken>,
}

impl Wanted<'_> {
    /// Whether placement is cancelled.
    fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(CancelToken::is_cancelled)
    }

    /// The ink at a place on the paper.
    #[inline]
    fn ink_at(&self, at: Vec2) -> Option<f32> {
        self.ink.within(at)
    }

    /// Whether a position is on an edge; false unless lines may run onto edges.
    #[inline]
    fn is_edge(&self, at: Vec2) -> bool {
        let conductance = self.conductance.and_then(|plane| plane.within(at));
        conductance.is_some_and(|open| open <= OPEN)
    }
}

/// The greatest integer that is not above a coordinate.
#[inline]
fn floor(at: f32) -> f32 {
    // Without a call to the maths library, as the processor's own instruction is not there on all.
    let whole = at as i32 as f32;
    if whole > at { whole - 1.0 } else { whole }
}

/// Longest distance, in pixels, that a line continues on an edge.
const MOST_ON_EDGE: f32 = 1.6;

/// Cosine of the most that a line may turn from one point to the next.
const MOST_TURN: f32 = 0.9;

/// Points that there is room for when a line is begun: few are longer.
const USUAL: usize = 64;

/// Points of a line from one to the next that others are started beside.
const SEEDS: usize = 3;

/// Points to either side over which widths change, and from one to the next for which room is looked for: a quarter of
/// that range, so that what lies between is a straight line within it.
const WIDTH_REACH: usize = 6;
const ROOM_EVERY: usize = 3;

/// Lines along `field` (unit directions, y up, equal to their opposites) that cover the share `ink` of the paper,
/// avoiding 0; with the index in each of the point it was begun at. Those carried over are placed `first`, as far as there
/// is room for them, and then extended. The same for the same input.
fn streamlines(
    field: &Vector2Planes,
    wanted: Wanted,
    tool: &Tool,
    first: &[Carried],
) -> (Vec<Streamline>, Vec<i32>) {
    let mut drawer = Drawer {
        field,
        wanted,
        tool: *tool,
        placed: Placed::new([wanted.ink.width(), wanted.ink.height()], tool.cell_side()),
        lines: Vec::new(),
        seeds: Vec::new(),
    };
    first.iter().for_each(|line| drawer.carry(line));
    drawer.lead_on();
    drawer.fill();
    let drawn = std::mem::take(&mut drawer.lines);
    let mut lines: Vec<Streamline> = drawn
        .into_par_iter()
        .enumerate()
        .map(|(number, points)| Streamline {
            widths: drawer.widths(number as u32, &points),
            points,
            crosses: false,
        })
        .collect();
    if tool.swells {
        swell(&mut lines, wanted, tool);
    }
    (lines, drawer.seeds)
}

struct Drawer<'a> {
    field: &'a Vector2Planes,
    wanted: Wanted<'a>,
    tool: Tool,
    placed: Placed,
    lines: Vec<Vec<Vec2>>,
    /// The index in each of the point it was begun at.
    seeds: Vec<i32>,
}

impl Drawer<'_> {
    /// Starts lines wherever there is room, in the dark first, each beside earlier ones as long as possible.
    fn fill(&mut self) {
        let every = self.tool.every;
        let (width, height) = (self.wanted.ink.width(), self.wanted.ink.height());
        for &room in self.tool.rooms {
            for level in (0..self.tool.levels).rev() {
                for y in (0..height).step_by(every) {
                    if self.wanted.is_cancelled() {
                        return;
                    }
                    for x in (0..width).step_by(every) {
                        let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                        let ink = self.ink_at(at);
                        if ink.is_some_and(|ink| self.tool.level(ink) == level) {
                            self.start(at, room);
                        }
                    }
                }
            }
        }
    }

    /// A line through a position, if there is room for one, and then all that can be started beside it, beside the
    /// darkest first.
    fn start(&mut self, at: Vec2, room: f32) {
        let Some((first, level)) = self.line(at, room) else {
            return;
        };
        let mut waiting = vec![VecDeque::new(); self.tool.levels];
        waiting[level].push_back(first);
        while let Some(number) = waiting.iter_mut().rev().find_map(VecDeque::pop_front) {
            if self.wanted.is_cancelled() {
                return;
            }
            for i in (0..self.lines[number].len()).step_by(SEEDS) {
                let at = self.lines[number][i];
                let (Some(ink), Some(along)) = (self.ink_at(at), self.direction(at, Vec2::X))
                else {
                    continue;
                };
                let across = self.tool.spacing(ink) * along.perp();
                for seed in [at + across, at - across] {
                    if let Some((line, level)) = self.line(seed, room) {
                        waiting[level].push_back(line);
                    }
                }
            }
        }
    }

    /// The most points of a line to either side of its seed.
    fn half(&self) -> i32 {
        (0.5 * self.tool.longest / self.tool.step) as i32
    }

    /// Extends all lines at both ends, as far as they may go.
    fn lead_on(&mut self) {
        let half = self.half();
        for number in 0..self.lines.len() {
            let behind = self.seeds[number];
            let mut points = std::mem::take(&mut self.lines[number]);
            let (count, last) = (points.len(), points.len() - 1);
            let ahead = last as i32 - behind;
            let line = number as u32;
            let ends = [(last, last - 1), (0, 1)].map(|(end, inner)| {
                let outward = (points[end] - points[inner]).normalize();
                // Where the line was begun it took the direction there, as it does in a drawing made anew.
                let begun = self.direction(points[end], Vec2::X);
                let begun = begun.filter(|_| behind == end as i32);
                let ahead = begun.map_or(outward, |along| along.dot(outward).signum() * along);
                (points[end], ahead)
            });
            let [on, back] = ends;
            self.half_line(&mut points, on, line, 1, ahead + 1..=half);
            let on = points.len() - count;
            points.reverse();
            self.half_line(&mut points, back, line, -1, behind + 1..=half);
            points.reverse();
            self.seeds[number] += (points.len() - count - on) as i32;
            self.lines[number] = points;
        }
    }

    /// Draws a line through `seed`, with `room` of the distance wanted about it: its number, and the level of darkness at
    /// its seed. `None` if it would be too close to another, or too short.
    fn line(&mut self, seed: Vec2, room: f32) -> Option<(usize, usize)> {
        let ink = self.ink_at(seed).filter(|_| !self.wanted.is_edge(seed))?;
        let distance = room * self.tool.spacing(ink);
        // Before the direction, as most seeds are too close to a line.
        if !self.placed.is_free(seed, distance, |_| true) {
            return None;
        }
        let along = self.direction(seed, Vec2::X)?;
        let (number, before) = (self.lines.len() as u32, self.placed.points.len());
        self.placed.add(seed, number, 0);
        let (step, half) = (self.tool.step, self.half());
        let mut points = Vec::with_capacity(USUAL);
        self.half_line(&mut points, (seed, -along), number, -1, 1..=half);
        let behind = points.len();
        points.reverse();
        points.push(seed);
        self.half_line(&mut points, (seed, along), number, 1, 1..=half);
        if step * (points.len() - 1) as f32 >= self.tool.shortest {
            self.lines.push(points);
            self.seeds.push(behind as i32);
            return Some((number as usize, self.tool.level(ink)));
        }
        self.placed.keep(before);
        None
    }

    /// Adds the points from one on, in its direction, up to a number of steps, numbered by `side`, until the line may go no
    /// farther.
    fn half_line(
        &mut self,
        points: &mut Vec<Vec2>,
        (mut at, mut ahead): (Vec2, Vec2),
        line: u32,
        side: i32,
        steps: RangeInclusive<i32>,
    ) {
        let length = self.tool.step;
        let there = points.iter().rev();
        let there = there.take_while(|&&at| self.wanted.is_edge(at));
        let mut on_edge = there.count() as f32 * length;
        for step in steps {
            let middle = self.direction(at + 0.5 * length * ahead, ahead);
            let Some(along) = middle.filter(|along| along.dot(ahead) > MOST_TURN) else {
                break;
            };
            let next = at + length * along;
            let Some(ink) = self.ink_at(next) else {
                break;
            };
            on_edge = match self.wanted.is_edge(next) {
                true => on_edge + length,
                false if on_edge > 0.0 => break,
                false => 0.0,
            };
            if on_edge > MOST_ON_EDGE {
                break;
            }
            let index = side * step;
            let distance = self.tool.least_distance(ink);
            // Its own points behind it are near, but not in its way.
            let behind = (2.0 * distance / length) as i32 + 2;
            let others = |p: &Point| p.line != line || (p.index - index).abs() > behind;
            if !self.placed.is_free(next, distance, others) {
                break;
            }
            self.placed.add(next, line, index);
            points.push(next);
            (at, ahead) = (next, along);
        }
    }

    /// The ink wanted at a place, if it can be drawn.
    #[inline]
    fn ink_at(&self, at: Vec2) -> Option<f32> {
        let ink = self.wanted.ink_at(at)?;
        (ink >= self.tool.least_ink).then_some(ink.min(1.0))
    }

    /// The direction at a position, rows down, interpolated from the surrounding inked pixels; of the two opposites the
    /// one that continues `ahead`.
    fn direction(&self, at: Vec2, ahead: Vec2) -> Option<Vec2> {
        self.ink_at(at)?;
        let corner = (at - 0.5).map(floor);
        let share = at - 0.5 - corner;
        let ink = self.wanted.ink;
        let (inks, field) = (ink.samples(), self.field);
        let (tx, ty) = (field.x.samples(), field.y.samples());
        let (left, top) = (corner.x as i32, corner.y as i32);
        let across = [1.0 - share.x, 1.0 - (1.0 - share.x)];
        let down = [1.0 - share.y, 1.0 - (1.0 - share.y)];
        let mut sum = Vec2::ZERO;
        // Beyond the paper, numbers less than 0 become large ones.
        for (row, down) in [0, 1].into_iter().zip(down) {
            let y = (top + row) as usize;
            if y >= ink.height() {
                continue;
            }
            for (column, across) in [0, 1].into_iter().zip(across) {
                let x = (left + column) as usize;
                if x >= ink.width() {
                    continue;
                }
                let i = y * ink.width() + x;
                let is_inked = inks[i] >= self.tool.least_ink;
                if !is_inked {
                    continue;
                }
                let t = Vec2::new(tx[i], -ty[i]);
                let weight = across * down;
                let weight = if t.dot(ahead) < 0.0 { -weight } else { weight };
                sum += weight * t;
            }
        }
        sum.try_normalize()
    }

    /// The widths that cover the ink wanted between a line's neighbours.
    fn widths(&self, line: u32, points: &[Vec2]) -> Vec<f32> {
        let [thinnest, thickest] = self.tool.widths;
        let last = points.len() - 1;
        let inks: Vec<f32> = points
            .iter()
            .map(|&at| self.ink_at(at).unwrap_or(0.0))
            .collect();
        // Half of the distance between the neighbours on both sides.
        let room = |i: usize| {
            let along = points[(i + 1).min(last)] - points[i.saturating_sub(1)];
            let spacing = self.tool.spacing(inks[i].max(self.tool.least_ink));
            let [left, right] = self.placed.room(points[i], along, spacing, line);
            0.5 * (left + right)
        };
        let mut wanted = Vec::with_capacity(points.len());
        let mut before = room(0);
        for from in (0..last).step_by(ROOM_EVERY) {
            let count = ROOM_EVERY.min(last - from);
            let after = room(from + count);
            for (i, ink) in inks[from..from + count].iter().enumerate() {
                wanted.push(ink * (before + (after - before) * (i as f32 / count as f32)));
            }
            before = after;
        }
        wanted.push(inks[last] * before);
        let even = evened(&wanted, false, WIDTH_REACH);
        even.iter().map(|w| w.clamp(thinnest, thickest)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pen() -> Tool {
        Tool::pen(1.4, 0.5, 20.0, 400.0)
    }

    fn burin() -> Tool {
        Tool::burin([0.35, 5.5], 5.0, 400.0)
    }

    /// Directions along circles around a place far below.
    fn bent(width: usize, height: usize) -> Vector2Planes {
        let direction = |x: usize, y: usize| {
            let away = Vec2::new(x as f32 - 130.0, 700.0 - y as f32);
            away.perp().normalize()
        };
        Vector2Planes {
            x: Plane::from_fn(width, height, |x, y| direction(x, y).x),
            y: Plane::from_fn(width, height, |x, y| direction(x, y).y),
        }
    }

    fn everywhere(ink: &Plane) -> Wanted<'_> {
        Wanted {
            ink,
            conductance: None,
            cancel: None,
        }
    }

    /// Area of lines over that of the paper.
    fn ink_of(lines: &[Streamline], paper: f32) -> f32 {
        let area = |line: &Streamline| {
            let pieces = line.points.windows(2).zip(line.widths.windows(2));
            pieces
                .map(|(p, w)| p[0].distance(p[1]) * 0.5 * (w[0] + w[1]))
                .sum::<f32>()
        };
        lines.iter().map(area).sum::<f32>() / paper
    }

    #[test]
    fn lines_cover_the_ink_that_is_wanted() {
        for ink in [0.1, 0.25, 0.5, 0.75] {
            let lines = streamlines(
                &bent(300, 300),
                everywhere(&Plane::filled(300, 300, ink)),
                &pen(),
                &[],
            )
            .0;
            let drawn = ink_of(&lines, 300.0 * 300.0);
            assert!((drawn - ink).abs() < 0.03, "{ink} drawn as {drawn}");
        }
    }

    #[test]
    fn engraved_lines_cover_the_ink_that_is_wanted_and_run_to_points() {
        for ink in [0.05, 0.1, 0.25, 0.5, 0.75] {
            let paper = Plane::filled(300, 300, ink);
            let lines = streamlines(&bent(300, 300), everywhere(&paper), &burin(), &[]).0;
            let drawn = ink_of(&lines, 300.0 * 300.0);
            assert!((drawn - ink).abs() < 0.03, "{ink} drawn as {drawn}");
            for line in &lines {
                let widest = line.widths.iter().fold(0.0_f32, |a, &b| a.max(b));
                assert!(line.widths[0] <= widest && widest <= 5.5);
            }
        }
    }

    #[test]
    fn lines_keep_their_distance_and_their_direction() {
        let field = bent(300, 300);
        let lines = streamlines(
            &field,
            everywhere(&Plane::filled(300, 300, 0.3)),
            &pen(),
            &[],
        )
        .0;
        let least = pen().least_distance(0.3);
        for (i, line) in lines.iter().enumerate() {
            for pair in line.points.windows(2) {
                let along = (pair[1] - pair[0]).normalize();
                let (x, y) = (pair[0].x as usize, pair[0].y as usize);
                let t = Vec2::new(field.x.at(x, y), -field.y.at(x, y));
                // The middle of a step is at most 1.2 pixels from the centre of the pixel it starts in, and 400 or more
                // from the centre that the field circles around.
                assert!(along.perp_dot(t).abs() < 1.2 / 400.0, "{along} along {t}");
            }
            let others = lines[i + 1..].iter().flat_map(|other| &other.points);
            for other in others {
                let near = line.points.iter().map(|p| p.distance(*other));
                let near = near.fold(f32::INFINITY, f32::min);
                assert!(near > least - 1e-3, "{near}");
            }
        }
    }

    #[test]
    fn lines_stop_where_no_ink_is_wanted() {
        // An edge of one pixel across the lines.
        let ink = Plane::from_fn(300, 300, |x, _| f32::from(u8::from(x != 120)) * 0.4);
        let lines = streamlines(&bent(300, 300), everywhere(&ink), &pen(), &[]).0;
        assert!(lines.len() > 50);
        for line in &lines {
            let left = line.points.iter().filter(|p| p.x < 120.5).count();
            assert!(left == 0 || left == line.points.len());
        }
    }

    #[test]
    fn without_pressure_all_lines_are_of_one_width() {
        let tool = Tool::pen(1.4, 0.0, 20.0, 400.0);
        let ink = Plane::from_fn(200, 200, |x, _| x as f32 / 200.0);
        let lines = streamlines(&bent(200, 200), everywhere(&ink), &tool, &[]).0;
        assert!(lines.iter().flat_map(|l| &l.widths).all(|&w| w == 1.4));
        // Their number makes the tone: for ink of 0.05 to 0.5 on average a quarter and a bit, for 0.5 to 0.95 the rest.
        let within = |from: f32, to: f32| {
            let points = lines.iter().flat_map(|l| &l.points);
            let count = points.filter(|p| (from..to).contains(&p.x)).count();
            count as f32 * tool.step * 1.4 / ((to - from) * 200.0)
        };
        assert!(
            (within(20.0, 100.0) - 0.3).abs() < 0.12,
            "{}",
            within(20.0, 100.0)
        );
        assert!(
            (within(100.0, 180.0) - 0.7).abs() < 0.2,
            "{}",
            within(100.0, 180.0)
        );
    }

    #[test]
    fn no_more_lines_are_started_once_they_are_cancelled() {
        let (token, ink) = (CancelToken::new(), Plane::filled(100, 100, 0.4));
        let laid = || {
            let wanted = Wanted {
                cancel: Some(&token),
                ..everywhere(&ink)
            };
            streamlines(&bent(100, 100), wanted, &pen(), &[]).0.len()
        };
        assert!(laid() > 5);
        token.cancel();
        assert_eq!(laid(), 0);
    }

    #[test]
    fn nothing_gives_no_lines_and_no_number_none_either() {
        for (width, height) in [(1, 1), (1, 40), (40, 1), (40, 40)] {
            for ink in [0.0, f32::NAN, -1.0] {
                let ink = Plane::filled(width, height, ink);
                assert!(
                    streamlines(&bent(width, height), everywhere(&ink), &pen(), &[])
                        .0
                        .is_empty()
                );
            }
            let none = Vector2Planes {
                x: Plane::filled(width, height, 0.0),
                y: Plane::filled(width, height, 0.0),
            };
            let ink = Plane::filled(width, height, 1.0);
            assert!(
                streamlines(&none, everywhere(&ink), &pen(), &[])
                    .0
                    .is_empty()
            );
        }
    }
}
