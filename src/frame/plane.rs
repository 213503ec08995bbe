//! Planes: one quantity, one value per pixel.

use crate::frame::{Mask, Window};
use glam::{DVec3, Vec2, Vec3};
use ndarray::{ArrayView2, ArrayViewMut2};
use rayon::prelude::*;
use std::ops::Range;

/// Most rows of a task: with longer ones, as rayon makes them where all threads are busy, one thread is left alone with
/// the last.
pub(crate) const MOST_ROWS_PER_TASK: usize = 16;

/// One quantity over a rectangle of pixels: row-major, rows contiguous, rows running down.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plane<T = f32> {
    width: usize,
    height: usize,
    samples: Vec<T>,
}

impl<T: Copy> Plane<T> {
    /// A plane with every sample equal to `value`.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self::from_samples(width, height, vec![value; width * height])
    }

    /// A plane over samples already in row-major order.
    ///
    /// # Panics
    /// If `samples` does not hold `width * height` values.
    pub fn from_samples(width: usize, height: usize, samples: Vec<T>) -> Self {
        assert_eq!(
            samples.len(),
            width * height,
            "samples do not fill a {width}x{height} plane"
        );
        Self {
            width,
            height,
            samples,
        }
    }

    /// A plane whose sample at column `x` and row `y` is `sample(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut sample: impl FnMut(usize, usize) -> T) -> Self {
        let mut samples = Vec::with_capacity(width * height);
        for y in 0..height {
            samples.extend((0..width).map(|x| sample(x, y)));
        }
        Self::from_samples(width, height, samples)
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The sample at column `x` of row `y`.
    pub fn at(&self, x: usize, y: usize) -> T {
        self.row(y)[x]
    }

    /// The sample at column `x` of row `y`, if there is one.
    #[inline]
    pub(crate) fn get(&self, x: usize, y: usize) -> Option<T> {
        (x < self.width && y < self.height).then(|| self.samples[y * self.width + x])
    }

    /// The sample of the pixel at a place, if there is one.
    #[inline]
    pub(crate) fn within(&self, at: Vec2) -> Option<T> {
        let is_inside = at.x >= 0.0 && at.y >= 0.0;
        is_inside.then(|| self.get(at.x as usize, at.y as usize))?
    }

    /// Column and row of the pixel at a place (x right, y down, edges of pixels at integers), or nearest to it.
    #[inline]
    pub(crate) fn pixel_at(&self, at: Vec2) -> [usize; 2] {
        // A cast of less than 0 is 0.
        [
            (at.x as usize).min(self.width - 1),
            (at.y as usize).min(self.height - 1),
        ]
    }

    /// The sample there.
    #[inline]
    pub(crate) fn nearest(&self, at: Vec2) -> T {
        let [x, y] = self.pixel_at(at);
        self.at(x, y)
    }

    /// Row `y`, left to right.
    pub fn row(&self, y: usize) -> &[T] {
        &self.samples[y * self.width..(y + 1) * self.width]
    }

    /// Row `y`, left to right, mutable.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.samples[y * self.width..(y + 1) * self.width]
    }

    /// The parts of the rows `rows` inside the columns `columns`, top to bottom.
    pub fn rows_within(
        &self,
        columns: Range<usize>,
        rows: Range<usize>,
    ) -> impl Iterator<Item = &[T]> {
        rows.map(move |y| &self.row(y)[columns.clone()])
    }

    /// All samples, row after row.
    pub fn samples(&self) -> &[T] {
        &self.samples
    }

    /// All samples, row after row, mutable.
    pub fn samples_mut(&mut self) -> &mut [T] {
        &mut self.samples
    }

    /// All samples, row after row.
    pub fn into_samples(self) -> Vec<T> {
        self.samples
    }

    /// The plane of `f(sample)`.
    pub fn map<U: Copy>(&self, f: impl FnMut(T) -> U) -> Plane<U> {
        let samples = self.samples.iter().copied().map(f).collect();
        Plane::from_samples(self.width, self.height, samples)
    }

    /// A plane whose rows, initially zero, are filled by `work(y, row)` in parallel.
    pub(crate) fn of_rows(
        width: usize,
        height: usize,
        work: impl Fn(usize, &mut [T]) + Sync,
    ) -> Self
    where
        T: Default + Send,
    {
        let mut plane = Self::filled(width, height, T::default());
        plane.each_row(work);
        plane
    }

    /// A plane of `sample(x, y)`, rows in parallel.
    pub(crate) fn of_pixels(
        width: usize,
        height: usize,
        sample: impl Fn(usize, usize) -> T + Sync,
    ) -> Self
    where
        T: Default + Send,
    {
        Self::of_rows(width, height, |y, row| {
            let samples = row.iter_mut().enumerate();
            samples.for_each(|(x, own)| *own = sample(x, y));
        })
    }

    /// A plane of `row(y)(x)` where covered, zero elsewhere, rows in parallel.
    pub(crate) fn of_covered<Sample: Fn(usize) -> T>(
        mask: &Mask,
        row: impl Fn(usize) -> Sample + Sync,
    ) -> Self
    where
        T: Default + Send,
    {
        Self::of_rows(mask.width(), mask.height(), |y, samples| {
            let sample = row(y);
            let covered = mask.runs(y).flatten();
            covered.for_each(|x| samples[x] = sample(x));
        })
    }

    /// Changes every sample by that of another plane of this size, rows in parallel.
    pub(crate) fn each_with<U: Copy + Sync>(
        &mut self,
        other: &Plane<U>,
        change: impl Fn(&mut T, U) + Sync,
    ) where
        T: Send,
    {
        self.each_row(|y, row| {
            let samples = row.iter_mut().zip(other.row(y));
            samples.for_each(|(own, &other)| change(own, other));
        });
    }

    /// Calls `work(y, row)` for every row, rows in parallel.
    pub(crate) fn each_row(&mut self, work: impl Fn(usize, &mut [T]) + Sync)
    where
        T: Send,
    {
        in_parallel(&mut self.samples, self.width, &work);
    }

    /// The part of this plane inside `part`, where the plane itself covers `whole`.
    ///
    /// # Panics
    /// If `part` reaches outside `whole`.
    pub fn crop(&self, whole: Window, part: Window) -> Plane<T> {
        assert!(whole.encloses(&part), "crop {part} reaches outside {whole}");
        self.repeated(whole, part)
    }

    /// The part inside `part` of this plane repeated in all directions, where the plane itself covers `whole`.
    pub(crate) fn repeated(&self, whole: Window, part: Window) -> Plane<T> {
        let source = |at: i32, start: i32, length: usize| {
            (i64::from(at) - i64::from(start)).rem_euclid(length.max(1) as i64) as usize
        };
        let (width, height) = (part.width(), part.height());
        let mut samples = Vec::with_capacity(width * height);
        for y in part.y0..part.y1 {
            let row = self.row(source(y, whole.y0, self.height));
            let mut x = source(part.x0, whole.x0, self.width);
            let mut left = width;
            while left > 0 {
                let run = left.min(self.width - x);
                samples.extend_from_slice(&row[x..x + run]);
                (x, left) = (0, left - run);
            }
        }
        Self::from_samples(width, height, samples)
    }

    /// The part of this plane inside `to`, where the plane itself covers `from`; `outside` elsewhere.
    pub fn moved(&self, from: Window, to: Window, outside: T) -> Plane<T> {
        let mut moved = Plane::filled(to.width(), to.height(), outside);
        if let Some(both) = from.common(&to) {
            moved.paste(to, both, self, from);
        }
        moved
    }

    /// Copies the samples inside `part` from `other`, which covers `from`, into this plane, which covers `whole`.
    pub(crate) fn paste(&mut self, whole: Window, part: Window, other: &Plane<T>, from: Window) {
        let columns = |window: Window| {
            let first = (i64::from(part.x0) - i64::from(window.x0)) as usize;
            first..first + part.width()
        };
        for y in part.y0..part.y1 {
            let row = |window: Window| (i64::from(y) - i64::from(window.y0)) as usize;
            self.row_mut(row(whole))[columns(whole)]
                .copy_from_slice(&other.row(row(from))[columns(from)]);
        }
    }

    /// The samples as an array indexed `[row, column]`.
    pub fn view(&self) -> ArrayView2<'_, T> {
        ArrayView2::from_shape((self.height, self.width), &self.samples)
            .expect("a plane is contiguous")
    }

    /// The samples as a mutable array indexed `[row, column]`.
    pub fn view_mut(&mut self) -> ArrayViewMut2<'_, T> {
        ArrayViewMut2::from_shape((self.height, self.width), &mut self.samples)
            .expect("a plane is contiguous")
    }
}

