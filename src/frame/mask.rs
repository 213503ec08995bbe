//! Where samples exist.

use crate::frame::{Plane, Window};
use std::ops::Range;

/// Where a surface was seen. Absence is this mask's job alone: samples outside it have no meaning
/// and no kernel reads them.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    covered: Plane<bool>,
    spans: Vec<Range<usize>>,
    count: usize,
}

impl Mask {
    /// The mask of a plane that is true where a surface was seen.
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

    /// The shortest range of columns that holds all covered pixels of row `y`; empty if there are none.
    pub fn span(&self, y: usize) -> Range<usize> {
        self.spans[y].clone()
    }

    /// Whether the pixel at column `x` of row `y` is covered.
    pub fn at(&self, x: usize, y: usize) -> bool {
        self.covered.at(x, y)
    }

    /// How many pixels are covered.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The coverage as a plane.
    pub fn plane(&self) -> &Plane<bool> {
        &self.covered
    }

    /// The part of the mask inside `part`, where the mask itself covers `whole`.
    pub fn crop(&self, whole: Window, part: Window) -> Mask {
        Mask::new(self.covered.crop(whole, part))
    }
}

fn covered_span(row: &[bool]) -> Range<usize> {
    match row.iter().position(|&c| c) {
        None => 0..0,
        Some(first) => first..row.iter().rposition(|&c| c).map_or(first, |last| last + 1),
    }
}
