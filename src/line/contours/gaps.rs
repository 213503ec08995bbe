//! Gaps in lines: free ends that face each other a few pixels apart belong to one line, interrupted where its weight
//! fell below the threshold.

use crate::line::contours::ground::Ground;
use crate::line::contours::network::{End, Line, Sets};
use glam::Vec2;
use std::collections::BTreeMap;

/// Smallest cosine of the angle between a line's direction and another end ahead.
const AHEAD: f32 = 0.75;

/// Ends nearer than this face each other unless they point the same way.
const TOUCHING_PX: f32 = 2.0;

/// Share of the way between two tips that counts as the tip itself.
const TIP_SHARE: f32 = 0.05;

/// An end of a line in the open.
pub(super) struct Tip {
    pub(super) line: usize,
    pub(super) end: usize,
    pub(super) at: Vec2,
    pub(super) ahead: Vec2,
}

/// All open ends of lines.
pub(super) fn tips(lines: &[Line]) -> Vec<Tip> {
    let open = lines.iter().enumerate().filter(|(_, line)| !line.closed);
    let tips = open.flat_map(|(i, line)| {
        let free = (0..2).filter(|&end| line.ends[end] == End::Free);
        free.map(move |end| Tip {
            line: i,
            end,
            at: line.spots[end * (line.spots.len() - 1)].at,
            ahead: line.direction_out(end),
        })
    });
    tips.collect()
}

/// Closes gaps of up to `widest_px`, the narrowest first: both ends are led to the midpoint, and the two parts become
/// one. None is closed across a line of the ground.
pub(crate) fn close_gaps(lines: &mut [Line], widest_px: f32, ground: Option<&Ground>) {
    let tips = tips(lines);
    let is_parted = |a: &Tip, b: &Tip| {
        // Tips may be on a line of the ground.
        let [from, to] = [TIP_SHARE, 1.0 - TIP_SHARE].map(|share| a.at.lerp(b.at, share));
        ground.is_some_and(|ground| ground.met(from, to).is_some())
    };
    let mut joined = vec![false; tips.len()];
    let mut parts = Sets::new(lines.len());
    for (a, b) in facing(&tips, widest_px, faces(widest_px)) {
        if joined[a] || joined[b] || is_parted(&tips[a], &tips[b]) {
            continue;
        }
        joined[a] = true;
        joined[b] = true;
        let middle = 0.5 * (tips[a].at + tips[b].at);
        for tip in [&tips[a], &tips[b]] {
            lines[tip.line].lead_to(middle, tip.end);
        }
        parts.unite(lines[tips[a].line].part, lines[tips[b].line].part);
    }
    for line in lines {
        line.part = parts.of(line.part);
    }
}

/// Whether two tips face each other across a gap.
fn faces(widest_px: f32) -> impl Fn(&Tip, &Tip) -> bool {
    move |a, b| {
        let way = b.at - a.at;
        let distance = way.length();
        let ahead = [a.ahead.dot(way), -b.ahead.dot(way)];
        let faces = ahead.iter().all(|&along| along >= AHEAD * distance)
            || (distance < TOUCHING_PX && a.ahead.dot(b.ahead) < 0.0);
        faces && distance <= widest_px
    }
}

/// The pairs of tips up to `reach` apart that face each other, the nearest first.
pub(super) fn facing(
    tips: &[Tip],
    reach: f32,
    faces: impl Fn(&Tip, &Tip) -> bool,
) -> Vec<(usize, usize)> {
    let cell = |at: Vec2| [at.x, at.y].map(|v| (v / reach.max(1.0)).floor() as i32);
    let mut cells: BTreeMap<[i32; 2], Vec<usize>> = BTreeMap::new();
    for (i, tip) in tips.iter().enumerate() {
        cells.entry(cell(tip.at)).or_default().push(i);
    }
    let mut pairs = Vec::new();
    for (a, tip) in tips.iter().enumerate() {
        let [x, y] = cell(tip.at);
        let around = (0..9).filter_map(|i| cells.get(&[x + i % 3 - 1, y + i / 3 - 1]));
        for &b in around.flatten().filter(|&&b| b > a) {
            if faces(tip, &tips[b]) {
                pairs.push((tip.at.distance(tips[b].at), a, b));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs.into_iter().map(|(_, a, b)| (a, b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::contours::network::straight as line;

    #[test]
    fn ends_that_face_each_other_meet_and_others_do_not() {
        let mut lines = [
            line(Vec2::ZERO, Vec2::new(20.0, 0.0), 0),
            line(Vec2::new(25.0, 1.0), Vec2::new(50.0, 1.0), 1),
            // Beside the second, five pixels off.
            line(Vec2::new(25.0, 6.0), Vec2::new(50.0, 6.0), 2),
        ];
        close_gaps(&mut lines, 8.0, None);
        assert_eq!(lines[0].ends, [End::Free, End::Joined]);
        assert_eq!(lines[1].ends, [End::Joined, End::Free]);
        assert_eq!(lines[2].ends, [End::Free; 2]);
        let middle = Vec2::new(22.5, 0.5);
        assert_eq!(lines[0].spots.last().unwrap().at, middle);
        assert_eq!(lines[1].spots[0].at, middle);
        assert_eq!([lines[0].part, lines[1].part, lines[2].part], [0, 0, 2]);
    }

    #[test]
    fn no_gap_is_closed_across_an_outline() {
        let outline = [Vec2::new(23.0, -20.0), Vec2::new(23.0, 20.0)];
        let ground = Ground::of_points([&outline[..]].into_iter(), [60, 60], 1);
        let mut lines = [
            line(Vec2::new(1.0, 5.0), Vec2::new(20.0, 5.0), 0),
            line(Vec2::new(25.0, 5.0), Vec2::new(50.0, 5.0), 1),
        ];
        close_gaps(&mut lines, 8.0, Some(&ground));
        assert_eq!(lines[0].ends, [End::Free; 2]);
        close_gaps(&mut lines, 8.0, None);
        assert_eq!(lines[0].ends, [End::Free, End::Joined]);
    }
}
