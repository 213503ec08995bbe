//! Evenly spaced streamlines: strokes as lines, for plotters and for drawings that are to be edited.
//!
//! Theory: [JL] traces a line along a field until it comes too near another, and starts new ones beside those
//! there are, at the distance wanted. Changes: that distance follows tone, a width over the ink wanted. When all
//! lines are laid each is made as wide, within what its pen can do, as the room to its neighbours asks for, so
//! that ink covers what tone says though lines could not lie at the very distance. Practice: lines go where
//! ink is wanted and stop where none is; nothing crosses an edge on which the caller wants none.

pub(crate) mod cpu;
pub(crate) mod stage;

use super::contours::polyline::evened;
use crate::frame::{Plane, Vector2Planes};
use crate::params::Stroke;
use glam::Vec2;
use std::collections::VecDeque;

/// A stroke as a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Streamline {
    /// The points it passes, in pixels from the upper left corner of the data window, y down.
    pub points: Vec<Vec2>,
    /// Its width at each point, in pixels.
    pub widths: Vec<f32>,
}

/// What lines are drawn with, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nib {
    /// Width in a middle tone.
    pub width: f32,
    /// Share of that, 0..1, by which it grows and shrinks with tone.
    pub pressure: f32,
    /// Distance between lines in the lightest tone that is drawn.
    pub widest_spacing: f32,
    /// Length at which a line ends.
    pub longest: f32,
}

/// How near another a line may come, as a share of the distance wanted. [JL] finds 0.5 to 0.9: more make more and
/// shorter lines.
const TEST: f32 = 0.6;

/// Distances between lines of one width that leave no paper between them: closer ones only cost time.
const TOUCHING: f32 = 1.1;

/// Least distance between lines, in pixels: the picture tells nothing finer.
const CLOSEST: f32 = 1.0;

/// Cosine of the most that a line may turn from one point to the next.
const MOST_TURN: f32 = 0.9;

/// Lines shorter than so many of their widths are left out.
const SHORTEST: f32 = 4.0;

/// Points of a line from one to the next that others are started beside.
const SEEDS: usize = 3;

/// Spots to either side over which widths change.
const WIDTH_REACH: usize = 6;

/// Distance between lines in the lightest tone that is drawn over that in a light tone.
const WIDEST: f32 = 4.0;

impl Nib {
    /// What draws such strokes.
    pub(crate) fn of(stroke: &Stroke) -> Self {
        Self {
            width: stroke.width_px,
            pressure: stroke.pressure,
            widest_spacing: WIDEST * stroke.spacing_px,
            longest: stroke.length_px,
        }
    }

    /// The distance between lines that cover a share `ink` of the paper.
    fn spacing(&self, ink: f32) -> f32 {
        // Thin lines in light tones, thick ones in dark tones.
        let width = self.width * (1.0 + self.pressure * (2.0 * ink - 1.0));
        let least = (TOUCHING * width).max(CLOSEST);
        (width / ink).clamp(least, self.widest_spacing.max(least))
    }

    /// How far apart points along a line are, so that none passes between them.
    fn step(&self) -> f32 {
        let least = (TOUCHING * self.widths()[1]).max(CLOSEST);
        (0.8 * TEST * least).min(1.0)
    }

    /// The widths that it can draw.
    fn widths(&self) -> [f32; 2] {
        [1.0 - self.pressure, 1.0 + self.pressure].map(|share| share * self.width)
    }

    /// The least ink that is drawn: of the thinnest lines at the widest distance.
    fn least_ink(&self) -> f32 {
        (self.widths()[0].max(0.2 * self.width) / self.widest_spacing).min(0.5)
    }
}

