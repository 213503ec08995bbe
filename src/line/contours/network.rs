//! Networks of lines: paths that meet at junctions become lines that run through them, or end in one point.

use crate::line::contours::lattice::{Lattice, NodePath};
use crate::line::contours::polyline::{length, smoothed};
use crate::line::contours::smoothing::Smoothing;
use glam::Vec2;
use rayon::prelude::*;

/// A point on a line, with the inputs to its width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spot {
    /// Where, in picture coordinates: x right, y down, pixel edges at integers.
    pub at: Vec2,
    /// Strength of the edge, 0..1.
    pub strength: f32,
    /// Logarithm of the depth of its nearer side; 0 where depth is unknown.
    pub log_depth: f32,
    /// Whether another edge is so close beside it that one line serves both.
    pub is_beside: bool,
}

/// The end of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    /// A free end.
    Free,
    /// At the border of the picture, continuing beyond it.
    Border,
    /// At this junction, or at another line.
    Joined,
}

/// A line through spots.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// The spots in order; of a closed line the first is not repeated.
    pub spots: Vec<Spot>,
    /// Whether the last spot is joined to the first.
    pub closed: bool,
    /// Ends of its first and its last spot, if it is open.
    pub ends: [End; 2],
    /// Index of its connected component in the network.
    pub part: usize,
}

/// Paths, and the spots along them.
struct Strand {
    spots: Vec<Spot>,
    nodes: [u32; 2],
    closed: bool,
}

/// The end of a strand at a junction.
#[derive(Debug, Clone, Copy)]
struct Tip {
    junction: u32,
    strand: usize,
    /// 0 the first spot, 1 the last.
    end: usize,
    /// The unit direction away from the junction.
    away: Vec2,
}

/// Branches of a line with fewer steps than this are remains of thinning, or of noise.
const SHORTEST_BRANCH: usize = 4;

/// Spots past which a strand's direction at its end is measured.
const DIRECTION_REACH: usize = 6;

/// Two strands run through a junction as one line if they turn by less than this there: cosine of 40 degrees.
const STRAIGHT: f32 = 0.77;

/// The lines along the links of `lattice`. `spots` gives those of a path, without its junctions; open-ended branches
/// with fewer steps than `SHORTEST_BRANCH` are dropped, and so are those with most spots beside another. Lines that end
/// within `rim` steps of the border of the picture continue beyond it. All lines are smoothed before their ends are
/// joined.
pub(crate) fn lines(
    lattice: &Lattice,
    place: impl Fn(u32) -> Vec2,
    spots: impl Fn(&NodePath) -> Vec<Spot>,
    rim: usize,
    smoothing: Smoothing,
) -> Vec<Line> {
    let mut strands: Vec<Strand> = lattice
        .paths()
        .into_iter()
        .map(|path| Strand {
            spots: spots(&path),
            nodes: [path.nodes[0], *path.nodes.last().expect("a path has nodes")],
            closed: path.closed,
        })
        .collect();
    let is_junction = |node: u32| lattice.degree(node) > 2;
    let is_branch = |strand: &Strand| {
        let joined = strand.nodes.map(is_junction);
        let open_end = strand.nodes[usize::from(joined[0])];
        !strand.closed && joined[0] != joined[1] && !lattice.on_rim(open_end, rim)
    };
    let shortest = smoothing.steps(SHORTEST_BRANCH);
    let is_short = |strand: &Strand| strand.spots.len() < shortest && is_branch(strand);
    let is_beside = |strand: &Strand| {
        let beside = strand.spots.iter().filter(|spot| spot.is_beside).count();
        2 * beside > strand.spots.len()
    };
    strands.retain(|strand| !is_beside(strand) && !is_short(strand));
    let mut network = Network::new(strands, is_junction, &place);
    network.pair();
    network.lines(|node| lattice.on_rim(node, rim), smoothing)
}

/// Disjoint sets of nodes or lines, with a number for each set.
pub(crate) struct Sets(Vec<usize>);

