//! The mask: where samples exist.

use super::sampling::{SampleLattice, one_in};
use crate::frame::{Plane, Window};
use std::ops::Range;

/// The pixels that show a surface. Absence is marked only here: samples outside the mask are undefined, and no kernel
/// reads them.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    covered: Plane<bool>,
    spans: Vec<Range<usize>>,
    count: usize,
}

impl Mask {
    /// The mask of a plane that is true where there is a surface.
    pub fn new(covered: Plane<bool>) -> Self {
        let spans: Vec<_> = (0..covered.height())
            .map(|y| covered_span(covered.row(y)))
            .collect();
        let count = covered.samples().iter().filter(|&&c| c).count();
        Self {
            covered,
            spans,
            count,
        }
    }

    /// A mask with every pixel covered.
    pub fn full(width: usize, height: usize) -> Self {
        Self::new(Plane::filled(width, height, true))
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.covered.width()
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.covered.height()
    }

    /// Row `y`: true where covered.
    pub fn row(&self, y: usize) -> &[bool] {
        self.covered.row(y)
    }

    /// The shortest range of columns with all covered pixels of row `y`; empty if there are none.
    pub fn span(&self, y: usize) -> Range<usize> {
        self.spans[y].clone()
    }

    /// The runs of covered pixels in row `y`, left to right.
    pub fn runs(&self, y: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let (row, span) = (self.row(y), self.span(y));
        let mut from = span.start;
        std::iter::from_fn(move || {
            let start = from + length_of(&row[from..span.end], false);
            let end = start + length_of(&row[start..span.end], true);
            from = end;
            (end > start).then_some(start..end)
        })
    }

    /// The ranges before, between and after the runs of row `y`, left to right; some may be empty.
    pub fn gaps(&self, y: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let width = self.width();
        let mut from = 0;
        let runs = self.runs(y).chain(std::iter::once(width..width));
        runs.map(move |run| std::mem::replace(&mut from, run.end)..run.start)
    }

    /// Whether the pixel at column `x` of row `y` is covered.
    pub fn at(&self, x: usize, y: usize) -> bool {
        self.covered.at(x, y)
    }

    /// Whether there is a pixel at column `x` of row `y`, and covered.
    #[inline]
    pub(crate) fn has(&self, x: usize, y: usize) -> bool {
        self.covered.get(x, y) == Some(true)
    }

    /// Number of covered pixels.
    pub fn count(&self) -> usize {
        self.count
    }

    /// About `wanted` covered pixels, evenly spread over the picture and the same at every call; all of them, row by row,
    /// if there are no more.
    pub(crate) fn sample(&self, wanted: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let Extent { columns, rows, .. } = Extent::of(self);
        let area = self.count as f64 / wanted.max(1) as f64;
        one_in(area, columns, rows).filter(|&(x, y)| self.at(x, y))
    }

    /// The coverage as a plane.
    pub fn plane(&self) -> &Plane<bool> {
        &self.covered
    }

    /// The part inside `part` of the mask repeated in all directions, where the mask itself covers `whole`.
    pub(crate) fn repeated(&self, whole: Window, part: Window) -> Mask {
        Mask::new(self.covered.repeated(whole, part))
    }

    /// The part of the mask inside `part`, where the mask itself covers `whole`.
    pub fn crop(&self, whole: Window, part: Window) -> Mask {
        Mask::new(self.covered.crop(whole, part))
    }
}

/// The covered pixels of a picture, known as a whole or some rows at a time: the least window that holds them, and how
/// many they are.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Extent {
    columns: Range<usize>,
    rows: Range<usize>,
    count: usize,
}

impl Extent {
    pub(crate) fn of(mask: &Mask) -> Self {
        let mut extent = Self::default();
        extent.add(mask, 0..mask.height(), 0);
        extent
    }

    /// Adds the rows `rows` of a strip whose first row is row `top` of the picture; strips come from top to bottom.
    pub(crate) fn add(&mut self, mask: &Mask, rows: Range<usize>, top: usize) {
        let covered = |y| mask.row(y).iter().filter(|&&covered| covered).count();
        self.count += rows.clone().map(covered).sum::<usize>();
        for y in rows {
            let span = mask.span(y);
            if span.is_empty() {
                continue;
            }
            if self.rows.is_empty() {
                (self.columns, self.rows) = (span.clone(), top + y..top + y);
            }
            self.columns = self.columns.start.min(span.start)..self.columns.end.max(span.end);
            self.rows.end = top + y + 1;
        }
    }

