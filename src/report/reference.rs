//! The descriptor in double precision: the reference for single-precision results.
//!
//! It starts from the surface (normals, depth) and the frame's mask, occlusion and lengths of normals, so an error of
//! silhouettes, creases, conductance, gradient, diffusion or curvature shows as a difference, and of preparation too
//! where the surface is that of the files. For the same reason the formulas are written
//! anew, not shared with the kernels.

use super::exact_gaps::ExactGaps;
use super::surface::Surface;
use super::weight::{EPSILON, Weight, covered};
use crate::frame::{Frame, Mask, Plane};
use crate::params::{Scale, ShapeParams, SoftThreshold};
use crate::shape::chebyshev::{Spread, coefficients};
use glam::DVec3;
use rayon::prelude::*;

/// A field of 2-vectors in double precision: x right, y up.
pub(super) type Field = [Plane<f64>; 2];

/// Tolerance of the reference's own expansion: far below the precision of f32.
const TOLERANCE: f64 = 1e-13;

/// Steps above which the reference of steps is expanded too, which bounds its run time.
const MOST_STEPS: u32 = 500;

/// Edge weights ([LW] section 4.4). All are 0 outside the mask.
pub(super) struct Edges {
    pub silhouette: Plane<Weight>,
    pub crease: Plane<Weight>,
    /// Conductance: 1 minus the larger of the two.
    pub conductance: Plane<Weight>,
}

impl Edges {
    /// The edges of `surface` in `frame`.
    pub(super) fn of(frame: &Frame, surface: &Surface, params: &ShapeParams) -> Self {
        let mask = &frame.mask;
        // Those drawn, and those that close.
        let silhouettes = match (&surface.depth, &frame.occlusion) {
            (Some(depth), _) => {
                let gaps = ExactGaps::new(frame, surface, depth, params.silhouette);
                covered(mask, |x, y| match is_border(mask, x, y) {
                    true => [Weight::FULL; 2],
                    false => gaps.silhouettes([x, y]),
                })
            }
            (None, Some(map)) => {
                let map = map.map(f64::from);
                let threshold = params.occlusion_silhouette;
                covered(mask, |x, y| [silhouette(&map, mask, [x, y], threshold); 2])
            }
            (None, None) => covered(mask, |x, y| match is_border(mask, x, y) {
                true => [Weight::FULL; 2],
                false => [Weight::default(); 2],
            }),
        };
        let silhouette = silhouettes.map(|[line, _]| line);
        let crease = covered(mask, |x, y| crease(frame, surface, [x, y], params.crease));
        let conductance = covered(mask, |x, y| {
            Weight::conductance(silhouettes.at(x, y)[1], crease.at(x, y))
        });
        Self {
            silhouette,
            crease,
            conductance,
        }
    }

    /// The conductance nearest to `found` that rounding allows.
    ///
    /// The reference diffuses with this one: the ramp of a threshold amplifies the rounding of a logarithm a
    /// hundredfold, and through a nearly closed pixel that would drown the errors of the solver. Differences beyond
    /// rounding are not adopted, and show in all later results.
    pub(super) fn conductance_near(&self, found: &Plane) -> Plane<f64> {
        Plane::from_fn(found.width(), found.height(), |x, y| {
            let Weight { least, most, .. } = self.conductance.at(x, y);
            f64::from(found.at(x, y)).max(least).min(most)
        })
    }
}

/// Whether a neighbour inside the picture is uncovered.
fn is_border(mask: &Mask, x: usize, y: usize) -> bool {
    let (w, h) = (mask.width() as i64, mask.height() as i64);
    around(x, y, w, h).any(|(_, _, i, j, _)| !mask.at(i, j))
}