impl Sets {
    /// `count` sets of one element each.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The number of the set that `i` is in: its lowest member.
    pub(crate) fn of(&mut self, i: usize) -> usize {
        let mut root = i;
        while self.0[root] != root {
            root = self.0[root];
        }
        let mut at = i;
        while self.0[at] != root {
            at = std::mem::replace(&mut self.0[at], root);
        }
        root
    }

    /// Makes one set of two.
    pub(crate) fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        // The lower number becomes the root, in either order.
        self.0[a.max(b)] = a.min(b);
    }
}

struct Network {
    strands: Vec<Strand>,
    /// The tips of each junction.
    junctions: Vec<Vec<Tip>>,
    /// For each end of a strand, the strand's end it continues in.
    onward: Vec<[Option<(usize, usize)>; 2]>,
}

impl Network {
    /// Junctions that nothing but a link parts become one.
    fn new(
        strands: Vec<Strand>,
        is_junction: impl Fn(u32) -> bool,
        place: &impl Fn(u32) -> Vec2,
    ) -> Self {
        let mut nodes: Vec<u32> = strands
            .iter()
            .flat_map(|s| s.nodes)
            .filter(|&node| is_junction(node))
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        let number = |node: u32| nodes.binary_search(&node).ok();
        let mut sets = Sets::new(nodes.len());
        let bare = |s: &Strand| s.spots.is_empty() && !s.closed;
        for strand in strands.iter().filter(|s| bare(s)) {
            if let [Some(a), Some(b)] = strand.nodes.map(number) {
                sets.unite(a, b);
            }
        }
        let strands: Vec<Strand> = strands
            .into_iter()
            .filter(|s| !s.spots.is_empty())
            .collect();
        let mut tips = Vec::new();
        for (i, strand) in strands.iter().enumerate().filter(|(_, s)| !s.closed) {
            for end in 0..2 {
                let Some(junction) = number(strand.nodes[end]) else {
                    continue;
                };
                let spots = &strand.spots;
                let ahead = DIRECTION_REACH.min(spots.len() - 1);
                let far = if end == 0 {
                    ahead
                } else {
                    spots.len() - 1 - ahead
                };
                tips.push(Tip {
                    junction: sets.of(junction) as u32,
                    strand: i,
                    end,
                    away: (spots[far].at - place(strand.nodes[end])).normalize_or_zero(),
                });
            }
        }
        tips.sort_by_key(|tip| tip.junction);
        let junctions = tips.chunk_by(|a, b| a.junction == b.junction);
        let junctions = junctions.map(<[Tip]>::to_vec).collect();
        let onward = vec![[None; 2]; strands.len()];
        Self {
            strands,
            junctions,
            onward,
        }
    }

    /// Joins the strands that run straight on through each junction, the straightest first; two alone are joined
    /// however they turn.
    fn pair(&mut self) {
        for tips in &self.junctions {
            let mut turns: Vec<(f32, usize, usize)> = (0..tips.len())
                .flat_map(|i| (i + 1..tips.len()).map(move |j| (i, j)))
                .map(|(i, j)| (-tips[i].away.dot(tips[j].away), i, j))
                .filter(|turn| turn.0 > STRAIGHT || tips.len() == 2)
                .collect();
            turns.sort_by(|a, b| b.0.total_cmp(&a.0));
            for (_, i, j) in turns {
                let [a, b] = [i, j].map(|k| (tips[k].strand, tips[k].end));
                if self.onward[a.0][a.1].is_none() && self.onward[b.0][b.1].is_none() {
                    self.onward[a.0][a.1] = Some(b);
                    self.onward[b.0][b.1] = Some(a);
                }
            }
        }
    }

