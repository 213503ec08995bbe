//! The turn and the lens that carry the normals of patches onto the slopes of their depth.

use super::depth_lens::{Lens, LensKind};
use super::depth_samples::{Facet, TILES};
use super::model::wahba;
use super::samples::{quantile, spread_out};
use nalgebra::{Matrix3, Matrix4, Rotation3, SymmetricEigen, Vector3, Vector4};

/// Patches that the scan over the lens, and the choice of its kind, look at.
const SCANNED: usize = 400;
const RANKED: usize = 2_000;
/// Rounds of reweighting: in the scan, after it, and for a mirrored fit.
const SCAN_ROUNDS: usize = 2;
const ROUNDS: usize = 6;
const MIRRORED_ROUNDS: usize = 4;
/// A step of a rotation, in radians, and of the logarithm of a lens that changes nothing any more.
const SETTLED: f64 = 1e-6;
/// Residuals beyond this many medians are left out, and from the second on pulled linearly.
const TRIM: f64 = 4.0;
const HUBER: f64 = 1.5;
/// Residuals below this, about a degree, count alike, so that a picture dominated by one exact plane still lets the
/// rest count.
const FINEST: f64 = 0.02;
/// Residual scale for comparing fits, about three degrees: far larger residuals count as misses.
const COMPARED: f64 = 0.05;
/// Error of a patch's normal on plane surface, and its growth with the bend of the patch: facets under
/// smooth normals, and slopes that change within it.
const FLAT_ERROR: f64 = 0.003;
const BEND_ERROR: f64 = 0.3;
/// A fit is replaced by a later one whose loss is less than this share of its own.
const CLEARLY_BETTER: f64 = 0.8;
/// A rough fit is given up if its loss is more than this many times the least. That counts as no less than `ROUGH`: a
/// lens a hundredth off loses up to 0.01, by which exact depth of a narrow view would choose among equals.
const HOPELESS: f64 = 3.0;
const ROUGH: f64 = 0.03;
/// Facets under smooth normals bias the whole fit one way: the rotation by about this share of the mean residual, the
/// lens by all of it. On the renders tried, the actual error of the lens was between a hundredth and three times this
/// estimate, that of the rotation between a fiftieth and three times.
const TURN_BIAS: f64 = 0.05;
/// Residuals count no more than this towards that mean.
const OUTLYING: f64 = 0.2;
/// Surfaces seen at a flatter angle than this cosine are left out, since their slope changes within a patch.
const GRAZING: f64 = 0.2;

/// A lens and a turn, with how well they fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub(super) lens: Lens,
    /// View from the space of the normal map.
    pub(super) turn: Rotation3<f64>,
    /// Median distance between unit normals.
    pub(super) residual: f64,
    /// Mean loss, from 0 for a perfect fit to 1 for a useless one; unlike a median, it is not satisfied by one plane
    /// that fills most of the picture.
    pub(super) loss: f64,
}

/// Standard errors of a fit, from the scatter between tiles of the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Certainty {
    /// Rotation about its least certain axis, in radians.
    pub(super) turn: f64,
    /// Logarithm of the lens parameter.
    pub(super) lens: f64,
}

/// The weighted cost of a fit, to second order.
pub(super) struct Cost {
    /// Its second derivatives.
    hessian: Matrix4<f64>,
    /// The covariance of its gradient.
    scatter: Matrix4<f64>,
    /// The sum of weights.
    total: f64,
}

impl Cost {
    /// Mean square sine of the normals' deviation from their main direction, along the narrower axis: this constrains
    /// rotation about that direction. Only features in both normals and slopes count.
    pub(super) fn spread(&self) -> f64 {
        let turn: Matrix3<f64> = self.hessian.fixed_view::<3, 3>(0, 0).into_owned();
        SymmetricEigen::new(turn).eigenvalues.min() / self.total.max(f64::MIN_POSITIVE)
    }
}

/// Patches, and their normals in view space by a lens.
struct PatchNormals<'a> {
    patches: &'a [Facet],
    normals: Vec<Vector3<f64>>,
}

impl<'a> PatchNormals<'a> {
    fn by(lens: Lens, patches: &'a [Facet]) -> Self {
        let normals = patches.iter().map(|patch| lens.normal(patch)).collect();
        Self { patches, normals }
    }
}

/// The proper rotation that best maps weighted normals onto those of the slopes (Wahba's problem), or with `mirrored`
/// the best improper one.
fn best_turn(seen: &PatchNormals, weights: &[f64], mirrored: bool) -> Option<Matrix3<f64>> {
    let mut sum = Matrix3::zeros();
    let pairs = seen.patches.iter().zip(&seen.normals);
    for ((patch, normal), &weight) in pairs.zip(weights) {
        sum += weight * normal * patch.normal.transpose();
    }
    wahba(&sum, mirrored)
}

