//! Positions of drawn silhouettes: other lines end at them, and keep away.

use crate::frame::Frame;
use crate::line::contours::network;
use crate::line::contours::network::Line;
use crate::params::ContourParams;
use glam::Vec2;
use std::ops::Range;

/// Positions of drawn silhouettes, for other lines to end at and to keep away from.
pub(crate) struct Ground {
    width: usize,
    height: usize,
    /// Smallest distance of creases, in pixels.
    room: usize,
    spots: Vec<Place>,
    /// The number of a spot in each pixel, from 1 on.
    first: Vec<u32>,
    /// Whether a pixel is too close to a silhouette for a crease.
    taken: Vec<bool>,
}

struct Place {
    at: Vec2,
    line: usize,
    index: usize,
}

impl Ground {
    pub(crate) fn new(lines: &[Line], frame: &Frame, params: &ContourParams) -> Self {
        let size = [frame.mask.width(), frame.mask.height()];
        let room = (0.5 * params.width_px + 1.5).clamp(2.0, 6.0) as usize;
        let points = |line: &Line| line.spots.iter().map(|spot| spot.at).collect();
        let lines: Vec<Vec<Vec2>> = lines.iter().map(points).collect();
        Self::of_points(lines.iter().map(Vec::as_slice), size, room)
    }

    /// The ground of lines through these points in a picture of `width` by `height` pixels; other lines stay `room`
    /// pixels away, at least one.
    pub(crate) fn of_points<'a>(
        lines: impl Iterator<Item = &'a [Vec2]>,
        [width, height]: [usize; 2],
        room: usize,
    ) -> Self {
        let mut ground = Self {
            width,
            height,
            room,
            spots: Vec::new(),
            first: vec![0; width * height],
            taken: vec![false; width * height],
        };
        for (line, points) in lines.enumerate() {
            for (index, &at) in points.iter().enumerate() {
                ground.spots.push(Place { at, line, index });
                let pixel = ground.pixel(at);
                let [columns, rows] = ground.around(at, room - 1);
                ground.first[pixel] = ground.spots.len() as u32;
                for y in rows {
                    ground.taken[y * width..][columns.clone()].fill(true);
                }
            }
        }
        ground
    }

    fn pixel(&self, at: Vec2) -> usize {
        let (x, y) = (at.x.max(0.0) as usize, at.y.max(0.0) as usize);
        y.min(self.height - 1) * self.width + x.min(self.width - 1)
    }

    /// The columns and rows up to `reach` away from a point's pixel.
    fn around(&self, at: Vec2, reach: usize) -> [Range<usize>; 2] {
        let pixel = self.pixel(at);
        let (x, y) = (pixel % self.width, pixel / self.width);
        [
            x.saturating_sub(reach)..(x + reach + 1).min(self.width),
            y.saturating_sub(reach)..(y + reach + 1).min(self.height),
        ]
    }

    /// Whether a crease may pass pixel `i`.
    pub(crate) fn is_free(&self, i: usize) -> bool {
        !self.taken[i]
    }

    /// Leads the open ends of lines on to a silhouette close ahead; of themselves too if they `are_own`.
    pub(crate) fn join_ends(&self, lines: &mut [Line], are_own: bool) {
        let reach = if are_own { 3 } else { 2 * self.room + 1 };
        self.join_ends_within(lines, are_own, reach, AHEAD);
    }

    /// The same within `reach` pixels, and straight ahead up to an angle of this cosine.
    pub(crate) fn join_ends_within(
        &self,
        lines: &mut [Line],
        are_own: bool,
        reach: usize,
        straight: f32,
    ) {
        let width = self.width;
        for (i, line) in lines
            .iter_mut()
            .enumerate()
            .filter(|(_, line)| !line.closed)
        {
            for end in 0..2 {
                if line.ends[end] != network::End::Free {
                    continue;
                }
                let index = end * (line.spots.len() - 1);
                let (tip, ahead) = (line.spots[index].at, line.direction_out(end));
                let is_itself = |place: &Place| {
                    are_own && place.line == i && place.index.abs_diff(index) < 4 * reach
                };
                let [columns, rows] = self.around(tip, reach);
                let pixels = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
                let nearest = pixels
                    .filter_map(|pixel| {
                        self.spots.get((self.first[pixel] as usize).wrapping_sub(1))
                    })
                    .filter(|place| !is_itself(place))
                    .filter(|place| {
                        let way = place.at - tip;
                        way.dot(ahead) >= straight * way.length() && way.length() <= reach as f32
                    })
                    .min_by(|a, b| {
                        a.at.distance_squared(tip)
                            .total_cmp(&b.at.distance_squared(tip))
                    });
                if let Some(place) = nearest {
                    line.lead_to(place.at, end);
                }
            }
        }
    }
}

/// Smallest cosine of the angle between a line's direction and a silhouette that it is led to.
const AHEAD: f32 = 0.4;
