//! Planes of vectors, made and spoiled.

use glam::DVec3;
use relievo::frame::{Plane, Vector3Planes};

/// The vectors that `field` gives, column and row, as planes.
pub(crate) fn vectors(
    width: usize,
    height: usize,
    field: impl FnMut(usize, usize) -> DVec3,
) -> Vector3Planes {
    let field = Plane::from_fn(width, height, field);
    let plane = |axis: usize| field.map(|v| v[axis] as f32);
    Vector3Planes {
        x: plane(0),
        y: plane(1),
        z: plane(2),
    }
}

pub(crate) fn vector_at(planes: &Vector3Planes, x: usize, y: usize) -> DVec3 {
    DVec3::new(
        planes.x.at(x, y).into(),
        planes.y.at(x, y).into(),
        planes.z.at(x, y).into(),
    )
}

/// The same planes with every vector changed.
pub(crate) fn mapped(planes: &Vector3Planes, change: impl Fn(DVec3) -> DVec3) -> Vector3Planes {
    vectors(planes.x.width(), planes.x.height(), |x, y| {
        change(vector_at(planes, x, y))
    })
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