/// 1 at the border of the coverage, else by the jump of `map` across the pixel: its Sobel slope times the two pixels
/// between left and right.
///
/// Rounding: a value v of the map is off by at most one ulp, v EPSILON, and the sums of three on each side by 0.75
/// times as much; that twice, in both directions, is 2 sqrt(2) 1.75 < 5. The ramp adds that of its bounds.
fn silhouette(
    map: &Plane<f64>,
    mask: &Mask,
    [x, y]: [usize; 2],
    threshold: SoftThreshold,
) -> Weight {
    if is_border(mask, x, y) {
        return Weight::FULL;
    }
    let (w, h) = (map.width() as i64, map.height() as i64);
    let (mut right, mut up, mut largest) = (0.0, 0.0, 0.0_f64);
    for (dx, dy, i, j, weight) in around(x, y, w, h) {
        let value = map.at(i, j);
        right += dx * weight * value;
        up += dy * weight * value;
        largest = largest.max(value.abs());
    }
    let rounding = EPSILON * (5.0 * largest + 4.0 * f64::from(threshold.hi));
    Weight::ramp(2.0 * f64::hypot(right, up) / 8.0, rounding, threshold)
}

/// By the largest angle between the pixel's normal and those of its four neighbours, and across the pixel, or by the
/// angle between two normals whose mean is as short as the pixel's normal before normalisation.
fn crease(
    frame: &Frame,
    surface: &Surface,
    [x, y]: [usize; 2],
    threshold_deg: SoftThreshold,
) -> Weight {
    let normal = |dx: i64, dy: i64| {
        let (i, j) = (x as i64 + dx, y as i64 + dy);
        let (w, h) = (frame.mask.width() as i64, frame.mask.height() as i64);
        let inside = (0..w).contains(&i) && (0..h).contains(&j);
        let (i, j) = (i as usize, j as usize);
        (inside && frame.mask.at(i, j)).then(|| {
            let n = surface.normal.each_ref().map(|plane| plane.at(i, j));
            DVec3::from_array(n).normalize_or_zero()
        })
    };
    let [left, right, up, down] = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| normal(dx, dy));
    let pairs = [left, right, up, down].map(|beside| (normal(0, 0), beside));
    let across = [(left, right), (up, down)];
    let angles = pairs.into_iter().chain(across).filter_map(|(a, b)| {
        let (a, b) = (a?, b?);
        Some(2.0 * (a - b).length().atan2((a + b).length()))
    });
    let between = angles.fold(0.0, f64::max);
    let length = frame
        .normal_length
        .as_ref()
        .map_or(1.0, |l| l.at(x, y).into());
    let within = 2.0 * f64::clamp(length, 0.0, 1.0).acos();
    // Components of unit vectors are off by at most EPSILON; the smaller an angle, the less precise it is when derived
    // from its cosine.
    let rounding = match within > between {
        true => 4.0 * EPSILON / (0.5 * within).sin(),
        false => 8.0 * EPSILON,
    };
    let [angle, rounding] = [within.max(between), rounding].map(f64::to_degrees);
    Weight::ramp(angle, rounding, threshold_deg)
}

/// The depth gradient at every covered pixel, 0 elsewhere ([RS] section 4).
pub(super) fn depth_gradient(frame: &Frame, surface: &Surface, params: &ShapeParams) -> Field {
    let projection = frame.camera.map(|camera| camera.projection);
    let [left, top] = [frame.data_window.x0, frame.data_window.y0].map(f64::from);
    let (f, floor) = (f64::from(params.foreshortening), f64::from(params.min_nz));
    let slope = |x: usize, y: usize| {
        if !frame.mask.at(x, y) {
            return [0.0; 2];
        }
        let n = surface.normal.each_ref().map(|plane| plane.at(x, y));
        let eye = projection.map_or(glam::DVec2::ZERO, |projection| {
            projection.to_eye(left + x as f64 + 0.5, top + y as f64 + 0.5)
        });
        let facing = (n[2] + n[0] * eye.x + n[1] * eye.y).max(floor);
        [-n[0] * facing.powf(-f), -n[1] * facing.powf(-f)]
    };
    let (width, height) = (frame.mask.width(), frame.mask.height());
    [0, 1].map(|axis| Plane::from_fn(width, height, |x, y| slope(x, y)[axis]))
}

/// The largest length of a vector of `field`.
pub(super) fn largest(field: &Field) -> f64 {
    let pairs = field[0].samples().iter().zip(field[1].samples());
    pairs.fold(0.0, |largest: f64, (x, y)| largest.max(x.hypot(*y)))
}

