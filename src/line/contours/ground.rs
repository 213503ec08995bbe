//! Positions of drawn silhouettes: other lines end at them, and keep away.

use crate::frame::{Frame, Plane};
use crate::line::contours::network::{End, Line};
use crate::line::placed::{Placed, Point};
use crate::params::ContourParams;
use glam::Vec2;

/// Positions of drawn silhouettes, for other lines to end at and to keep away from.
pub(crate) struct Ground {
    /// Smallest distance of creases, in pixels.
    room: usize,
    /// Places on lines, pixel by pixel, with the number of the line's point that is there or before it.
    places: Placed,
    /// Whether a pixel is too close to a silhouette for a crease.
    taken: Plane<bool>,
}

/// Places of a line are no farther apart, in pixels, so that those of a piece are in its pixels or beside them.
const APART: f32 = 1.5;

/// Sine of the smallest angle at which a line ends at one straight ahead: at less it runs beside it.
const ACROSS: f32 = 0.4;

/// The reach of ends that are led on to other lines.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Onward {
    /// Farthest distance of a line straight ahead, in pixels.
    pub(crate) ahead: f32,
    /// Farthest distance of one to the side, in pixels.
    pub(crate) aside: f32,
    /// Smallest cosine of the angle between an end's direction and a line to the side.
    pub(crate) straight: f32,
    /// Whether the lines may be led on to themselves: they are those of the ground, in the same order.
    pub(crate) are_own: bool,
}

impl Ground {
    pub(crate) fn new<'a>(
        lines: impl IntoIterator<Item = &'a Line>,
        frame: &Frame,
        params: &ContourParams,
    ) -> Self {
        let size = [frame.mask.width(), frame.mask.height()];
        let room = (0.5 * params.width_px + 1.5).clamp(2.0, 6.0) as usize;
        let points = |line: &Line| {
            let mut points = line.points();
            points.extend(line.closed.then(|| points[0]));
            points
        };
        Self::of_points(lines.into_iter().map(points), size, room)
    }

    /// The ground of lines through these points in a picture of `width` by `height` pixels; other lines stay `room`
    /// pixels away, at least one.
    pub(crate) fn of_points(
        lines: impl Iterator<Item: AsRef<[Vec2]>>,
        [width, height]: [usize; 2],
        room: usize,
    ) -> Self {
        let mut ground = Self {
            room,
            places: Placed::new([width, height], 1.0),
            taken: Plane::filled(width, height, false),
        };
        for (line, points) in (0..).zip(lines) {
            let points = points.as_ref();
            for (index, &at) in points.iter().enumerate() {
                let next = points.get(index + 1).copied().unwrap_or(at);
                let steps = (at.distance(next) / APART).ceil().max(1.0) as usize;
                for step in 0..steps {
                    let at = at.lerp(next, step as f32 / steps as f32);
                    ground.places.add(at, line, index as i32);
                    ground.take(at);
                }
            }
        }
        ground
    }

    /// Keeps creases away from a place.
    fn take(&mut self, at: Vec2) {
        let [x, y] = self.taken.pixel_at(at);
        let (width, height, reach) = (self.taken.width(), self.taken.height(), self.room - 1);
        for y in y.saturating_sub(reach)..(y + reach + 1).min(height) {
            let row = self.taken.row_mut(y);
            row[x.saturating_sub(reach)..(x + reach + 1).min(width)].fill(true);
        }
    }

    /// Whether a crease may pass pixel `i`.
    pub(crate) fn is_free(&self, i: usize) -> bool {
        !self.taken.samples()[i]
    }

    /// Distance from a silhouette at which a crease may have stopped to keep away, and is led on to it, in pixels.
    pub(crate) fn beside_px(&self) -> f32 {
        (2 * self.room + 1) as f32
    }

    /// Where the way between two points first crosses a line.
    pub(crate) fn met(&self, from: Vec2, to: Vec2) -> Option<Vec2> {
        self.met_by(from, to, |_| true).map(|[place, _]| place)
    }

    /// The same for places that count, and the unit direction of the line there.
    fn met_by(&self, from: Vec2, to: Vec2, counts: impl Fn(&Point) -> bool) -> Option<[Vec2; 2]> {
        let places = &self.places.points;
        let near = self.places.between(from.min(to) - 2.0, from.max(to) + 2.0);
        let pieces = near.filter_map(|(number, place)| {
            let piece = [place, places.get(number + 1)?];
            (piece[0].line == piece[1].line && counts(piece[0])).then(|| piece.map(|end| end.at))
        });
        let crossed = pieces.filter_map(|piece| {
            let share = share_to_crossing([from, to], piece)?;
            Some((share, (piece[1] - piece[0]).normalize_or_zero()))
        });
        let (share, along) = crossed.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some([from.lerp(to, share), along])
    }

    /// Leads the open ends of lines on to a line close ahead.
    pub(crate) fn join_ends(&self, lines: &mut [Line], onward: Onward) {
        let open = (0..).zip(lines).filter(|(_, line)| !line.closed);
        for (i, line) in open {
            let ends = line.ends;
            for end in (0..2).filter(|&end| ends[end] == End::Free) {
                let index = end * (line.spots.len() - 1);
                let tip = line.spots[index].at;
                let own_reach = 4 * onward.ahead.max(onward.aside) as u32;
                let is_itself = |place: &Point| {
                    let away = place.index.abs_diff(index as i32);
                    onward.are_own && place.line == i && away < own_reach
                };
                let ahead = line.direction_out(end);
                let met = self.met_by(tip, tip + onward.ahead * ahead, |place| !is_itself(place));
                let met = met.filter(|[_, along]| ahead.perp_dot(*along).abs() >= ACROSS);
                let met = met.map(|[place, _]| place);
                let joined = met.or_else(|| self.nearest_ahead(tip, ahead, onward, is_itself));
                if let Some(place) = joined {
                    line.lead_to(place, end);
                }
            }
        }
    }

    /// The nearest place on a line that is ahead of a tip, or to the side.
    fn nearest_ahead(
        &self,
        tip: Vec2,
        ahead: Vec2,
        onward: Onward,
        is_itself: impl Fn(&Point) -> bool,
    ) -> Option<Vec2> {
        let reach = onward.aside.floor();
        let near = self.places.between(tip - reach, tip + reach);
        let ways = near.filter_map(|(_, place)| {
            let way = place.at - tip;
            let distance = way.length();
            let is_ahead = way.dot(ahead) >= onward.straight * distance;
            (is_ahead && distance <= onward.aside && !is_itself(place)).then_some(place.at)
        });
        ways.min_by(|a, b| a.distance_squared(tip).total_cmp(&b.distance_squared(tip)))
    }
}

