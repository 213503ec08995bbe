//! Upper hulls of the points that lines side by side have passed.
//!
//! All lines do the same at a time, so that compilers turn a step of all of them into vectors: one that is done waits for the
//! others. The last two points of each are at hand; those below lie on stacks, side by side too.

use crate::shape::occlusion::NOTHING;

/// Lines side by side: as many as the widest vectors have numbers.
pub(super) const LINES: usize = 16;

/// One number for each line.
pub(super) type Abreast = [f32; LINES];

/// The slope to a horizon where nothing is toward the light.
const NO_HORIZON: f32 = -1e6;

/// Two points before all others, with columns and heights, that are under every hull: no line sees them, and none drops them.
const UNDER: [[f32; 2]; 2] = [[-3.0, 300.0 * NOTHING], [-2.0, 100.0 * NOTHING]];

/// A point in the hull of each line: columns, and heights.
type HullPoints = [Abreast; 2];

/// A mask of lines: -1 where something holds, else 0.
type Which = [i32; LINES];

/// The points of all hulls of lines of some length, those of a place side by side.
pub(super) struct HullStacks([Vec<f32>; 2]);

impl HullStacks {
    /// Of lines through so many columns, with a point in each and one between each two.
    pub(super) fn new(columns: usize) -> Self {
        Self([0, 1].map(|of| {
            let mut stack = vec![0.0; LINES * (UNDER.len() + 2 * columns)];
            for (place, under) in stack.chunks_mut(LINES).zip(UNDER) {
                place.fill(under[of]);
            }
            stack
        }))
    }

    /// The points below these places.
    #[inline(always)]
    fn below(&self, places: &[i32; LINES]) -> HullPoints {
        let mut points = [[0.0; LINES]; 2];
        let [columns, heights] = &self.0;
        // No place is beyond the last, which the compiler cannot know.
        let most = columns.len() - 1;
        let heights = &heights[..=most];
        for l in 0..LINES {
            let place = ((places[l] - LINES as i32) as u32 as usize).min(most);
            (points[0][l], points[1][l]) = (columns[place], heights[place]);
        }
        points
    }
}

/// The hulls of lines, from their beginning on.
pub(super) struct Hulls<'a> {
    stacks: &'a mut HullStacks,
    last: HullPoints,
    before: HullPoints,
    /// Where in the stacks the last points are.
    end: [i32; LINES],
}

impl<'a> Hulls<'a> {
    #[inline(always)]
    pub(super) fn new(stacks: &'a mut HullStacks) -> Self {
        let [before, last] = UNDER.map(|point| point.map(|of| [of; LINES]));
        Self {
            stacks,
            last,
            before,
            end: std::array::from_fn(|l| (LINES + l) as i32),
        }
    }

    /// The steepest slopes up to points of the hulls, from places beyond them in a column.
    #[inline(always)]
    pub(super) fn slopes(&self, column: f32, height: &Abreast) -> Abreast {
        let mut best = away(&self.last, column, height);
        let mut next = away(&self.before, column, height);
        let (mut places, mut goes) = (self.end, [-1; LINES]);
        loop {
            // The hull is convex: slopes rise up to the horizon, and fall from there on.
            let (rises, mut any) = (is_steeper(&next, &best), 0);
            for l in 0..LINES {
                goes[l] &= rises[l];
                places[l] += LINES as i32 * goes[l];
                any |= goes[l];
            }
            if any == 0 {
                break;
            }
            replace(&mut best, &next, &goes);
            next = away(&self.stacks.below(&places), column, height);
        }
        let mut slopes = [0.0; LINES];
        for l in 0..LINES {
            slopes[l] = (best[1][l] / best[0][l]).max(NO_HORIZON);
        }
        slopes
    }

    /// Adds a point to each hull, in a column beyond all others, where there is a height.
    #[inline(always)]
    pub(super) fn add(&mut self, column: f32, height: &Abreast) {
        let (mut last, mut before, mut end) = (self.last, self.before, self.end);
        let mut is_new = [0; LINES];
        for l in 0..LINES {
            is_new[l] = if height[l] > NOTHING { -1 } else { 0 };
        }
        let mut drops = is_new;
        loop {
            // A point on or below the line between its neighbours is no horizon.
            let [near, far] = [away(&last, column, height), away(&before, column, height)];
            let (stays, mut any) = (is_steeper(&near, &far), 0);
            for l in 0..LINES {
                drops[l] &= !stays[l];
                end[l] += LINES as i32 * drops[l];
                any |= drops[l];
            }
            if any == 0 {
                break;
            }
            replace(&mut last, &before, &drops);
            before = self.stacks.below(&end);
        }
        let [columns, heights] = &mut self.stacks.0;
        for l in 0..LINES {
            // Where no point is added, the place is free.
            let place = (end[l] + LINES as i32) as u32 as usize;
            (columns[place], heights[place]) = (column, height[l]);
        }
        for l in 0..LINES {
            end[l] -= LINES as i32 * is_new[l];
        }
        replace(&mut before, &last, &is_new);
        replace(&mut last, &[[column; LINES], *height], &is_new);
        (self.last, self.before, self.end) = (last, before, end);
    }
}

/// Columns back to points, and how much higher they are.
#[inline(always)]
fn away([columns, heights]: &HullPoints, column: f32, height: &Abreast) -> HullPoints {
    let mut away = [[0.0; LINES]; 2];
    for l in 0..LINES {
        away[0][l] = column - columns[l];
        away[1][l] = heights[l] - height[l];
    }
    away
}

/// Whether `a` is seen above `b`, both as they are away.
#[inline(always)]
fn is_steeper(a: &HullPoints, b: &HullPoints) -> Which {
    let mut is_steeper = [0; LINES];
    for l in 0..LINES {
        let is = a[1][l] * b[0][l] > b[1][l] * a[0][l];
        is_steeper[l] = if is { -1 } else { 0 };
    }
    is_steeper
}

#[inline(always)]
fn replace(points: &mut HullPoints, by: &HullPoints, which: &Which) {
    for (points, by) in points.iter_mut().zip(by) {
        for l in 0..LINES {
            points[l] = if which[l] != 0 { by[l] } else { points[l] };
        }
    }
}