fn residuals(seen: &PatchNormals, turn: &Matrix3<f64>) -> Vec<f64> {
    let pairs = seen.patches.iter().zip(&seen.normals);
    pairs
        .map(|(patch, normal)| (turn * patch.normal - normal).norm())
        .collect()
}

/// Loss of a residual, 0..1 (Geman and McClure).
fn loss(residual: f64) -> f64 {
    let square = residual * residual;
    square / (square + COMPARED * COMPARED)
}

/// Weight of a patch for its shape alone; 1 for a plane.
fn shape_weight(patch: &Facet) -> f64 {
    let relative = BEND_ERROR * patch.bend / FLAT_ERROR;
    1.0 / (1.0 + relative * relative)
}

/// Weights of patches for their shapes and residuals.
fn weights(residuals: &[f64], patches: &[Facet]) -> Vec<f64> {
    let median = quantile(&mut residuals.to_vec(), 0.5);
    let scale = median.max(FINEST);
    let weight = |(&r, patch): (&f64, &Facet)| match r / scale {
        r if r > TRIM => 0.0,
        r => (HUBER / r).min(1.0) * shape_weight(patch),
    };
    residuals.iter().zip(patches).map(weight).collect()
}

/// The turn at a fixed lens, by reweighting.
fn robust_turn(seen: &PatchNormals, rounds: usize, mirrored: bool) -> Option<Matrix3<f64>> {
    let shapes: Vec<f64> = seen.patches.iter().map(shape_weight).collect();
    let mut turn = best_turn(seen, &shapes, mirrored)?;
    for _ in 0..rounds {
        let weights = weights(&residuals(seen, &turn), seen.patches);
        turn = best_turn(seen, &weights, mirrored)?;
    }
    Some(turn)
}

impl Fit {
    /// The best turn at a fixed lens, in some rounds.
    fn at(lens: Lens, patches: &[Facet], rounds: usize) -> Option<Self> {
        let seen = PatchNormals::by(lens, patches);
        let turn = robust_turn(&seen, rounds, false)?;
        Self::new(lens, Rotation3::from_matrix_unchecked(turn), &seen)
    }

    fn new(lens: Lens, turn: Rotation3<f64>, seen: &PatchNormals) -> Option<Self> {
        let mut residuals = residuals(seen, turn.matrix());
        let loss = residuals.iter().map(|r| loss(*r)).sum::<f64>() / seen.patches.len() as f64;
        let residual = quantile(&mut residuals, 0.5);
        let fit = Self {
            lens,
            turn,
            residual,
            loss,
        };
        loss.is_finite().then_some(fit)
    }

    /// A rough fit over a range of the lens: a scan in even steps of the logarithm, then a golden section, both on a few
    /// of the patches.
    pub(super) fn scanned(
        kind: LensKind,
        (low, high): (f64, f64),
        steps: usize,
        patches: &[Facet],
    ) -> Option<Self> {
        let some = spread_out(patches, SCANNED);
        let lens = |log: f64| Lens {
            kind,
            number: log.exp(),
        };
        let cost = |log: f64| {
            let fit = Self::at(lens(log), &some, SCAN_ROUNDS);
            fit.map_or(f64::INFINITY, |fit| fit.loss)
        };
        let (low, high) = (low.ln(), high.ln());
        let step = (high - low) / steps.max(1) as f64;
        let best = (0..=steps)
            .map(|i| low + step * i as f64)
            .map(|log| (cost(log), log))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        let log = golden_section(best.1 - step, best.1 + step, cost);
        Self::at(lens(log), &some, SCAN_ROUNDS)
    }

    /// Those of rough fits that may turn out to be the best, fitted to more of the patches.
    pub(super) fn ranked(rough: &[Fit], patches: &[Facet]) -> Vec<Self> {
        let some = spread_out(patches, RANKED);
        let losses = rough.iter().map(|fit| fit.loss);
        let least = losses.fold(f64::INFINITY, f64::min);
        let most = HOPELESS * least.max(ROUGH);
        let likely = rough.iter().filter(|fit| fit.loss <= most);
        let fitted = likely.filter_map(|fit| Self::at(fit.lens, &some, ROUNDS));
        fitted.collect()
    }