/// The share of a way, without its start, from which on it is beyond a piece of a line; `None` if it does not cross it.
fn share_to_crossing([from, to]: [Vec2; 2], piece: [Vec2; 2]) -> Option<f32> {
    let (way, along) = (to - from, piece[1] - piece[0]);
    let turn = way.perp_dot(along);
    let share = (piece[0] - from).perp_dot(along) / turn;
    let place = (piece[0] - from).perp_dot(way) / turn;
    // Parallel ones give infinities, or no number.
    (share > 0.0 && share <= 1.0 && (0.0..=1.0).contains(&place)).then_some(share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::contours::network::lines::straight;

    #[test]
    fn a_line_runs_straight_on_to_the_side_of_another() {
        // Upright at x = 46.3 in one long piece; the others rise by 1 in 4 and end 4.3 pixels before it, or 14.3; the third
        // ends beside it, turned 10 degrees from it.
        let post = [Vec2::new(46.3, 2.0), Vec2::new(46.3, 90.0)];
        let ground = Ground::of_points([&post[..]].into_iter(), [100, 100], 2);
        let along = Vec2::from_angle(80.0_f32.to_radians());
        let beside = Vec2::new(45.5, 80.0);
        let mut lines = [
            straight(Vec2::new(2.0, 30.0), Vec2::new(42.0, 40.0), 0),
            straight(Vec2::new(2.0, 50.0), Vec2::new(32.0, 57.5), 1),
            straight(beside - 30.0 * along, beside, 2),
        ];
        let onward = Onward {
            ahead: 8.0,
            aside: 0.0,
            straight: 0.5,
            are_own: false,
        };
        ground.join_ends(&mut lines, onward);
        // 40 + 4.3/4.
        let touching = lines[0].spots[lines[0].spots.len() - 1].at;
        assert!(
            touching.distance(Vec2::new(46.3, 41.075)) < 1e-3,
            "{touching}"
        );
        let ends = lines.map(|line| line.ends[1]);
        assert_eq!(ends, [End::Joined, End::Free, End::Free]);
    }
}