/// Lines along `field` (unit directions, y up, the same as their opposites) that cover the share `ink` of the
/// paper; where that is 0 none goes. The same for the same input.
pub(crate) fn streamlines(field: &Vector2Planes, ink: &Plane, nib: &Nib) -> Vec<Streamline> {
    let mut drawer = Drawer {
        field,
        ink,
        nib: *nib,
        placed: Placed::new([ink.width(), ink.height()], 0.5 * nib.widest_spacing),
        lines: Vec::new(),
    };
    drawer.fill();
    let Drawer { placed, lines, .. } = &drawer;
    let drawn = lines.iter().enumerate();
    drawn
        .map(|(number, points)| Streamline {
            widths: drawer.widths(number as u32, points, placed),
            points: points.clone(),
        })
        .collect()
}

struct Drawer<'a> {
    field: &'a Vector2Planes,
    ink: &'a Plane,
    nib: Nib,
    placed: Placed,
    lines: Vec<Vec<Vec2>>,
}

impl Drawer<'_> {
    /// Starts lines wherever there is room, each beside those before it as long as that can be.
    fn fill(&mut self) {
        let every = (0.5 * self.nib.width).max(2.0) as usize;
        for y in (0..self.ink.height()).step_by(every) {
            for x in (0..self.ink.width()).step_by(every) {
                self.start(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
            }
        }
    }

    /// A line through a place, if there is room for one, and then all that can be started beside it.
    fn start(&mut self, at: Vec2) {
        let mut waiting: VecDeque<usize> = self.line(at).into_iter().collect();
        while let Some(number) = waiting.pop_front() {
            for i in (0..self.lines[number].len()).step_by(SEEDS) {
                let at = self.lines[number][i];
                let (Some(ink), Some(along)) = (self.ink_at(at), self.direction(at, Vec2::X))
                else {
                    continue;
                };
                let across = self.nib.spacing(ink) * along.perp();
                for seed in [at + across, at - across] {
                    waiting.extend(self.line(seed));
                }
            }
        }
    }

    /// Draws the line through `seed` and gives its number; `None` where it would be too near another, or short.
    fn line(&mut self, seed: Vec2) -> Option<usize> {
        let ink = self.ink_at(seed)?;
        let along = self.direction(seed, Vec2::X)?;
        // Seeds lie at the very distance, up to rounding.
        let distance = 0.99 * self.nib.spacing(ink);
        if !self.placed.is_free(seed, distance, |_| true) {
            return None;
        }
        let number = self.lines.len() as u32;
        self.placed.add(seed, number, 0);
        let step = self.nib.step();
        let half = (0.5 * self.nib.longest / step) as i32;
        let mut points = self.half_line(seed, -along, number, -1, half);
        points.reverse();
        points.push(seed);
        points.extend(self.half_line(seed, along, number, 1, half));
        if step * (points.len() - 1) as f32 >= SHORTEST * self.nib.width {
            self.lines.push(points);
            return Some(number as usize);
        }
        for &at in points.iter().rev() {
            self.placed.remove(at, number);
        }
        None
    }

    /// The points from `from` on, numbered by `side`, until the line may go no farther.
    fn half_line(
        &mut self,
        from: Vec2,
        mut ahead: Vec2,
        line: u32,
        side: i32,
        most: i32,
    ) -> Vec<Vec2> {
        let mut points = Vec::new();
        let mut at = from;
        let length = self.nib.step();
        for step in 1..=most {
            let middle = self.direction(at + 0.5 * length * ahead, ahead);
            let Some(along) = middle.filter(|along| along.dot(ahead) > MOST_TURN) else {
                break;
            };
            let next = at + length * along;
            let Some(ink) = self.ink_at(next) else {
                break;
            };
            let index = side * step;
            let distance = TEST * self.nib.spacing(ink);
            // Points of its own behind it are near, and in no way.
            let behind = (2.0 * distance / length) as i32 + 2;
            let others = |p: &Point| p.line != line || (p.index - index).abs() > behind;
            if !self.placed.is_free(next, distance, others) {
                break;
            }
            self.placed.add(next, line, index);
            points.push(next);
            (at, ahead) = (next, along);
        }
        points
    }

    /// The ink wanted at a place, if it can be drawn.
    fn ink_at(&self, at: Vec2) -> Option<f32> {
        let inside = at.x >= 0.0 && at.y >= 0.0;
        let (x, y) = (at.x as usize, at.y as usize);
        let inside = inside && x < self.ink.width() && y < self.ink.height();
        let ink = inside.then(|| self.ink.at(x, y))?;
        (ink >= self.nib.least_ink()).then_some(ink.min(1.0))
    }

    /// The direction at a place, rows down, between those of the pixels around it that take ink; of the two the one
    /// that goes on from `ahead`.
    fn direction(&self, at: Vec2, ahead: Vec2) -> Option<Vec2> {
        self.ink_at(at)?;
        let corner = (at - 0.5).floor();
        let share = at - 0.5 - corner;
        let mut sum = Vec2::ZERO;
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let pixel = corner + Vec2::new(dx + 0.5, dy + 0.5);
            if self.ink_at(pixel).is_none() {
                continue;
            }
            let (x, y) = (pixel.x as usize, pixel.y as usize);
            let t = Vec2::new(self.field.x.at(x, y), -self.field.y.at(x, y));
            let weight = (1.0 - (dx - share.x).abs()) * (1.0 - (dy - share.y).abs());
            sum += if t.dot(ahead) < 0.0 {
                -weight * t
            } else {
                weight * t
            };
        }
        sum.try_normalize()
    }

    /// The widths that cover the ink wanted between a line's neighbours.
    fn widths(&self, line: u32, points: &[Vec2], placed: &Placed) -> Vec<f32> {
        let [thinnest, thickest] = self.nib.widths();
        let wanted: Vec<f32> = (0..points.len())
            .map(|i| {
                let at = points[i];
                let ink = self.ink_at(at).unwrap_or(0.0);
                let along = points[(i + 1).min(points.len() - 1)] - points[i.saturating_sub(1)];
                let spacing = self.nib.spacing(ink.max(self.nib.least_ink()));
                let [left, right] = placed.room(at, along, spacing, line);
                ink * 0.5 * (left + right)
            })
            .collect();
        let even = evened(&wanted, false, WIDTH_REACH);
        even.iter().map(|w| w.clamp(thinnest, thickest)).collect()
    }
}