    /// The strands of each line in order, each with the end it is entered at, and whether the line closes.
    fn courses(&self) -> Vec<(Vec<(usize, usize)>, bool)> {
        let mut taken = vec![false; self.strands.len()];
        let mut courses = Vec::new();
        let ends = (0..self.strands.len()).flat_map(|strand| [(strand, 0), (strand, 1)]);
        let open = ends
            .clone()
            .filter(|&(strand, end)| self.onward[strand][end].is_none());
        for (strand, end) in open.chain(ends) {
            if taken[strand] {
                continue;
            }
            let mut course = Vec::new();
            let mut at = Some((strand, end));
            while let Some((strand, end)) = at.filter(|&(strand, _)| !taken[strand]) {
                taken[strand] = true;
                course.push((strand, end));
                at = self.onward[strand][1 - end];
            }
            courses.push((course, at.is_some()));
        }
        courses
    }

    fn lines(&self, on_rim: impl Fn(u32) -> bool, smoothing: Smoothing) -> Vec<Line> {
        let mut lines = Vec::new();
        // For each strand: its line, and the range of its spots there.
        let mut at = vec![(0, [0; 2]); self.strands.len()];
        for (course, closes) in self.courses() {
            let mut spots = Vec::new();
            for &(strand, entered) in &course {
                let own = &self.strands[strand].spots;
                let range = [spots.len(), spots.len() + own.len() - 1];
                let (range, own): (_, Vec<Spot>) = match entered {
                    0 => (range, own.clone()),
                    _ => ([range[1], range[0]], own.iter().rev().copied().collect()),
                };
                at[strand] = (lines.len(), range);
                spots.extend(own);
            }
            let (first, last) = (course[0], course[course.len() - 1]);
            let end = |(strand, end): (usize, usize)| {
                let node = self.strands[strand].nodes[end];
                if on_rim(node) { End::Border } else { End::Free }
            };
            lines.push(Line {
                spots,
                closed: closes || self.strands[first.0].closed,
                ends: [end(first), end((last.0, 1 - last.1))],
                part: lines.len(),
            });
        }
        lines.par_iter_mut().for_each(|line| line.smooth(smoothing));
        self.meet(&mut lines, &at);
        lines
    }

    /// Lets the lines that end at a junction end in one point: on the lines that run through it, or where their
    /// courses cross.
    fn meet(&self, lines: &mut [Line], at: &[(usize, [usize; 2])]) {
        let mut sets = Sets::new(lines.len());
        // Points to be put before the first and behind the last spot of each line.
        let mut meetings: Vec<[Option<Vec2>; 2]> = vec![[None; 2]; lines.len()];
        for tips in &self.junctions {
            let spot = |tip: &Tip| {
                let (line, ends) = at[tip.strand];
                (line, ends[tip.end])
            };
            let place = |tip: &Tip| {
                let (line, i) = spot(tip);
                lines[line].spots[i].at
            };
            let runs_on = |tip: &&Tip| self.onward[tip.strand][tip.end].is_some();
            let through: Vec<Vec2> = tips.iter().filter(runs_on).map(place).collect();
            let ending: Vec<&Tip> = tips.iter().filter(|tip| !runs_on(tip)).collect();
            let meeting = if through.is_empty() {
                let courses: Vec<[Vec2; 2]> = ending
                    .iter()
                    .map(|tip| {
                        let (line, i) = spot(tip);
                        [place(tip), direction_at(&lines[line].spots, i)]
                    })
                    .collect();
                crossing(&courses)
            } else {
                through.iter().sum::<Vec2>() / through.len() as f32
            };
            for tip in ending {
                let (line, i) = spot(tip);
                let last = i > 0 || (lines[line].spots.len() == 1 && meetings[line][0].is_some());
                meetings[line][usize::from(last)] = Some(meeting);
            }
            for pair in tips.windows(2) {
                sets.unite(at[pair[0].strand].0, at[pair[1].strand].0);
            }
        }
        for (i, line) in lines.iter_mut().enumerate() {
            line.part = sets.of(i);
            for (end, meeting) in meetings[i].into_iter().enumerate() {
                if let Some(meeting) = meeting {
                    line.lead_to(meeting, end);
                }
            }
        }
    }
}

