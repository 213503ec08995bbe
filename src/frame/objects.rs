//! Objects: which pixels show the same one.

use super::enlarged::around_pixel;
use super::{Mask, Plane};
use std::collections::BTreeMap;

/// Pixels amid their own object that it needs in one piece, to have two sides: fewer are a thread, a leaf, or the mixture of
/// two numbers along their border.
const FEWEST_AMID: u8 = 16;

/// Borders between objects per covered pixel above which lines along them would be a mesh: squares of 16 pixels have two
/// sides of 16 each.
const MOST_BORDERS: f64 = 1.0 / 8.0;

/// The objects of a frame.
#[derive(Debug, PartialEq)]
pub(crate) enum Objects {
    /// One, or none.
    Alike,
    /// Their number, and for each pixel that of its object, from 1; 0 outside and in pieces too small to count.
    Apart(usize, Plane),
    /// Too many for lines between them.
    Mesh,
}

impl Objects {
    /// Those of any `numbers`, compared bit for bit.
    pub(crate) fn of(numbers: &Plane, mask: &Mask) -> Self {
        let (width, height) = (numbers.width(), numbers.height());
        let piece = pieces(numbers, mask);
        let mut amid = vec![0u8; piece.len()];
        for y in 1..height.saturating_sub(1) {
            for x in 1..width.saturating_sub(1) {
                let i = y * width + x;
                let around = [i - 1, i + 1, i - width, i + width];
                if around.iter().all(|&j| piece[j] == piece[i]) {
                    let amid = &mut amid[piece[i] as usize];
                    *amid = amid.saturating_add(1);
                }
            }
        }
        let counts =
            |i: usize| mask.at(i % width, i / width) && amid[piece[i] as usize] >= FEWEST_AMID;
        let mut names = BTreeMap::new();
        let mut numbered = Plane::filled(width, height, 0.0);
        for (i, number) in numbered.samples_mut().iter_mut().enumerate() {
            if counts(i) {
                let next = names.len() + 1;
                let name = numbers.samples()[i].to_bits();
                *number = *names.entry(name).or_insert(next) as f32;
            }
        }
        if names.len() < 2 {
            return Self::Alike;
        }
        fill(&mut numbered, mask);
        let covered = mask.count();
        match borders(&numbered) as f64 > MOST_BORDERS * covered as f64 {
            true => Self::Mesh,
            false => Self::Apart(names.len(), numbered),
        }
    }
}

/// For each pixel the first one of its connected piece of one number; outside the mask all are pieces too.
pub(crate) fn pieces(numbers: &Plane, mask: &Mask) -> Vec<u32> {
    fn first(of: &mut [u32], mut i: u32) -> u32 {
        while of[i as usize] != i {
            of[i as usize] = of[of[i as usize] as usize];
            i = of[i as usize];
        }
        i
    }
    let width = numbers.width();
    let samples = numbers.samples();
    let is_same = |i: usize, j: usize| {
        let [a, b] = [i, j].map(|i| mask.at(i % width, i / width));
        a == b && samples[i].to_bits() == samples[j].to_bits()
    };
    let mut piece: Vec<u32> = (0..samples.len() as u32).collect();
    for i in 0..samples.len() {
        let left = (!i.is_multiple_of(width)).then(|| i - 1);
        for j in left.into_iter().chain(i.checked_sub(width)) {
            if is_same(i, j) {
                let [a, b] = [i, j].map(|i| first(&mut piece, i as u32));
                piece[a.max(b) as usize] = a.min(b);
            }
        }
    }
    for i in 0..piece.len() {
        piece[i] = piece[piece[i] as usize];
    }
    piece
}

/// Gives a pixel without object one that is beside it, so that specks and mixtures do not break a border.
fn fill(numbered: &mut Plane, mask: &Mask) {
    let whole = numbered.clone();
    let (width, height) = (whole.width(), whole.height());
    numbered.each_row(|y, row| {
        for x in mask.span(y).filter(|&x| mask.at(x, y)) {
            if row[x] != 0.0 {
                continue;
            }
            let beside = around_pixel([x, y], [width, height], 2).map(|[x, y]| whole.at(x, y));
            row[x] = beside
                .into_iter()
                .find(|&number| number != 0.0)
                .unwrap_or(0.0);
        }
    });
}

/// Sides of pixels between two objects.
fn borders(numbered: &Plane) -> usize {
    let width = numbered.width();
    let samples = numbered.samples();
    let differ =
        |i: usize, j: usize| samples[i] != 0.0 && samples[j] != 0.0 && samples[i] != samples[j];
    let of_pixel = |i: usize| {
        let left = !i.is_multiple_of(width) && differ(i, i - 1);
        let above = i >= width && differ(i, i - width);
        usize::from(left) + usize::from(above)
    };
    (0..samples.len()).map(of_pixel).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of `side` pixels, each of another number.
    fn squares(side: usize) -> Objects {
        let number = |x: usize, y: usize| f32::from_bits((x / side + 1000 * (y / side)) as u32);
        Objects::of(&Plane::from_fn(192, 96, number), &Mask::full(192, 96))
    }

    #[test]
    fn many_small_objects_are_a_mesh_and_smaller_ones_none() {
        // Of 8 by 4 squares 7 columns of sides are 96 long, and 3 rows of them 192.
        match squares(24) {
            Objects::Apart(count, _) => assert_eq!(count, 32),
            other => panic!("{other:?}"),
        }
        // 15 columns and 7 rows: (15 * 96 + 7 * 192) / (192 * 96) = .151.
        assert_eq!(squares(12), Objects::Mesh);
        // Squares of 5 have 9 pixels amid them.
        assert_eq!(squares(5), Objects::Alike);
    }

    #[test]
    fn specks_and_mixtures_along_a_border_take_the_side_beside_them() {
        // 2 and 4 with a column of 3 between them, and a pixel of 7, NaN for a number as any other; uncovered below row 30.
        let number = |x: usize, y: usize| match (x, y) {
            (5, 5) => 7.0,
            (..20, _) => 2.0,
            (20, _) => 3.0,
            _ => f32::NAN,
        };
        let mask = Mask::new(Plane::from_fn(40, 40, |_, y| y < 30));
        match Objects::of(&Plane::from_fn(40, 40, number), &mask) {
            Objects::Apart(2, numbered) => {
                let row = |y| numbered.row(y).to_vec();
                let expected: Vec<f32> = (0..40).map(|x| if x < 21 { 1.0 } else { 2.0 }).collect();
                assert_eq!(
                    (row(5), row(29), row(30)),
                    (expected.clone(), expected, vec![0.0; 40])
                );
            }
            other => panic!("{other:?}"),
        }
        for size in [[1, 1], [1, 9], [9, 1], [2, 2]] {
            let [w, h] = size;
            let found = Objects::of(
                &Plane::from_fn(w, h, |x, y| (x + y) as f32),
                &Mask::full(w, h),
            );
            assert_eq!(found, Objects::Alike);
        }
    }
}