/// A point of a line.
#[derive(Debug, Clone, Copy)]
struct Point {
    at: Vec2,
    line: u32,
    /// Where in its line, counted from the seed.
    index: i32,
}

/// The points laid so far, by the cell that they lie in.
struct Placed {
    cells: Vec<Vec<Point>>,
    size: [usize; 2],
    side: f32,
}

/// Least side of a cell, in pixels.
const LEAST_SIDE: f32 = 2.0;

impl Placed {
    fn new(size: [usize; 2], side: f32) -> Self {
        let side = side.max(LEAST_SIDE);
        let size = size.map(|length| (length as f32 / side) as usize + 1);
        Self {
            cells: vec![Vec::new(); size[0] * size[1]],
            size,
            side,
        }
    }

    fn cell(&self, at: Vec2) -> [usize; 2] {
        let cell = |at: f32, count: usize| ((at / self.side).max(0.0) as usize).min(count - 1);
        [cell(at.x, self.size[0]), cell(at.y, self.size[1])]
    }

    fn add(&mut self, at: Vec2, line: u32, index: i32) {
        let [x, y] = self.cell(at);
        self.cells[y * self.size[0] + x].push(Point { at, line, index });
    }

    fn remove(&mut self, at: Vec2, line: u32) {
        let [x, y] = self.cell(at);
        self.cells[y * self.size[0] + x].retain(|p| p.line != line || p.at != at);
    }

    /// The points within some distance.
    fn around(&self, at: Vec2, distance: f32) -> impl Iterator<Item = &Point> {
        let [first, last] = [-distance, distance].map(|d| self.cell(at + d));
        let rows = (first[1]..=last[1]).map(move |y| {
            let row = y * self.size[0];
            &self.cells[row + first[0]..=row + last[0]]
        });
        let square = distance * distance;
        let near = rows.flatten().flatten();
        near.filter(move |p| p.at.distance_squared(at) < square)
    }