    /// The first of these fits, unless another is clearly better, then polished; and whether one with lines of sight of
    /// the other kind, parallel or not, fits nearly as well.
    pub(super) fn chosen(fits: &[Fit], patches: &[Facet]) -> Option<(Self, bool)> {
        let some = spread_out(patches, RANKED);
        let polished: Vec<Fit> = fits
            .iter()
            .filter_map(|fit| fit.polished(&some).or_else(|| fit.judged_on(&some)))
            .collect();
        let best = Self::best(&polished)?;
        let is_parallel = |fit: &Fit| fit.lens.kind == LensKind::Parallel;
        let mut others = polished
            .iter()
            .filter(|fit| is_parallel(fit) != is_parallel(&best));
        let has_equal = others.any(|fit| CLEARLY_BETTER * fit.loss <= best.loss);
        Some((best.polished(patches).unwrap_or(best), has_equal))
    }

    /// The first of these fits, unless another is clearly better.
    pub(super) fn best(fits: &[Fit]) -> Option<Self> {
        let (first, others) = fits.split_first()?;
        let better = |best: Fit, fit: &Fit| {
            if fit.loss < CLEARLY_BETTER * best.loss {
                *fit
            } else {
                best
            }
        };
        Some(others.iter().fold(*first, better))
    }

    /// Rotation and lens polished together, on patches not seen at a grazing angle.
    pub(super) fn polished(mut self, patches: &[Facet]) -> Option<Self> {
        for _ in 0..12 {
            let weights = weights(&self.residuals(patches), patches);
            let step = self.step(patches, &weights)?;
            self = self.moved(&step);
            if step.norm() < SETTLED {
                break;
            }
        }
        self.judged_on(patches)
    }

    /// The same fit, with how well it fits these patches.
    fn judged_on(&self, patches: &[Facet]) -> Option<Self> {
        Self::new(self.lens, self.turn, &PatchNormals::by(self.lens, patches))
    }

    fn residuals(&self, patches: &[Facet]) -> Vec<f64> {
        residuals(&PatchNormals::by(self.lens, patches), self.turn.matrix())
    }

    fn moved(&self, step: &Vector4<f64>) -> Self {
        Self {
            lens: self.lens.times(step.w.clamp(-0.3, 0.3).exp()),
            turn: Rotation3::new(step.xyz()) * self.turn,
            ..*self
        }
    }

    /// One Gauss-Newton step: a turn, and a change of the logarithm of the lens's number.
    fn step(&self, patches: &[Facet], weights: &[f64]) -> Option<Vector4<f64>> {
        let (mut normal, mut gradient) = (Matrix4::zeros(), Vector4::zeros());
        for (patch, &weight) in patches.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
            let turned = self.turn * patch.normal;
            let (normal_of_slope, slope) = self.lens.normal_and_slope(patch);
            let off = turned - normal_of_slope;
            let mut j = nalgebra::Matrix3x4::zeros();
            j.fixed_view_mut::<3, 3>(0, 0)
                .copy_from(&-turned.cross_matrix());
            j.set_column(3, &-slope);
            normal += weight * j.transpose() * j;
            gradient += weight * j.transpose() * off;
        }
        // A lens parameter without influence keeps its value.
        normal[(3, 3)] += 1e-9 * normal.trace() + f64::MIN_POSITIVE;
        normal.cholesky().map(|c| c.solve(&-gradient))
    }

    /// The patches that this lens does not see at a grazing angle.
    pub(super) fn facing(&self, patches: &[Facet]) -> Vec<Facet> {
        let facing = |p: &&Facet| self.lens.facing(p) > GRAZING;
        patches.iter().filter(facing).copied().collect()
    }

    /// The typical residual of the patches that determine the rotation.
    pub(super) fn telling_residual(&self, patches: &[Facet]) -> f64 {
        telling_median(&self.residuals(patches), patches)
    }

    /// The same for the best mirrored fit with the same lens.
    pub(super) fn mirrored_residual(&self, patches: &[Facet]) -> f64 {
        let seen = PatchNormals::by(self.lens, patches);
        let turn = robust_turn(&seen, MIRRORED_ROUNDS, true);
        turn.map_or(f64::INFINITY, |turn| {
            telling_median(&residuals(&seen, &turn), patches)
        })
    }

    /// The shape of the weighted cost about this fit.
    pub(super) fn cost(&self, patches: &[Facet]) -> Cost {
        let weights = weights(&self.residuals(patches), patches);
        let mut hessian = Matrix4::zeros();
        let mut by_tile = vec![Vector4::zeros(); TILES * TILES];
        for (patch, &weight) in patches.iter().zip(&weights).filter(|(_, w)| **w > 0.0) {
            let turned = self.turn * patch.normal;
            let (normal, slope) = self.lens.normal_and_slope(patch);
            let outer = normal * turned.transpose();
            let turn = Matrix3::from_diagonal_element(normal.dot(&turned))
                - 0.5 * (outer + outer.transpose());
            let mixed = -turned.cross(&slope);
            let mut h = Matrix4::zeros();
            h.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
            h.fixed_view_mut::<3, 1>(0, 3).copy_from(&mixed);
            h.fixed_view_mut::<1, 3>(3, 0).copy_from(&mixed.transpose());
            h[(3, 3)] = slope.norm_squared();
            hessian += weight * h;
            by_tile[patch.tile] -= weight * turned.cross(&normal).push(slope.dot(&turned));
        }
        Cost {
            hessian,
            scatter: by_tile.iter().map(|g| g * g.transpose()).sum(),
            total: weights.iter().sum(),
        }
    }

    /// Standard errors that allow for residuals related within a tile, and for facets; `None` where the fit is no
    /// minimum.
    pub(super) fn certainty(&self, cost: &Cost, patches: &[Facet]) -> Option<Certainty> {
        let mut hessian = cost.hessian;
        hessian[(3, 3)] += 1e-9 * cost.total;
        let inverse = hessian.cholesky()?.inverse();
        let covariance = inverse * cost.scatter * inverse;
        let capped = |r: f64| r.min(OUTLYING);
        let residuals = self.residuals(patches);
        let bias = residuals.into_iter().map(capped).sum::<f64>() / patches.len() as f64;
        let deviation = |m: Matrix3<f64>| SymmetricEigen::new(m).eigenvalues.max().max(0.0).sqrt();
        Some(Certainty {
            turn: deviation(covariance.fixed_view::<3, 3>(0, 0).into_owned())
                .hypot(TURN_BIAS * bias),
            lens: covariance[(3, 3)].max(0.0).sqrt().hypot(bias),
        })
    }
}