/// Smallest and largest sample of `plane` inside `mask`; [0, 0] if there is none.
pub(super) fn range(plane: &Plane<f64>, mask: &Mask) -> [f64; 2] {
    let covered = plane.samples().iter().zip(mask.plane().samples());
    let range = covered
        .filter(|&(_, &covered)| covered)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], (&v, _)| {
            [lo.min(v), hi.max(v)]
        });
    if range[0] > range[1] { [0.0; 2] } else { range }
}

/// The diffusion operator L of [LW] section 4.3 for given conductances.
pub(super) struct Operator {
    /// `left[x]` joins column x - 1 and x; 0 in the first column.
    left: Plane<f64>,
    /// `above` joins a row and the row above it; 0 in the first row.
    above: Plane<f64>,
}

impl Operator {
    /// The operator with harmonic means of `conductance` at its faces, closed at the picture's border.
    pub(super) fn new(conductance: &Plane<f64>) -> Self {
        let face = |a: f64, b: f64| {
            if a > 0.0 && b > 0.0 {
                2.0 / (a.recip() + b.recip())
            } else {
                0.0
            }
        };
        let c = |x: usize, y: usize| conductance.at(x, y);
        let (w, h) = (conductance.width(), conductance.height());
        let left = |x, y| {
            if x > 0 {
                face(c(x - 1, y), c(x, y))
            } else {
                0.0
            }
        };
        let above = |x, y| {
            if y > 0 {
                face(c(x, y - 1), c(x, y))
            } else {
                0.0
            }
        };
        Self {
            left: Plane::from_fn(w, h, left),
            above: Plane::from_fn(w, h, above),
        }
    }

    /// `combine(g, Lg, out)` for every pixel, stored in `out`.
    fn sweep(
        &self,
        out: &mut Plane<f64>,
        g: &Plane<f64>,
        combine: impl Fn(f64, f64, f64) -> f64 + Sync,
    ) {
        let (w, h) = (g.width(), g.height());
        out.each_row(|y, out| {
            let (at, left, above) = (g.row(y), self.left.row(y), self.above.row(y));
            let north = g.row(y.saturating_sub(1));
            let south = (y + 1 < h).then(|| (g.row(y + 1), self.above.row(y + 1)));
            for x in 0..w {
                let mut flow = above[x] * (north[x] - at[x]);
                if let Some((south, below)) = south {
                    flow += below[x] * (south[x] - at[x]);
                }
                if x > 0 {
                    flow += left[x] * (at[x - 1] - at[x]);
                }
                if x + 1 < w {
                    flow += left[x + 1] * (at[x + 1] - at[x]);
                }
                out[x] = combine(at[x], flow, out[x]);
            }
        });
    }

    /// `(1 + dt L)^count g`, step by step.
    pub(super) fn steps(&self, g: &Plane<f64>, count: u32, time_step: f64) -> Plane<f64> {
        let (mut now, mut next) = (g.clone(), g.clone());
        for _ in 0..count {
            self.sweep(&mut next, &now, |g, lg, _| g + time_step * lg);
            std::mem::swap(&mut now, &mut next);
        }
        now
    }

    /// `exp(time L) g`, by an expansion accurate to 1e-13 of the largest |g|.
    pub(super) fn exponential(&self, g: &Plane<f64>, time: f64) -> Plane<f64> {
        self.expanded(g, Spread::Time(time))
    }

    /// `g` diffused by `spread`, by an expansion accurate to 1e-13 of the largest |g|.
    fn expanded(&self, g: &Plane<f64>, spread: Spread) -> Plane<f64> {
        let a = coefficients(spread, TOLERANCE);
        let mut sum = g.map(|v| a[0] * v);
        let (mut before, mut now) = (g.clone(), g.clone());
        for (k, a) in a.iter().enumerate().skip(1) {
            if k == 1 {
                self.sweep(&mut now, &before, |g, lg, _| -0.25 * lg - g);
            } else {
                self.sweep(&mut before, &now, |g, lg, before| {
                    -0.5 * lg - 2.0 * g - before
                });
                std::mem::swap(&mut now, &mut before);
            }
            let pairs = sum.samples_mut().par_iter_mut().zip(now.samples());
            pairs
                .with_min_len(1 << 14)
                .for_each(|(sum, v)| *sum += a * v);
        }
        sum
    }

