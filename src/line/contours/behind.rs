//! Lines that pass behind something: their visible parts on both sides of it are one line.

use crate::frame::Frame;
use crate::line::contours::gaps::{Joint, OpenTip, join, joints};
use crate::line::contours::ground::Ground;
use crate::line::contours::log_depth;
use crate::line::contours::network::{Line, Sets};
use glam::Vec2;

/// Cosine of the largest angle between the way behind something and the line before and after it.
const STRAIGHT: f32 = 0.97;

/// Farthest distance of a line's end from the outline that hides the rest of it.
const FROM_OUTLINE: f32 = 12.0;

/// Longest way behind something. It is not longer than the two parts together either.
const LONGEST: f32 = 96.0;

/// Least way behind something, in pixels: less is the step from a near surface to a far one.
const THINNEST_PX: f32 = 1.0;

/// The surroundings of lines that may pass behind something.
pub(crate) struct Occluders<'a> {
    /// The outlines of what is in front.
    pub(crate) outlines: &'a Ground,
    pub(crate) frame: &'a Frame,
    /// Pixels of the frame to one of the lines.
    pub(crate) factor: f32,
    /// Pixels to a unit of length: more than 1 for lines of a coarser picture.
    pub(crate) unit_px: f32,
}

impl Occluders<'_> {
    /// Leads both parts of each line that passes behind something to the outlines between them, and makes one part of
    /// the network of both.
    pub(crate) fn unite(&self, lines: &mut [Line]) {
        let passages = self.passages(lines);
        join(lines, &passages);
    }

    /// For each line the length of its other parts, beyond what it passes behind.
    pub(crate) fn lengths_beyond(&self, lines: &[Line]) -> Vec<f32> {
        let mut wholes = Sets::new(lines.len());
        for Joint { ends, .. } in self.passages(lines) {
            wholes.unite(ends[0].0, ends[1].0);
        }
        let lengths: Vec<f32> = lines.iter().map(Line::length).collect();
        let mut sums = vec![0.0; lines.len()];
        for (i, length) in lengths.iter().enumerate() {
            sums[wholes.of(i)] += length;
        }
        let beyond = |(i, length): (usize, &f32)| sums[wholes.of(i)] - length;
        lengths.iter().enumerate().map(beyond).collect()
    }

    /// The ways behind something, the shortest first.
    fn passages(&self, lines: &[Line]) -> Vec<Joint> {
        let lengths: Vec<f32> = lines.iter().map(Line::length).collect();
        let longest = LONGEST * self.unit_px;
        let goes_on = |a: &OpenTip, b: &OpenTip| {
            let way = b.at - a.at;
            let distance = way.length();
            let straight = [a.ahead.dot(way), -b.ahead.dot(way)];
            straight.iter().all(|&along| along >= STRAIGHT * distance)
                && distance <= longest.min(lengths[a.line] + lengths[b.line])
        };
        joints(lines, longest, goes_on, |ends| self.hidden_between(ends))
    }

    /// Where the way between two ends goes behind something, and where it comes out, each close to its end.
    fn hidden_between(&self, [a, b]: [Vec2; 2]) -> Option<[Vec2; 2]> {
        let way = (b - a).normalize_or_zero();
        let reach = (FROM_OUTLINE * self.unit_px).min(a.distance(b)) * way;
        let [enters, leaves] = [
            self.outlines.met(a, a + reach)?,
            self.outlines.met(b, b - reach)?,
        ];
        let depth = |at: Vec2| log_depth(self.frame, self.factor * at);
        let is_nearer = depth(enters.midpoint(leaves))? < depth(a)?.min(depth(b)?);
        (is_nearer && way.dot(leaves - enters) > THINNEST_PX).then_some([enters, leaves])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Plane, Vector3Planes};
    use crate::line::contours::network::End;
    use crate::line::contours::network::lines::straight;
    use glam::DVec3;

    /// A frame with a strip from column 40 to 52 at this depth before, or behind, a wall at 10.
    fn strip(depth: f32) -> Frame {
        let normal = Vector3Planes::from_fn(100, 60, |_, _| DVec3::Z);
        let mut frame = Frame::of_normals(normal, Mask::new(Plane::filled(100, 60, true)));
        let depths = |x: usize, _| if (40..52).contains(&x) { depth } else { 10.0 };
        frame.depth = Some(Plane::from_fn(100, 60, depths));
        frame
    }

    /// The lines once those that pass behind a strip at this depth are united, and what each has beyond it.
    fn united(mut lines: [Line; 2], depth: f32) -> ([Line; 2], Vec<f32>) {
        let sides = [40.0, 52.0].map(|x| [Vec2::new(x, 0.0), Vec2::new(x, 60.0)]);
        let sides = sides.iter().map(|side| &side[..]);
        let occluders = Occluders {
            outlines: &Ground::of_points(sides, [100, 60], 2),
            frame: &strip(depth),
            factor: 1.0,
            unit_px: 1.0,
        };
        let beyond = occluders.lengths_beyond(&lines);
        occluders.unite(&mut lines);
        (lines, beyond)
    }

    fn lines(right: [Vec2; 2]) -> [Line; 2] {
        let left = straight(Vec2::new(10.0, 20.0), Vec2::new(36.0, 20.0), 0);
        [left, straight(right[0], right[1], 1)]
    }

    #[test]
    fn a_line_goes_on_behind_a_strip() {
        let right = [Vec2::new(55.0, 21.0), Vec2::new(75.0, 21.0)];
        let (hidden, beyond) = united(lines(right), 5.0);
        // From (36, 20) to (55, 21): at x = 40 4/19 of the way, at 52 16/19.
        let [left, right] = &hidden;
        let ends = [left.spots[left.spots.len() - 1].at, right.spots[0].at];
        for (end, expected) in ends.into_iter().zip([[40.0, 20.2105], [52.0, 20.8421]]) {
            assert!(end.distance(expected.into()) < 1e-3, "{end}");
        }
        assert_eq!([left.ends[1], right.ends[0]], [End::Joined; 2]);
        assert_eq!([left.part, right.part], [0, 0]);
        assert_eq!(beyond, [20.0, 26.0]);
    }

    #[test]
    fn a_groove_hides_nothing_and_a_line_of_another_course_is_another() {
        let same = [Vec2::new(55.0, 21.0), Vec2::new(75.0, 21.0)];
        // Off by 30 degrees.
        let other = [Vec2::new(55.0, 21.0), Vec2::new(75.0, 32.5)];
        for (right, depth) in [(same, 11.0), (other, 5.0)] {
            let (parted, beyond) = united(lines(right), depth);
            assert_eq!(parted, lines(right));
            assert_eq!(beyond, [0.0; 2]);
        }
    }
}
