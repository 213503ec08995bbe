//! Planes in half floats: as files store them, or while nothing reads them.

use super::{ColorPlanes, Plane};
use half::f16;
use half::slice::HalfFloatSliceExt;
use half::vec::HalfBitsVecExt;
use rayon::prelude::*;
use std::ops::Range;

/// Samples converted by a task.
const SAMPLES_PER_TASK: usize = 1 << 16;
/// Samples compared together with what they were.
const COMPARED: usize = 1 << 10;

/// A plane of half floats as one of floats, in the memory of `samples`, of which there are as many.
pub(crate) fn widened(halves: &Plane<f16>, mut samples: Vec<f32>) -> Plane {
    let parts = samples.par_chunks_mut(SAMPLES_PER_TASK);
    let parts = parts.zip(halves.samples().par_chunks(SAMPLES_PER_TASK));
    parts.for_each(|(to, from)| from.convert_to_f32_slice(to));
    Plane::from_samples(halves.width(), halves.height(), samples)
}

/// A plane in half floats, if these hold all of its samples, bit for bit.
fn narrowed(plane: &Plane) -> Option<Plane<f16>> {
    let mut halves: Vec<f16> = vec![0_u16; plane.samples().len()].reinterpret_into();
    let parts = halves.par_chunks_mut(SAMPLES_PER_TASK);
    let parts = parts.zip(plane.samples().par_chunks(SAMPLES_PER_TASK));
    let are_held = parts
        .flat_map_iter(|(to, from)| to.chunks_mut(COMPARED).zip(from.chunks(COMPARED)))
        .all(|(to, from)| {
            to.convert_from_f32_slice(from);
            let mut again = [0.0; COMPARED];
            to.convert_to_f32_slice(&mut again[..from.len()]);
            let differ = from
                .iter()
                .zip(&again)
                .map(|(a, b)| a.to_bits() ^ b.to_bits());
            differ.fold(0, |all, bits| all | bits) == 0
        });
    are_held.then(|| Plane::from_samples(plane.width(), plane.height(), halves))
}

/// A plane put away: in half floats, if these hold all of its samples.
enum Stowed {
    Halves(Plane<f16>),
    Floats(Plane),
}

impl Stowed {
    fn new(plane: Plane, reuse: impl FnOnce(Plane)) -> Self {
        let Some(halves) = narrowed(&plane) else {
            return Self::Floats(plane);
        };
        reuse(plane);
        Self::Halves(halves)
    }
}

/// A picture put away.
pub(crate) struct StowedColors([Stowed; 3]);

impl StowedColors {
    /// `reuse` gets the planes that are no longer needed.
    pub(crate) fn new(ColorPlanes { r, g, b }: ColorPlanes, reuse: impl Fn(Plane)) -> Self {
        Self([r, g, b].map(|plane| Stowed::new(plane, &reuse)))
    }

    /// Copies columns of row `y` of the channel `k`.
    pub(crate) fn copy(&self, k: usize, y: usize, columns: Range<usize>, to: &mut [f32]) {
        match &self.0[k] {
            Stowed::Halves(plane) => plane.row(y)[columns].convert_to_f32_slice(to),
            Stowed::Floats(plane) => to.copy_from_slice(&plane.row(y)[columns]),
        }
    }

    /// The picture, with planes of `unwritten` where floats take new memory.
    pub(crate) fn taken_out(self, unwritten: impl Fn() -> Plane) -> ColorPlanes {
        let [r, g, b] = self.0.map(|stowed| match stowed {
            Stowed::Halves(plane) => widened(&plane, unwritten().into_samples()),
            Stowed::Floats(plane) => plane,
        });
        ColorPlanes { r, g, b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    /// Samples of more than one task: what half floats hold, among them the least and -0, with one channel of which the
    /// last sample is no half float.
    #[test]
    fn a_picture_put_away_is_the_same_again() {
        let (width, height) = (300, 250);
        let values = [
            1.5,
            -0.0,
            f16::MAX.to_f32(),
            2.0_f32.powi(-24),
            0.0,
            -2048.0,
        ];
        let held = Plane::from_fn(width, height, |x, y| values[(x + y) % values.len()]);
        let mut other = held.clone();
        other.row_mut(height - 1)[width - 1] = 0.1;
        let picture = ColorPlanes {
            r: held.clone(),
            g: other.clone(),
            b: held.clone(),
        };
        let left = RefCell::new(Vec::new());
        let stowed = StowedColors::new(picture.clone(), |plane| left.borrow_mut().push(plane));
        assert_eq!(left.into_inner(), [held.clone(), held.clone()]);
        for (k, plane) in [&picture.r, &picture.g, &picture.b].into_iter().enumerate() {
            let mut row = [9.0; 7];
            stowed.copy(k, 40, 100..107, &mut row);
            assert_eq!(row, plane.row(40)[100..107]);
        }
        let again = stowed.taken_out(|| Plane::filled(width, height, 9.0));
        let bits = |plane: &Plane| {
            plane
                .samples()
                .iter()
                .map(|v| v.to_bits())
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(&again.r), bits(&held));
        assert_eq!(bits(&again.g), bits(&other));
    }
}