/// Calls `work(y, rows)` for every row of several planes of one size, in parallel.
///
/// # Panics
/// If their sizes differ.
pub(crate) fn each_row_of<const N: usize>(
    planes: [&mut Plane; N],
    work: impl Fn(usize, [&mut [f32]; N]) + Sync,
) {
    let rows = parallel_rows(planes).with_max_len(MOST_ROWS_PER_TASK);
    rows.for_each(|(y, rows)| work(y, rows));
}

/// Every row of several planes of one size, with its number, in parallel.
///
/// # Panics
/// If their sizes differ.
pub(crate) fn parallel_rows<const N: usize>(
    planes: [&mut Plane; N],
) -> impl IndexedParallelIterator<Item = (usize, [&mut [f32]; N])> {
    rows_of(planes).into_par_iter().enumerate()
}

/// Calls `work(y, row, rows)` for every row of a plane and of several others of its size, in parallel.
///
/// # Panics
/// If their sizes differ.
pub(crate) fn each_row_beside<T: Send, const N: usize>(
    plane: &mut Plane<T>,
    others: [&mut Plane; N],
    work: impl Fn(usize, &mut [T], [&mut [f32]; N]) + Sync,
) {
    assert_eq!(
        [plane.width, plane.height],
        [others[0].width, others[0].height]
    );
    let rows = plane.samples.par_chunks_exact_mut(plane.width.max(1));
    let rows = rows.zip(rows_of(others)).with_max_len(MOST_ROWS_PER_TASK);
    rows.enumerate()
        .for_each(|(y, (row, rows))| work(y, row, rows));
}