    /// `field` diffused according to `params`: exactly for a scale in pixels, in steps for a number of steps.
    pub(super) fn diffused(&self, field: &Field, params: &ShapeParams) -> Field {
        [0, 1].map(|axis: usize| match params.scale {
            Scale::Iterations(count) if count <= MOST_STEPS => {
                self.steps(&field[axis], count, f64::from(params.time_step))
            }
            Scale::Iterations(count) => {
                let time_step = f64::from(params.time_step);
                self.expanded(&field[axis], Spread::Steps { count, time_step })
            }
            Scale::Sigma(_) => self.exponential(&field[axis], params.diffusion_time()),
            Scale::Mixed([a, b]) => {
                let at = |sigma| self.exponential(&field[axis], ShapeParams::time_of(sigma));
                let (fine, coarse) = (at(a), at(b));
                let [a, b] = [a, b].map(f64::from);
                Plane::from_fn(fine.width(), fine.height(), |x, y| {
                    (a * fine.at(x, y) + b * coarse.at(x, y)) / (a + b)
                })
            }
        })
    }
}

/// Trace of the Hessian at every covered pixel: the divergence of the plane fitted to the 3x3 gradients, weighted by
/// conductance, as defined in [`crate::shape::hessian`].
pub(super) fn trace(field: &Field, conductance: &Plane<f64>, mask: &Mask) -> Plane<f64> {
    covered(mask, |x, y| divergence(field, conductance, x, y))
}

/// Regularises a fit to neighbours on one line, as in the kernel.
const RIDGE: f64 = 2e-3;

fn divergence(field: &Field, conductance: &Plane<f64>, x: usize, y: usize) -> f64 {
    let c = |x: usize, y: usize| conductance.at(x, y);
    let (w, h) = (conductance.width() as i64, conductance.height() as i64);
    let open_everywhere = around(x, y, w, h).all(|(_, _, i, j, _)| c(i, j) == 1.0);
    // Away from edges the moments are exactly 8, without the contribution of the ridge.
    let ridge = if open_everywhere { 0.0 } else { RIDGE };
    let (mut xx, mut xy, mut yy) = (ridge, 0.0, ridge);
    let mut rise = [[0.0; 2]; 2];
    for (dx, dy, i, j, weight) in around(x, y, w, h) {
        let weight = weight * c(i, j);
        xx += weight * dx * dx;
        xy += weight * dx * dy;
        yy += weight * dy * dy;
        for axis in 0..2 {
            let step = weight * (field[axis].at(i, j) - field[axis].at(x, y));
            rise[axis][0] += dx * step;
            rise[axis][1] += dy * step;
        }
    }
    let determinant = xx * yy - xy * xy;
    let along_x = (yy * rise[0][0] - xy * rise[0][1]) / determinant;
    let along_y = (xx * rise[1][1] - xy * rise[1][0]) / determinant;
    c(x, y) * (along_x + along_y)
}