/// Median residual, each patch weighted by its normal's deviation from the dominant direction. Otherwise one plane that
/// fills most of a picture, which fits in any case, would hide the rest. Infinite if no normal deviates.
fn telling_median(residuals: &[f64], patches: &[Facet]) -> f64 {
    let moments = patches.iter().map(|p| p.normal * p.normal.transpose());
    let sum: Matrix3<f64> = moments.sum();
    let eigen = SymmetricEigen::new(sum);
    let common = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let lean = |p: &Facet| p.normal.cross(&common).norm_squared();
    let residuals = residuals.iter().copied();
    let mut list: Vec<(f64, f64)> = residuals.zip(patches.iter().map(lean)).collect();
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * list.iter().map(|(_, lean)| lean).sum::<f64>();
    let mut passed = 0.0;
    let middle = list.iter().find(|(_, lean)| {
        passed += lean;
        passed >= half
    });
    middle.map_or(f64::INFINITY, |(residual, _)| *residual)
}

/// The place of the least value of `cost` between two bounds, to a hundredth.
fn golden_section(mut low: f64, mut high: f64, cost: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_a, mut at_b) = (cost(a), cost(b));
    while high - low > 1e-2 {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - ratio * (high - low);
            at_a = cost(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + ratio * (high - low);
            at_b = cost(b);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn lenses_that_fit_much_worse_are_given_up() {
        let lens = Lens {
            kind: LensKind::Planar,
            number: 900.0,
        };
        let patches: Vec<Facet> = (0..40)
            .map(|i| {
                let (x, y) = (f64::from(i % 8) - 3.5, f64::from(i / 8) - 2.0);
                let mut patch = Facet {
                    seen: Vector2::new(100.0 * x, 100.0 * y),
                    depth: 5.0,
                    slope: Vector2::new(3e-4 * y, 2e-4 * x),
                    normal: Vector3::z(),
                    bend: 0.0,
                    tile: 0,
                };
                patch.normal = lens.normal(&patch);
                patch
            })
            .collect();
        let exact = Fit::at(lens, &patches, SCAN_ROUNDS).unwrap();
        assert!(exact.loss < 1e-9);
        let rough = |kind, loss| Fit {
            lens: Lens {
                kind,
                number: 900.0,
            },
            loss,
            ..exact
        };
        let kinds = |losses: [f64; 3]| -> Vec<LensKind> {
            let rough = [LensKind::Planar, LensKind::Ray, LensKind::Parallel]
                .into_iter()
                .zip(losses)
                .map(|(kind, loss)| rough(kind, loss));
            let ranked = Fit::ranked(&rough.collect::<Vec<_>>(), &patches);
            ranked.iter().map(|fit| fit.lens.kind).collect()
        };
        // Three times the least, and three times 0.03 where the least is less.
        assert_eq!(kinds([0.2, 0.59, 0.61]), [LensKind::Planar, LensKind::Ray]);
        assert_eq!(
            kinds([1e-3, 0.089, 0.091]),
            [LensKind::Planar, LensKind::Ray]
        );
        assert_eq!(kinds([0.9, 0.4, 0.1]), [LensKind::Parallel]);
    }
}
