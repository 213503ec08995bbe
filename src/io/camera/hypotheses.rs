//! First guesses at a camera: linear fits to all samples and to random handfuls of them.

use super::model::{Model, orthonormal};
use super::samples::SeenPoint;
use nalgebra::{Matrix3, Matrix4, Rotation3, SMatrix, SVector, SymmetricEigen, Vector2, Vector3};

/// Random subsets, as (size, count), one guess each; few of the small ones contain outliers, few of the large ones
/// suffer from noise.
const HANDFULS: [(usize, usize); 2] = [(8, 80), (40, 24)];
/// A cloud thinner than this share of its length is also tried as a plane.
const THIN: f64 = 0.05;

/// Sums of squares of a point cloud about the origin along its principal axes, with those axes: longest first.
pub(super) fn principal_axes(samples: &[SeenPoint]) -> (Vector3<f64>, Matrix3<f64>) {
    let sum: Matrix3<f64> = samples.iter().map(|s| s.point * s.point.transpose()).sum();
    let eigen = SymmetricEigen::new(sum);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let values = Vector3::from_fn(|i, _| eigen.eigenvalues[order[i]].max(0.0));
    let first = eigen.eigenvectors.column(order[0]).into_owned();
    let second = eigen.eigenvectors.column(order[1]).into_owned();
    // Right-handed, so that a rotation read off in these axes stays one.
    let axes = Matrix3::from_columns(&[first, second, first.cross(&second)]);
    (values, axes)
}

/// Guesses for `samples`, in no particular order. The same samples give the same guesses.
///
/// `width` is that of the display window in pixels: where the samples leave the focal length open, values proportional
/// to it are tried.
pub(super) fn hypotheses(samples: &[SeenPoint], width: f64) -> Vec<Model> {
    let mut guesses = Vec::new();
    add_linear_fits(samples, &mut guesses);
    let (extent, axes) = principal_axes(samples);
    let thin = extent.z <= THIN * THIN * extent.x;
    if thin {
        planar_cameras(samples, &axes, width, &mut guesses);
    }
    let mut random = SplitMix(0x5eed_0fca_3e7a_1100);
    for (size, rounds) in HANDFULS {
        for _ in 0..rounds {
            let handful: Vec<SeenPoint> = (0..size)
                .map(|_| samples[random.below(samples.len())])
                .collect();
            guesses.extend(perspective_camera(&handful));
            if thin {
                planar_cameras(&handful, &axes, width, &mut guesses);
            }
        }
    }
    guesses
}

fn add_linear_fits(samples: &[SeenPoint], guesses: &mut Vec<Model>) {
    guesses.extend(perspective_camera(samples));
    if let Some(parallel) = parallel_camera(samples) {
        let bent = |convergence| Model {
            convergence,
            ..parallel
        };
        guesses.extend([0.0, 0.05, 0.15, 0.4].map(bent));
    }
}

/// SplitMix64: a fixed sequence, so that a frame always gives the same camera.
struct SplitMix(u64);

impl SplitMix {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((u128::from(z ^ (z >> 31)) * end as u128) >> 64) as usize
    }
}

/// Centre and size of the picture points, for a linear system without large numbers.
fn picture_frame(samples: &[SeenPoint]) -> Option<(Vector2<f64>, f64)> {
    let count = samples.len() as f64;
    let centre = samples.iter().map(|s| s.seen).sum::<Vector2<f64>>() / count;
    let squares = samples.iter().map(|s| (s.seen - centre).norm_squared());
    let square: f64 = squares.sum();
    let size = (0.5 * square / count).sqrt();
    (size > 0.0).then_some((centre, size))
}

/// The map from `N` homogeneous coordinates to the picture that fits best (direct linear transform),
/// scaled to a last entry of 1. `M` is `3 N`, the number of its entries.
fn homogeneous_map<const N: usize, const M: usize>(
    samples: &[SeenPoint],
    coordinates: impl Fn(&SeenPoint) -> SVector<f64, N>,
) -> Option<SMatrix<f64, 3, N>> {
    let (centre, size) = picture_frame(samples)?;
    let mut system = SMatrix::<f64, M, M>::zeros();
    for sample in samples {
        let x = coordinates(sample);
        let seen = (sample.seen - centre) / size;
        add_equations(&mut system, &(x * x.transpose()), seen);
    }
    let flat = smallest_eigenvector(system)?;
    let w = SMatrix::<f64, 1, N>::from_fn(|_, c| flat[2 * N + c]);
    let row = |i: usize, offset: f64| {
        SMatrix::<f64, 1, N>::from_fn(|_, c| flat[i * N + c]) * size + w * offset
    };
    let map = SMatrix::<f64, 3, N>::from_rows(&[row(0, centre.x), row(1, centre.y), w]);
    // The last coordinate is the 1 of the centroid, which lies in front of the eye.
    let depth = map[(2, N - 1)];
    let scaled = map / depth;
    (depth != 0.0 && scaled.iter().all(|e| e.is_finite())).then_some(scaled)
}

/// Adds the squares of a sample's two equations, `[x, 0, -u x]` and `[0, x, -v x]`.
fn add_equations<const N: usize, const M: usize>(
    system: &mut SMatrix<f64, M, M>,
    outer: &SMatrix<f64, N, N>,
    seen: Vector2<f64>,
) {
    let mut add = |row: usize, column: usize, factor: f64| {
        let mut block = system.fixed_view_mut::<N, N>(row * N, column * N);
        block += outer * factor;
    };
    add(0, 0, 1.0);
    add(1, 1, 1.0);
    add(2, 2, seen.norm_squared());
    for (i, coordinate) in [(0, seen.x), (1, seen.y)] {
        add(i, 2, -coordinate);
        add(2, i, -coordinate);
    }
}

