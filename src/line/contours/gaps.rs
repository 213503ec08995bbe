//! Gaps in lines: free ends that face each other a few pixels apart belong to one line, interrupted where its weight
//! fell below the threshold.

use crate::line::contours::ground::Ground;
use crate::line::contours::network::{End, Line, Sets};
use crate::line::placed::Placed;
use glam::Vec2;

/// Smallest cosine of the angle between a line's direction and another end ahead.
const AHEAD: f32 = 0.75;

/// Ends nearer than this face each other unless they point the same way.
const TOUCHING_PX: f32 = 2.0;

/// Share of the way between two tips that counts as the tip itself.
const TIP_SHARE: f32 = 0.05;

/// An end of a line in the open.
pub(super) struct OpenTip {
    pub(super) line: usize,
    pub(super) end: usize,
    pub(super) at: Vec2,
    pub(super) ahead: Vec2,
}

/// All open ends of lines.
fn tips(lines: &[Line]) -> Vec<OpenTip> {
    let open = lines.iter().enumerate().filter(|(_, line)| !line.closed);
    let tips = open.flat_map(|(i, line)| {
        let free = (0..2).filter(|&end| line.ends[end] == End::Free);
        free.map(move |end| OpenTip {
            line: i,
            end,
            at: line.spots[end * (line.spots.len() - 1)].at,
            ahead: line.direction_out(end),
        })
    });
    tips.collect()
}

/// Two open ends of lines that belong together, and where each is led to.
pub(super) struct Joint {
    /// The numbers of the lines, and their ends.
    pub(super) ends: [(usize, usize); 2],
    to: [Vec2; 2],
}

/// Closes gaps of up to `widest_px`, the narrowest first: both ends are led to the midpoint, and the two parts become
/// one. None is closed across a line of the ground.
pub(crate) fn close_gaps(lines: &mut [Line], widest_px: f32, ground: Option<&Ground>) {
    let joints = joints(lines, widest_px, faces(widest_px), |[a, b]| {
        // Tips may be on a line of the ground.
        let [from, to] = [TIP_SHARE, 1.0 - TIP_SHARE].map(|share| a.lerp(b, share));
        let is_parted = ground.is_some_and(|ground| ground.met(from, to).is_some());
        (!is_parted).then_some([0.5 * (a + b); 2])
    });
    join(lines, &joints);
}

/// Leads the ends of lines to where they join, and makes one part of the network of both lines.
pub(super) fn join(lines: &mut [Line], joints: &[Joint]) {
    let mut parts = Sets::new(lines.len());
    for Joint { ends, to } in joints {
        for (&(line, end), &to) in ends.iter().zip(to) {
            lines[line].lead_to(to, end);
        }
        let [a, b] = ends.map(|(line, _)| lines[line].part);
        parts.unite(a, b);
    }
    for line in lines {
        line.part = parts.of(line.part);
    }
}

/// The joints of tips up to `reach` apart that face each other, the nearest first, where both can be led `to` some place;
/// each end is part of one at most.
pub(super) fn joints(
    lines: &[Line],
    reach: f32,
    faces: impl Fn(&OpenTip, &OpenTip) -> bool,
    to: impl Fn([Vec2; 2]) -> Option<[Vec2; 2]>,
) -> Vec<Joint> {
    let tips = tips(lines);
    let mut is_taken = vec![false; tips.len()];
    let mut joints = Vec::new();
    for pair in facing(&tips, reach, faces) {
        let free = Some(pair.map(|i| tips[i].at)).filter(|_| pair.iter().all(|&i| !is_taken[i]));
        if let Some(to) = free.and_then(&to) {
            pair.iter().for_each(|&i| is_taken[i] = true);
            let ends = pair.map(|i| (tips[i].line, tips[i].end));
            joints.push(Joint { ends, to });
        }
    }
    joints
}

/// Whether two tips face each other across a gap.
fn faces(widest_px: f32) -> impl Fn(&OpenTip, &OpenTip) -> bool {
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
fn facing(
    tips: &[OpenTip],
    reach: f32,
    faces: impl Fn(&OpenTip, &OpenTip) -> bool,
) -> Vec<[usize; 2]> {
    let most = tips.iter().fold(Vec2::ZERO, |most, tip| most.max(tip.at));
    let mut cells = Placed::new(
        most.to_array().map(|length| length as usize),
        reach.max(1.0),
    );
    for (i, tip) in tips.iter().enumerate().rev() {
        cells.add(tip.at, i as u32, 0);
    }
    let mut pairs = Vec::new();
    for (a, tip) in tips.iter().enumerate() {
        let around = cells.between(tip.at - reach, tip.at + reach);
        let others = around.map(|(_, tip)| tip.line as usize).filter(|&b| b > a);
        for b in others.filter(|&b| faces(tip, &tips[b])) {
            pairs.push((tip.at.distance(tips[b].at), [a, b]));
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs.into_iter().map(|(_, pair)| pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::contours::network::lines::straight as line;

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