    /// Whether no point that `counts` is nearer than that.
    fn is_free(&self, at: Vec2, distance: f32, counts: impl Fn(&Point) -> bool) -> bool {
        !self.around(at, distance).any(counts)
    }

    /// How far the nearest other lines are to both sides; `spacing` where there is none within half as much again.
    fn room(&self, at: Vec2, along: Vec2, spacing: f32, line: u32) -> [f32; 2] {
        let mut room = [f32::INFINITY; 2];
        for other in self.around(at, 1.5 * spacing).filter(|p| p.line != line) {
            let offset = other.at - at;
            let across = along.perp_dot(offset);
            // What lies ahead is no neighbour.
            if across.abs() > 0.7 * along.length() * offset.length() {
                let side = &mut room[usize::from(across > 0.0)];
                *side = side.min(offset.length());
            }
        }
        room.map(|room| if room.is_finite() { room } else { spacing })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NIB: Nib = Nib {
        width: 1.4,
        pressure: 0.5,
        widest_spacing: 20.0,
        longest: 400.0,
    };

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
            let lines = streamlines(&bent(300, 300), &Plane::filled(300, 300, ink), &NIB);
            let drawn = ink_of(&lines, 300.0 * 300.0);
            assert!((drawn - ink).abs() < 0.03, "{ink} drawn as {drawn}");
        }
    }

    #[test]
    fn lines_keep_their_distance_and_their_direction() {
        let field = bent(300, 300);
        let lines = streamlines(&field, &Plane::filled(300, 300, 0.3), &NIB);
        let least = TEST * NIB.spacing(0.3);
        for (i, line) in lines.iter().enumerate() {
            for pair in line.points.windows(2) {
                let along = (pair[1] - pair[0]).normalize();
                let (x, y) = (pair[0].x as usize, pair[0].y as usize);
                let t = Vec2::new(field.x.at(x, y), -field.y.at(x, y));
                // The middle of a step is 1.2 pixels from that of the pixel it starts in at most, and 400 or more from
                // the place that the field goes around.
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
        let lines = streamlines(&bent(300, 300), &ink, &NIB);
        assert!(lines.len() > 50);
        for line in &lines {
            let left = line.points.iter().filter(|p| p.x < 120.5).count();
            assert!(left == 0 || left == line.points.len());
        }
    }

    #[test]
    fn without_pressure_all_lines_are_of_one_width() {
        let nib = Nib {
            pressure: 0.0,
            ..NIB
        };
        let ink = Plane::from_fn(200, 200, |x, _| x as f32 / 200.0);
        let lines = streamlines(&bent(200, 200), &ink, &nib);
        assert!(
            lines
                .iter()
                .flat_map(|l| &l.widths)
                .all(|&w| w == nib.width)
        );
        // Tone is told by their number: of ink 0.05 to 0.5 in the mean a quarter and a bit, of 0.5 to 0.95 the rest.
        let within = |from: f32, to: f32| {
            let points = lines.iter().flat_map(|l| &l.points);
            let count = points.filter(|p| (from..to).contains(&p.x)).count();
            count as f32 * nib.step() * nib.width / ((to - from) * 200.0)
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
    fn nothing_gives_no_lines_and_no_number_none_either() {
        for (width, height) in [(1, 1), (1, 40), (40, 1), (40, 40)] {
            for ink in [0.0, f32::NAN, -1.0] {
                let ink = Plane::filled(width, height, ink);
                assert!(streamlines(&bent(width, height), &ink, &NIB).is_empty());
            }
            let none = Vector2Planes {
                x: Plane::filled(width, height, 0.0),
                y: Plane::filled(width, height, 0.0),
            };
            let ink = Plane::filled(width, height, 1.0);
            assert!(streamlines(&none, &ink, &NIB).is_empty());
        }
    }
}