fn smallest_eigenvector<const M: usize>(system: SMatrix<f64, M, M>) -> Option<Vec<f64>> {
    if !system.iter().all(|e| e.is_finite()) {
        return None;
    }
    // nalgebra wants the tridiagonal size proven at compile time; a dynamic matrix needs no proof.
    let dynamic = nalgebra::DMatrix::from_fn(M, M, |r, c| system[(r, c)]);
    let eigen = SymmetricEigen::try_new(dynamic, 1e-14, 500)?;
    let (least, _) = eigen.eigenvalues.argmin();
    Some(eigen.eigenvectors.column(least).iter().copied().collect())
}

/// The perspective camera of a direct linear transform with its principal point moved to zero.
fn perspective_camera(samples: &[SeenPoint]) -> Option<Model> {
    let map = homogeneous_map::<4, 12>(samples, |s| s.point.push(1.0))?;
    let row = |i: usize| map.fixed_view::<1, 3>(i, 0).transpose();
    // The third row is -convergence times the view axis.
    let convergence = row(2).norm();
    if convergence < 1e-9 {
        return None;
    }
    let axis = -row(2) / convergence;
    let across = |i: usize| row(i) - axis * row(i).dot(&axis);
    let (x, y) = (across(0), across(1));
    let scale = (x.norm() * y.norm()).sqrt();
    if scale <= 0.0 {
        return None;
    }
    // A mirrored scene, or noise in a shallow one, shows as an axis of the wrong sign.
    let sign = x.cross(&y).dot(&axis).signum();
    let rows = [x / scale, y / scale, axis * sign].map(|r| r.transpose());
    let rotation = orthonormal(&Matrix3::from_rows(&rows))?;
    let shift = Vector2::new(map[(0, 3)], map[(1, 3)]);
    Some(Model::new(rotation, shift, scale, convergence * sign))
}

/// The parallel projection nearest to an affine map fitted by least squares.
fn parallel_camera(samples: &[SeenPoint]) -> Option<Model> {
    let mut square = Matrix4::zeros();
    let mut right = SMatrix::<f64, 4, 2>::zeros();
    for sample in samples {
        let x = sample.point.push(1.0);
        square += x * x.transpose();
        right += x * sample.seen.transpose();
    }
    if !square.iter().chain(right.iter()).all(|e| e.is_finite()) {
        return None;
    }
    // A plane leaves one direction undetermined; the pseudo-inverse sets it to zero.
    let least = 1e-12 * square.amax();
    let map = square.svd(true, true).solve(&right, least).ok()?;
    let x = map.fixed_view::<3, 1>(0, 0).into_owned();
    let y = map.fixed_view::<3, 1>(0, 1).into_owned();
    let scale = 0.5 * (x.norm() + y.norm());
    if scale <= 0.0 {
        return None;
    }
    let (x, y) = (x / scale, y / scale);
    let rows = [x, y, x.cross(&y)].map(|r| r.transpose());
    let rotation = orthonormal(&Matrix3::from_rows(&rows))?;
    let shift = Vector2::new(map[(3, 0)], map[(3, 1)]);
    Some(Model::new(rotation, shift, scale, 0.0))
}

/// Cameras under which the plane through the first two of `axes` projects onto `samples`.
fn planar_cameras(
    samples: &[SeenPoint],
    axes: &Matrix3<f64>,
    width: f64,
    guesses: &mut Vec<Model>,
) {
    let flat = |s: &SeenPoint| {
        let p = axes.transpose() * s.point;
        Vector3::new(p.x, p.y, 1.0)
    };
    let Some(map) = homogeneous_map::<3, 9>(samples, flat) else {
        return;
    };
    match planar_focal_square(&map) {
        Some(square) => guesses.extend(planar_camera(&map, axes, square.sqrt())),
        None => {
            for share in [0.6, 1.2, 2.5, 6.0] {
                guesses.extend(planar_camera(&map, axes, share * width));
            }
        }
    }
}

/// The square of the focal length that makes the plane's axes equally long and at right angles.
fn planar_focal_square(map: &Matrix3<f64>) -> Option<f64> {
    let (a, b) = (map.column(0), map.column(1));
    let flat = Vector2::new(
        a.x * b.x + a.y * b.y,
        a.x * a.x + a.y * a.y - b.x * b.x - b.y * b.y,
    );
    let deep = Vector2::new(a.z * b.z, a.z * a.z - b.z * b.z);
    let square = -flat.dot(&deep) / deep.norm_squared();
    (square > 0.0 && square.is_finite()).then_some(square)
}

fn planar_camera(map: &Matrix3<f64>, axes: &Matrix3<f64>, focal: f64) -> Option<Model> {
    // Columns of the map are scale times the axes as the view sees them, but for depth, which
    // carries -convergence = -scale / focal.
    let column = |i: usize| {
        let c = map.column(i);
        Vector3::new(c.x, c.y, -focal * c.z)
    };
    let (a, b) = (column(0), column(1));
    let scale = (a.norm() * b.norm()).sqrt();
    if scale <= 0.0 {
        return None;
    }
    let (a, b) = (a / scale, b / scale);
    let view_from_axes = orthonormal(&Matrix3::from_columns(&[a, b, a.cross(&b)]))?;
    let rotation = Rotation3::from_matrix_unchecked(view_from_axes * axes.transpose());
    let shift = Vector2::new(map.m13, map.m23);
    Some(Model::new(*rotation.matrix(), shift, scale, scale / focal))
}