/// The eight neighbours as (dx, dy up, column, row, Sobel's weight); the border is repeated.
fn around(
    x: usize,
    y: usize,
    w: i64,
    h: i64,
) -> impl Iterator<Item = (f64, f64, usize, usize, f64)> {
    let offsets = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
    offsets
        .filter(|&offset| offset != (0, 0))
        .map(move |(dx, dy): (i64, i64)| {
            let weight = if dx == 0 || dy == 0 { 2.0 } else { 1.0 };
            let (i, j) = (
                (x as i64 + dx).clamp(0, w - 1),
                (y as i64 - dy).clamp(0, h - 1),
            );
            (dx as f64, dy as f64, i as usize, j as usize, weight)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Vector3Planes;
    use crate::report::engine;
    use crate::report::scenes::Scene;
    use nalgebra::{DMatrix, DVector};

    const W: usize = 6;
    const H: usize = 5;

    /// Conductances from open to closed, with an incomplete barrier.
    fn conductance() -> Plane<f64> {
        Plane::from_fn(W, H, |x, y| match (x, y) {
            (3, 0..=2) => 0.0,
            (1, 3) => 0.0,
            _ => [1.0, 0.3, 1.0, 0.7, 0.05][(x + 2 * y) % 5],
        })
    }

    fn start() -> Plane<f64> {
        Plane::from_fn(W, H, |x, y| ((x * 7 + y * 13) % 11) as f64 / 5.0 - 1.0)
    }

    /// The operator as a matrix, directly from its definition: sum c_ij (g_j - g_i).
    fn matrix() -> DMatrix<f64> {
        let c = conductance();
        let mut l = DMatrix::zeros(W * H, W * H);
        for (i, j) in (0..W * H).flat_map(|i| (0..W * H).map(move |j| (i, j))) {
            let apart = (i % W).abs_diff(j % W) + (i / W).abs_diff(j / W);
            let (a, b) = (c.samples()[i], c.samples()[j]);
            if apart == 1 && a + b > 0.0 {
                l[(i, j)] += 2.0 * a * b / (a + b);
                l[(i, i)] -= 2.0 * a * b / (a + b);
            }
        }
        l
    }

    fn worst(found: &Plane<f64>, exact: &DVector<f64>) -> f64 {
        found
            .samples()
            .iter()
            .zip(exact)
            .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
    }

    #[test]
    fn the_exponential_is_that_of_the_matrix() {
        // By its eigenvectors, since L is symmetric. Eigenvalues are known to 1e-15, which time multiplies.
        let eigen = matrix().symmetric_eigen();
        assert!(
            eigen
                .eigenvalues
                .iter()
                .all(|&v| (-8.0..1e-12).contains(&v))
        );
        let start_vector = DVector::from_column_slice(start().samples());
        for time in [0.0, 0.1, 2.0, 50.0, 5000.0] {
            let grown = DMatrix::from_diagonal(&eigen.eigenvalues.map(|v| (time * v).exp()));
            let exact =
                &eigen.eigenvectors * grown * eigen.eigenvectors.transpose() * &start_vector;
            let found = Operator::new(&conductance()).exponential(&start(), time);
            assert!(
                worst(&found, &exact) < 1e-12 + 1e-15 * time,
                "t {time}: {}",
                worst(&found, &exact)
            );
        }
    }

    #[test]
    fn steps_are_those_of_the_matrix() {
        let step = DMatrix::identity(W * H, W * H) + 0.2 * matrix();
        let mut exact = DVector::from_column_slice(start().samples());
        for _ in 0..17 {
            exact = &step * exact;
        }
        let found = Operator::new(&conductance()).steps(&start(), 17, 0.2);
        assert!(worst(&found, &exact) < 1e-14);
        // Expanded, within its own tolerance.
        let spread = Spread::Steps {
            count: 17,
            time_step: 0.2,
        };
        let expanded = Operator::new(&conductance()).expanded(&start(), spread);
        assert!(worst(&expanded, &exact) < 2e-13);
    }

    #[test]
    fn many_short_steps_come_to_the_exponential() {
        // The error of first-order steps is at most t dt |L|^2 / 2: 2 * 1e-5 * 32.
        let operator = Operator::new(&conductance());
        let (stepped, exact) = (
            operator.steps(&start(), 200_000, 1e-5),
            operator.exponential(&start(), 2.0),
        );
        let exact = DVector::from_column_slice(exact.samples());
        assert!(worst(&stepped, &exact) < 6.4e-4);
    }

    #[test]
    fn the_trace_of_a_linear_field_is_its_divergence() {
        // g = (0.3 x + 0.1 y, 0.1 x - 0.2 y), y up: 0.3 - 0.2, times the pixel's conductance. At the picture's border
        // the repeated row halves a derivative, so only the interior is tested.
        let field = [(0.3, 0.1), (0.1, -0.2)]
            .map(|(a, b)| Plane::from_fn(7, 6, |x, y| a * x as f64 - b * y as f64));
        let open = trace(&field, &Plane::filled(7, 6, 1.0), &Mask::full(7, 6));
        let half = trace(&field, &Plane::filled(7, 6, 0.5), &Mask::full(7, 6));
        for (x, y) in (1..6).flat_map(|x| (1..5).map(move |y| (x, y))) {
            assert!((open.at(x, y) - 0.1).abs() < 1e-14);
            // Moments of 8 * 0.5 against a ridge of 2e-3: 0.05 * 2e-3 / 4 = 2.5e-5.
            assert!((half.at(x, y) - 0.05).abs() < 2.6e-5, "{}", half.at(x, y));
        }
    }

    #[test]
    fn the_range_leaves_out_what_is_not_covered() {
        let plane = Plane::from_samples(3, 1, vec![-1.0, 2.0, 9.0]);
        let mask = Mask::new(Plane::from_samples(3, 1, vec![true, true, false]));
        assert_eq!(range(&plane, &mask), [-1.0, 2.0]);
        assert_eq!(
            range(&plane, &Mask::new(Plane::filled(3, 1, false))),
            [0.0, 0.0]
        );
    }

    #[test]
    fn weights_of_known_edges() {
        // Of a frame of 9 pixels gaps count from 1.5 pixels on and in full from 2.5, at the nearer depth, with a lens of 1.25
        // times its side: 11.25 pixels.
        let step = |px: f64| {
            let normal = Scene::plane(9, 9).frame.normal;
            let far = (3.0 * (1.0 + px / 11.25)) as f32;
            let depth = Plane::from_fn(9, 9, |x, _| if x < 5 { 3.0 } else { far });
            let frame = Frame {
                depth: Some(depth),
                ..Frame::of_normals(normal, Mask::full(9, 9))
            };
            Edges::of(&frame, &Surface::of(&frame), &ShapeParams::default())
        };
        for (px, weight) in [(3.0, 1.0), (2.0, 0.5), (1.5, 0.0)] {
            let edges = step(px);
            let [x3, x4, x5] = [3, 4, 5].map(|x| edges.silhouette.at(x, 4).exact);
            assert!(x3 == 0.0 && (x4 - weight).abs() < 1e-4 && x5 == 0.0);
            for x in [4, 5] {
                assert!((edges.conductance.at(x, 4).exact - (1.0 - weight)).abs() < 1e-4);
            }
        }
        // Between normals at an angle the weight is the ramp of that angle, for any neighbour.
        let bend = |degrees: f64| {
            let angle = |x: usize| if x < 5 { 0.0 } else { degrees.to_radians() };
            let plane = |of: &dyn Fn(f64) -> f64| Plane::from_fn(9, 9, |x, _| of(angle(x)) as f32);
            let normal = Vector3Planes {
                x: plane(&f64::sin),
                y: plane(&|_| 0.0),
                z: plane(&f64::cos),
            };
            let frame = Frame::of_normals(normal, Mask::full(9, 9));
            Edges::of(&frame, &Surface::of(&frame), &ShapeParams::default())
                .crease
                .at(5, 4)
        };
        let SoftThreshold { lo, hi } = ShapeParams::default().crease;
        let half = bend(0.5 * f64::from(lo + hi));
        assert!((half.exact - 0.5).abs() < 1e-6 && half.most - half.least < 1e-4);
        assert_eq!(
            (
                bend(f64::from(lo) - 1.0).exact,
                bend(f64::from(hi) + 1.0).exact
            ),
            (0.0, 1.0)
        );
    }

    #[test]
    fn single_precision_stays_within_its_rounding() {
        // By depth, by an occlusion map and by the border of the mask only.
        let frames = Scene::all(96, 72)
            .into_iter()
            .flat_map(|Scene { frame, .. }| {
                let occlusion = frame
                    .depth
                    .as_ref()
                    .map(|depth| depth.map(|d| (d / 2e3).min(1.0)));
                let [mapped, bare] = [occlusion, None].map(|occlusion| Frame {
                    depth: None,
                    occlusion,
                    ..frame.clone()
                });
                [frame, mapped, bare]
            });
        for frame in frames {
            let shape = ShapeParams::default();
            let edges = Edges::of(&frame, &Surface::of(&frame), &shape);
            let found = engine::layers(&frame, shape).unwrap();
            for (found, exact) in [
                (&found.silhouette, &edges.silhouette),
                (&found.crease, &edges.crease),
                (&found.conductance, &edges.conductance),
            ] {
                for (found, exact) in found.samples().iter().zip(exact.samples()) {
                    let (found, Weight { least, most, .. }) = (f64::from(*found), *exact);
                    let within = least - 1e-7..=most + 1e-7;
                    assert!(within.contains(&found), "{found} {exact:?}");
                }
            }
        }
    }
}
