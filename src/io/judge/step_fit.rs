//! Whether layers show one surface: steps between its neighbouring points are perpendicular to its normals.
//!
//! `n . A t = 0` holds for all steps `t` with one matrix `A` (3 x 3) that maps the space of the points to that of the
//! normals. For positions `t` is their difference; for depth `d` it is that of `d (u, v, 1)`, with picture coordinates
//! `u` and `v`, and `A` includes the lens; for parallel projections that of `(u, v, d)`.
//!
//! The least eigenvalue of the second moments of `n t^T` over all steps, after whitening those of `n` and of `t` to 1,
//! measures the fit: exactly 0 for a perfect one, about 1 for unrelated layers.

use super::samples_of_layers::{Band, Sampled};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Fewest steps that count as evidence.
const FEWEST: usize = 100;
/// Adjacent normals with a smaller cosine between them are on an edge.
const SMOOTH: f64 = 0.95;
/// A step this many times as long as three quarters of all is an edge.
const EDGE: f64 = 10.0;
/// Share of the steps along which the layer must change: masks do at their edges alone.
const CHANGING: f64 = 0.15;
/// Second moments along one axis below this share of those along another are no evidence.
const FLAT: f64 = 1e-10;

/// Interpretation of a layer's numbers as points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PointReading {
    /// They are positions.
    Positions,
    /// They are distances along the view axis.
    Depth,
    /// They are one over such distances.
    InverseDepth,
    /// They are depth of a parallel projection.
    ParallelDepth,
}

/// A normal and a step to the neighbour.
struct NeighbourStep {
    normal: Vector3<f64>,
    /// Difference of the layer's numbers.
    change: f64,
    step: Vector3<f64>,
}

/// Misfit of `layer`, read as `points`, to the surface with these `normals`, 0..1; `None` without enough evidence. Both
/// hold the same pixels; `normal` decodes the stored normals.
pub(crate) fn misfit(
    normals: &Sampled,
    normal: impl Fn(Vector3<f64>) -> Option<Vector3<f64>>,
    layer: &Sampled,
    points: PointReading,
) -> Option<f64> {
    if normals.window != layer.window {
        return None;
    }
    let size = [layer.window.width() as f64, layer.window.height() as f64];
    let mut steps = Vec::new();
    for (normals, band) in normals.bands.iter().zip(&layer.bands) {
        let point = |x: usize, y: usize| point(band, points, size, [x, y]);
        for [x, y] in band.pixels() {
            let Some((n0, (p0, v0))) = normal(normals.at(x, y)).zip(point(x, y)) else {
                continue;
            };
            for [x, y] in [[x + 1, y], [x, y + 1]] {
                if x >= band.width() || y >= band.height() {
                    continue;
                }
                let other = normal(normals.at(x, y)).zip(point(x, y));
                if let Some((n1, (p1, v1))) = other.filter(|(n1, _)| n0.dot(n1) > SMOOTH) {
                    steps.push(NeighbourStep {
                        normal: n0 + n1,
                        change: (v1 - v0).norm(),
                        step: p1 - p0,
                    });
                }
            }
        }
    }
    least_moment(&without_edges(steps)?)
}

/// The point at a pixel, and the layer's value there.
fn point(
    band: &Band,
    points: PointReading,
    size: [f64; 2],
    [x, y]: [usize; 2],
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let longest = size[0].max(size[1]);
    let u = (x as f64 + 0.5 - size[0] / 2.0) / longest;
    let v = ((band.top + y) as f64 + 0.5 - size[1] / 2.0) / longest;
    let stored = band.at(x, y);
    let is_one =
        stored.iter().all(|c| c.is_finite() && c.abs() < 1e9) && stored != Vector3::zeros();
    let ray = Vector3::new(u, v, 1.0);
    is_one.then(|| {
        let point = match points {
            PointReading::Positions => stored,
            PointReading::Depth => ray * stored.x,
            PointReading::InverseDepth => ray / stored.x,
            PointReading::ParallelDepth => Vector3::new(u, v, stored.x),
        };
        (point, stored)
    })
}

fn without_edges(mut steps: Vec<NeighbourStep>) -> Option<Vec<NeighbourStep>> {
    steps.retain(|step| step.step.iter().all(|c| c.is_finite()));
    let changes = steps.iter().map(|step| step.change);
    let changes: Vec<f64> = changes.filter(|change| *change > 0.0).collect();
    if (changes.len() as f64) < CHANGING * steps.len() as f64 {
        return None;
    }
    let most_change = EDGE * usual(changes)?;
    let longest = EDGE * usual(steps.iter().map(|step| step.step.norm()).collect())?;
    steps.retain(|step| step.change <= most_change && step.step.norm() <= longest);
    (steps.len() >= FEWEST).then_some(steps)
}

/// The 75th percentile of `values`; `None` for too few.
fn usual(mut values: Vec<f64>) -> Option<f64> {
    if values.len() < FEWEST {
        return None;
    }
    let place = values.len() * 3 / 4;
    Some(*values.select_nth_unstable_by(place, f64::total_cmp).1)
}

/// The least second moment of `n t^T` in any direction, with those of `n` and `t` made 1.
fn least_moment(steps: &[NeighbourStep]) -> Option<f64> {
    let of_normals = whitening(steps.iter().map(|step| step.normal))?;
    let of_steps = whitening(steps.iter().map(|step| step.step))?;
    let mut moments = SMatrix::<f64, 9, 9>::zeros();
    for step in steps {
        let (n, t) = (of_normals * step.normal, of_steps * step.step);
        let row = SVector::<f64, 9>::from_fn(|i, _| n[i / 3] * t[i % 3]);
        moments.ger(1.0 / steps.len() as f64, &row, &row, 1.0);
    }
    let moments = moments.iter().all(|m| m.is_finite()).then_some(moments)?;
    Some(moments.symmetric_eigenvalues().min().max(0.0))
}

/// Transform of vectors to unit second moments; `None` if they lie in a plane.
fn whitening(vectors: impl Iterator<Item = Vector3<f64>>) -> Option<Matrix3<f64>> {
    let (mut moments, mut count) = (Matrix3::zeros(), 0.0);
    for v in vectors {
        moments += v * v.transpose();
        count += 1.0;
    }
    moments /= count;
    let eigen = moments
        .iter()
        .all(|m| m.is_finite())
        .then(|| moments.symmetric_eigen())?;
    let (least, most) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
    let scale = eigen.eigenvalues.map(|value| value.sqrt().recip());
    (least > FLAT * most && least > 0.0)
        .then(|| Matrix3::from_diagonal(&scale) * eigen.eigenvectors.transpose())
}