/// The rows of planes of one size.
fn rows_of<const N: usize>(planes: [&mut Plane; N]) -> Vec<[&mut [f32]; N]> {
    let [width, height] = [planes[0].width, planes[0].height];
    assert!(
        planes
            .iter()
            .all(|p| [p.width, p.height] == [width, height])
    );
    let mut rows = planes.map(|plane| plane.samples.chunks_exact_mut(width.max(1)));
    (0..height)
        .map_while(|_| {
            let row: Vec<_> = rows.iter_mut().filter_map(Iterator::next).collect();
            row.try_into().ok()
        })
        .collect()
}

/// Not generic in `work`, so that rayon is compiled once per sample type.
fn in_parallel<T: Send>(samples: &mut [T], width: usize, work: &(dyn Fn(usize, &mut [T]) + Sync)) {
    let rows = samples.par_chunks_mut(width.max(1));
    let rows = rows.with_max_len(MOST_ROWS_PER_TASK).enumerate();
    rows.for_each(|(y, row)| work(y, row));
}

/// A field of 2-vectors, one plane per component (x right, y up).
#[derive(Debug, Clone, PartialEq)]
pub struct Vector2Planes {
    /// First components.
    pub x: Plane,
    /// Second components.
    pub y: Plane,
}

/// A field of 3-vectors, one plane per component, in the space of the quantity it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Vector3Planes {
    /// First components.
    pub x: Plane,
    /// Second components.
    pub y: Plane,
    /// Third components.
    pub z: Plane,
}

impl Vector2Planes {
    /// Marks unknown motion: it leads outside every picture.
    pub const AWAY: f32 = 1e9;

    /// The vectors of planes that `change` makes of these.
    pub(crate) fn mapped(&self, change: impl Fn(&Plane) -> Plane) -> Self {
        Self {
            x: change(&self.x),
            y: change(&self.y),
        }
    }
}

impl Vector3Planes {
    /// The vectors of three planes, or of one plane used for all components.
    pub(crate) fn of(planes: Vec<Plane>) -> Self {
        let [x, y, z] = three(planes);
        Self { x, y, z }
    }

    /// The vectors of planes that `change` makes of these.
    pub(crate) fn mapped(&self, change: impl Fn(&Plane) -> Plane) -> Self {
        Self {
            x: change(&self.x),
            y: change(&self.y),
            z: change(&self.z),
        }
    }

