//! The directions of x and y of a normal map, from outlines: a surface turns away from the viewer at its outline, so steep
//! normals there point outward, off the surface in front.
//!
//! At a jump of depth, the side in front follows from the sense of depth; at the end of coverage it is the covered side.
//! One outline alone can mislead, as a floor leans up everywhere; so an axis counts only if steep normals agree at outlines
//! on both sides of surfaces, right and left, or upper and lower.
//!
//! Limit: hollow forms, such as a bowl from above, turn inward at their outlines.

use crate::frame::{Mask, Plane, Vector3Planes};

/// Rows, and columns, that are looked through, at most.
const LINES: usize = 256;
/// A unit normal is steep along an axis from this component on.
const STEEP: f64 = 0.5;
/// Fewest steep normals on either side.
const FEWEST: usize = 16;
/// Share of them that agree.
const AGREE: f64 = 0.8;
/// Depth jumps where it changes by this many times the slope on either side ...
const JUMP: f32 = 9.0;
/// ... and by this share of its range.
const JUMP_OF_RANGE: f32 = 0.01;

/// Steep normals at outlines, by how they point.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Silhouettes {
    /// At the end of coverage.
    ends: Votes,
    /// At jumps of depth, on the side of the smaller numbers.
    lower: Votes,
    /// The same, on the side of the larger numbers.
    higher: Votes,
}

/// Counts of steep normals by axis, by whether outward is along it or against, and by whether they point inward or outward.
#[derive(Debug, Clone, Copy, Default)]
struct Votes([[[usize; 2]; 2]; 2]);

impl Votes {
    fn add(&mut self, axis: usize, is_along: bool, component: f64) {
        if component.abs() >= STEEP {
            let is_outward = (component > 0.0) == is_along;
            self.0[axis][usize::from(is_along)][usize::from(is_outward)] += 1;
        }
    }

    /// Whether normals point inward along an axis by both of these votes; `None` where the two sides do not show the same.
    fn points_inward(both: [&Self; 2], axis: usize) -> Option<bool> {
        let side = |along: usize| {
            let [inward, outward] = [0, 1].map(|way| {
                both.map(|votes| votes.0[axis][along][way])
                    .iter()
                    .sum::<usize>()
            });
            let (all, most) = (inward + outward, inward.max(outward));
            let shows = all >= FEWEST && most as f64 >= AGREE * all as f64;
            shows.then_some(inward > outward)
        };
        let [against, along] = [0, 1].map(side);
        against.filter(|_| against == along)
    }
}

impl Silhouettes {
    /// Looks at unit normals of view space where coverage ends and where `depth`, of the range `range`, jumps.
    pub(crate) fn of(normal: &Vector3Planes, mask: &Mask, depth: Option<(&Plane, f32)>) -> Self {
        let (width, height) = (mask.width(), mask.height());
        let mut found = Self::default();
        for y in (0..height).step_by(height.div_ceil(LINES).max(1)) {
            let line = RowOrColumn {
                covered: mask.row(y),
                depth: depth.map(|(depth, range)| (depth.row(y), range)),
                normal: &|i| normal.x.at(i, y),
            };
            line.scan(&mut found, 0);
        }
        // Upward, as y of normals is.
        for x in (0..width).step_by(width.div_ceil(LINES).max(1)) {
            let upward = |i: usize| height - 1 - i;
            let covered: Vec<bool> = (0..height).map(|i| mask.at(x, upward(i))).collect();
            let depths = depth.map(|(depth, range)| {
                let depths = (0..height).map(|i| depth.at(x, upward(i)));
                (depths.collect::<Vec<f32>>(), range)
            });
            let line = RowOrColumn {
                covered: &covered,
                depth: depths.as_ref().map(|(depths, range)| (&depths[..], *range)),
                normal: &|i| normal.y.at(x, upward(i)),
            };
            line.scan(&mut found, 1);
        }
        found
    }

    /// Whether x and y are reversed, as far as outlines show: those of coverage alone, or also jumps of depth that rises or
    /// falls away from the viewer.
    pub(crate) fn reversed(&self, rises: Option<bool>) -> [Option<bool>; 2] {
        let jumps = match rises {
            Some(true) => &self.lower,
            Some(false) => &self.higher,
            None => &Votes::default(),
        };
        [0, 1].map(|axis| Votes::points_inward([&self.ends, jumps], axis))
    }

    /// Whether outlines show these axes reversed, of depth that rises or falls; `None` where they show too little.
    pub(crate) fn agree(&self, rises: bool, axes: [bool; 2]) -> Option<bool> {
        let shown = self.reversed(Some(rises));
        let mut pairs = shown.iter().zip(axes);
        shown
            .iter()
            .any(Option::is_some)
            .then(|| pairs.all(|(shown, axis)| shown.is_none_or(|shown| shown == axis)))
    }
}

/// A row or a column of the picture, along an axis of its normals.
struct RowOrColumn<'a> {
    covered: &'a [bool],
    /// Depth, and its range.
    depth: Option<(&'a [f32], f32)>,
    /// The component of the normal along the line.
    normal: &'a dyn Fn(usize) -> f32,
}

impl RowOrColumn<'_> {
    fn scan(&self, found: &mut Silhouettes, axis: usize) {
        let normal = |i: usize| f64::from((self.normal)(i));
        // The sample beside an outline may be a mean over both sides: the next one is looked at.
        for (from, covered) in self.covered.windows(6).enumerate() {
            let i = from + 3;
            match *covered {
                [_, true, true, false, false, _] => found.ends.add(axis, true, normal(i - 2)),
                [_, false, false, true, true, _] => found.ends.add(axis, false, normal(i + 1)),
                [true, true, true, true, true, true] => self.jump(i, found, axis),
                _ => {}
            }
        }
    }

    /// Adds the normals on both sides if depth jumps beside sample `i`.
    fn jump(&self, i: usize, found: &mut Silhouettes, axis: usize) {
        let Some((depth, range)) = self.depth else {
            return;
        };
        let [a, b, c, d] = [i - 3, i - 2, i + 1, i + 2].map(|i| depth[i]);
        let slope = (b - a).abs().max((d - c).abs());
        // Comparisons with NaN are false: no jump.
        if (c - b).abs() > JUMP_OF_RANGE * range && (c - b).abs() > JUMP * slope {
            let [before, after] = [i - 2, i + 1].map(|i| f64::from((self.normal)(i)));
            let (lower, higher) = match b < c {
                true => (&mut found.lower, &mut found.higher),
                false => (&mut found.higher, &mut found.lower),
            };
            lower.add(axis, true, before);
            higher.add(axis, false, after);
        }
    }
}