/// The outward direction of a line at its first or last spot.
fn direction_at(spots: &[Spot], i: usize) -> Vec2 {
    let ahead = DIRECTION_REACH.min(spots.len() - 1);
    let inner = if i == 0 { ahead } else { i - ahead };
    (spots[i].at - spots[inner].at).normalize_or_zero()
}

/// The point closest to all the courses, each a point and a unit direction; if they hardly cross, or far away, the
/// centre of their points.
fn crossing(courses: &[[Vec2; 2]]) -> Vec2 {
    let middle = courses.iter().map(|course| course[0]).sum::<Vec2>() / courses.len().max(1) as f32;
    // Least squares of the distances across, sum (1 - u u^T) (x - p) = 0, with a little pull to the middle.
    const PULL: f32 = 0.02;
    let (mut xx, mut xy, mut yy, mut right) = (PULL, 0.0, PULL, Vec2::ZERO);
    for &[point, u] in courses {
        let offset = point - middle;
        let across = offset - offset.dot(u) * u;
        (xx, xy, yy) = (xx + 1.0 - u.x * u.x, xy - u.x * u.y, yy + 1.0 - u.y * u.y);
        right += across;
    }
    let determinant = xx * yy - xy * xy;
    let offset = Vec2::new(yy * right.x - xy * right.y, xx * right.y - xy * right.x) / determinant;
    if offset.length() < FARTHEST_CROSSING_PX {
        middle + offset
    } else {
        middle
    }
}

/// Largest distance from their ends at which lines meet where they would cross.
const FARTHEST_CROSSING_PX: f32 = 2.5;

impl Line {
    /// Where its spots are.
    pub(crate) fn points(&self) -> Vec<Vec2> {
        self.spots.iter().map(|spot| spot.at).collect()
    }

    /// Evens out the steps between pixels.
    fn smooth(&mut self, smoothing: Smoothing) {
        let smooth = smoothed(&self.points(), self.closed, smoothing);
        let spots = self.spots.iter_mut().zip(smooth);
        spots.for_each(|(spot, at)| spot.at = at);
    }

    /// Extends the line's first (`end` 0) or last (1) spot to a point. Spots closer to it than a pixel and a half are
    /// removed, so that the line does not bend there.
    pub(crate) fn lead_to(&mut self, point: Vec2, end: usize) {
        const ROOM_PX: f32 = 1.5;
        let spots = &mut self.spots;
        if end == 0 {
            spots.reverse();
        }
        let mut tip = spots[spots.len() - 1];
        tip.at = point;
        while spots.len() > 1 && spots[spots.len() - 1].at.distance(point) < ROOM_PX {
            spots.pop();
        }
        spots.push(tip);
        if end == 0 {
            spots.reverse();
        }
        self.ends[end] = End::Joined;
    }

    /// The line's length in pixels.
    pub(crate) fn length(&self) -> f32 {
        length(&self.points(), self.closed)
    }

    /// The mean strength along the line.
    pub(crate) fn strength(&self) -> f32 {
        self.spots.iter().map(|spot| spot.strength).sum::<f32>() / self.spots.len() as f32
    }

    /// The outward unit direction of the line at its first (`end` 0) or last (1) spot.
    pub(crate) fn direction_out(&self, end: usize) -> Vec2 {
        direction_at(&self.spots, end * (self.spots.len() - 1))
    }
}

#[cfg(test)]
pub(super) mod lines {
    use super::*;

    /// A straight line of one spot per pixel, open at both ends.
    pub(in crate::line) fn straight(from: Vec2, to: Vec2, part: usize) -> Line {
        let count = from.distance(to) as usize;
        let spot = |i: usize| Spot {
            at: from.lerp(to, i as f32 / count as f32),
            strength: 1.0,
            log_depth: 0.0,
            is_beside: false,
        };
        Line {
            spots: (0..=count).map(spot).collect(),
            closed: false,
            ends: [End::Free; 2],
            part,
        }
    }
}