    /// The vector at column `x` of row `y`.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> DVec3 {
        // Mapping an array of planes is not inlined.
        let at = |plane: &Plane| f64::from(plane.at(x, y));
        DVec3::new(at(&self.x), at(&self.y), at(&self.z))
    }

    /// All vectors, row after row.
    pub(crate) fn vectors(&self) -> impl Iterator<Item = Vec3> {
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|plane| plane.samples().iter());
        x.zip(y).zip(z).map(|((&x, &y), &z)| Vec3::new(x, y, z))
    }

    /// The components of all vectors, row after row, mutable.
    pub(crate) fn components_mut(&mut self) -> impl Iterator<Item = [&mut f32; 3]> {
        let [x, y, z] =
            [&mut self.x, &mut self.y, &mut self.z].map(|plane| plane.samples_mut().iter_mut());
        x.zip(y).zip(z).map(|((x, y), z)| [x, y, z])
    }

    /// Makes all vectors unit but those of length 0.
    pub(crate) fn make_unit(&mut self) {
        let Self { x, y, z } = self;
        each_row_of([x, y, z], |_, [x, y, z]| {
            for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
                let length = (*x * *x + *y * *y + *z * *z).sqrt();
                if length > 0.0 {
                    (*x, *y, *z) = (*x / length, *y / length, *z / length);
                }
            }
        });
    }

    /// Planes of the vectors `vector(x, y)`.
    pub fn from_fn(width: usize, height: usize, vector: impl FnMut(usize, usize) -> DVec3) -> Self {
        let mut vector = vector;
        let all = Plane::from_fn(width, height, |x, y| vector(x, y).as_vec3());
        Self {
            x: all.map(|v| v.x),
            y: all.map(|v| v.y),
            z: all.map(|v| v.z),
        }
    }
}

/// A field of symmetric 2x2 matrices, one plane per distinct entry.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricPlanes {
    /// Entries of row x, column x.
    pub xx: Plane,
    /// The off-diagonal entries.
    pub xy: Plane,
    /// Entries of row y, column y.
    pub yy: Plane,
}

/// Principal curvatures `u >= v` and their mean, per pixel; convex is negative.
#[derive(Debug, Clone)]
pub struct CurvaturePlanes {
    /// The larger principal curvature.
    pub u: Plane,
    /// The smaller principal curvature.
    pub v: Plane,
    /// Their mean.
    pub mean: Plane,
}

impl CurvaturePlanes {
    /// The trace of the Hessian, twice the mean.
    pub(crate) fn trace(&self) -> Plane {
        self.mean.map(|mean| 2.0 * mean)
    }
}

/// Scene-linear colour, one plane per primary, not clamped.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ColorPlanes {
    /// Red.
    pub r: Plane,
    /// Green.
    pub g: Plane,
    /// Blue.
    pub b: Plane,
}

impl ColorPlanes {
    /// Weights of linear red, green and blue in luminance, Rec. 709: the default without primaries in the file.
    pub const REC709_LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

    /// The colour of three planes, or of one grey plane.
    pub(crate) fn of(planes: Vec<Plane>) -> Self {
        let [r, g, b] = three(planes);
        Self { r, g, b }
    }

    /// The colour of planes that `change` makes of these.
    pub(crate) fn mapped(&self, change: impl Fn(&Plane) -> Plane) -> Self {
        Self {
            r: change(&self.r),
            g: change(&self.g),
            b: change(&self.b),
        }
    }

    /// The sample of the pixel in column `x` of row `y`.
    #[inline]
    pub(crate) fn at(&self, x: usize, y: usize) -> [f32; 3] {
        [&self.r, &self.g, &self.b].map(|plane| plane.at(x, y))
    }

    /// One plane as all three channels.
    pub fn grey(plane: Plane) -> Self {
        Self {
            r: plane.clone(),
            g: plane.clone(),
            b: plane,
        }
    }
}

/// Three planes from one or three: grey is repeated.
fn three(mut planes: Vec<Plane>) -> [Plane; 3] {
    let third = planes.pop().expect("a layer has planes");
    match (planes.pop(), planes.pop()) {
        (Some(second), Some(first)) => [first, second, third],
        _ => [third.clone(), third.clone(), third],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_moved_with_its_window() {
        let plane = Plane::from_fn(2, 2, |x, y| (1 + x + 2 * y) as f32);
        let moved = plane.moved(Window::at(-1, 1, 2, 2), Window::at(0, 0, 2, 3), 0.0);
        assert_eq!(moved.samples(), [0.0, 0.0, 2.0, 0.0, 4.0, 0.0]);
    }
}