    /// A lattice over it that takes a bounded number of its pixels.
    pub(crate) fn lattice(&self) -> SampleLattice {
        SampleLattice::of(self.columns.clone(), self.rows.clone(), self.count)
    }
}

/// Number of leading pixels whose coverage equals `covered`.
fn length_of(row: &[bool], covered: bool) -> usize {
    const AT_ONCE: usize = 32;
    let (chunks, _) = row.as_chunks::<AT_ONCE>();
    let whole = chunks.iter().position(|chunk| *chunk != [covered; AT_ONCE]);
    let skipped = whole.unwrap_or(chunks.len()) * AT_ONCE;
    let rest = &row[skipped..];
    skipped
        + rest
            .iter()
            .position(|&c| c != covered)
            .unwrap_or(rest.len())
}

fn covered_span(row: &[bool]) -> Range<usize> {
    match row.iter().position(|&c| c) {
        None => 0..0,
        Some(first) => first..row.iter().rposition(|&c| c).map_or(first, |last| last + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_what_is_covered() {
        // Runs and gaps of every length around the 32 pixels that are tested together.
        for gap in 0..40 {
            for length in 1..70 {
                let row: Vec<bool> = (0..200).map(|x| x % (gap + length) >= gap).collect();
                let mask = Mask::new(Plane::from_samples(200, 1, row.clone()));
                let mut found = vec![false; 200];
                let mut last = 0;
                for run in mask.runs(0) {
                    assert!(run.start >= last && !run.is_empty());
                    assert!(run.end == 200 || !row[run.end]);
                    last = run.end + 1;
                    found[run].fill(true);
                }
                assert_eq!(found, row);
                // Gaps are the complement of runs, each pixel once.
                mask.gaps(0).for_each(|gap| {
                    for covered in &mut found[gap] {
                        assert!(!std::mem::replace(covered, true));
                    }
                });
                assert!(found.iter().all(|&covered| covered));
            }
        }
        assert_eq!(Mask::new(Plane::filled(5, 1, false)).runs(0).count(), 0);
    }

    #[test]
    fn the_extent_is_the_same_from_strips() {
        let mask = Mask::new(Plane::from_fn(9, 8, |x, y| {
            (2..5).contains(&y) && x == y + 1
        }));
        let whole = Extent::of(&mask);
        let expected = Extent {
            columns: 3..6,
            rows: 2..5,
            count: 3,
        };
        assert_eq!(whole, expected);
        let mut strips = Extent::default();
        let window = Window::from_size(9, 8);
        for (takes, gives) in [(0..4, 0..3), (2..8, 1..6)] {
            let part = Window {
                y0: takes.start as i32,
                y1: takes.end as i32,
                ..window
            };
            strips.add(&mask.crop(window, part), gives, takes.start);
        }
        assert_eq!(strips, whole);
        assert_eq!(
            Extent::of(&Mask::new(Plane::filled(5, 2, false))),
            Extent::default()
        );
    }

    #[test]
    fn a_sample_has_covered_pixels_and_about_as_many_as_wanted() {
        // A disk with a radius of 150 pixels, beside a quarter of the picture: 70,686 pixels.
        let disk = |x: usize, y: usize| (x as f64 - 420.0).hypot(y as f64 - 200.0) < 150.0;
        let mask = Mask::new(Plane::from_fn(800, 400, disk));
        let sample: Vec<_> = mask.sample(5_000).collect();
        assert!((4_700..5_300).contains(&sample.len()), "{}", sample.len());
        assert!(sample.iter().all(|&(x, y)| mask.at(x, y)));
        assert!(mask.sample(5_000).eq(sample));
        // No fewer pixels are there than wanted.
        let all = (0..400).flat_map(|y| mask.runs(y).flatten().map(move |x| (x, y)));
        assert!(mask.sample(mask.count()).eq(all));
        assert_eq!(Mask::new(Plane::filled(5, 2, false)).sample(9).count(), 0);
    }
}
