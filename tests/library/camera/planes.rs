//! Planes of vectors, made and spoiled.

use crate::prelude::*;

/// The same planes with every vector changed.
pub(crate) fn mapped(planes: &Vector3Planes, change: impl Fn(DVec3) -> DVec3) -> Vector3Planes {
    let at = |x, y| change(planes.at(x, y));
    Vector3Planes::from_fn(planes.x.width(), planes.x.height(), at)
}

/// Overwrites samples with values that mean nothing: every `columns`-th sample of every 23rd row, each
/// value from `rows` rows below the last.
pub(crate) fn strew(plane: &mut Plane, rows: usize, columns: usize) {
    let strays = [f32::NAN, f32::INFINITY, -1e30, 65504.0, 3e8];
    for (i, value) in strays.into_iter().enumerate() {
        for y in (i * rows..plane.height()).step_by(23) {
            let row = plane.row_mut(y);
            row.iter_mut().step_by(columns).for_each(|s| *s = value);
        }
    }
}
