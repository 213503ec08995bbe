//! The bend of a whole surface, and normals without it.

use super::normals::changed;
use super::sampling::one_in;
use super::{Mask, Vector3Planes};
use crate::kernel::quantile::quantile;
use glam::DVec2;
use nalgebra::{SMatrix, SVector};

/// The slopes of a quadratic surface, `h = a x^2 + b x y + c y^2 + d x + e y`, x right and y up from the middle of the
/// picture in halves of its longer side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quadric {
    /// a to e.
    terms: [f64; 5],
    middle: DVec2,
    half: f64,
}

/// Pixels that lean more than this, in degrees, belong to the relief.
const MOST_LEAN_DEG: f64 = 30.0;
/// Slopes that the fit looks at, about, and the fewest that tell of a bend.
const WANTED: f64 = 200_000.0;
const FEWEST: usize = 100;
/// Rounds of reweighting: 20 settle the fit to 1e-6 of slope.
const ROUNDS: usize = 20;
/// The median of lengths of errors over their standard deviation along an axis, of a normal distribution: sqrt(2 ln 2).
const MEDIAN_LENGTH: f64 = 1.1774;
/// Errors below this are rounding.
const LEAST_ERROR: f64 = 1e-6;

impl Quadric {
    /// The bend that most slopes agree on, by least squares with weights 1 / (1 + (error / sigma)^2), of which sigma is that
    /// of the last round: what stands out weighs little. `None` where too little of the surface faces the viewer.
    pub(crate) fn of(normal: &Vector3Planes, mask: &Mask) -> Option<Self> {
        let (width, height) = (mask.width(), mask.height());
        let longer = width.max(height) as f64;
        let mut bend = Self {
            terms: [0.0; 5],
            middle: 0.5 * DVec2::new(width as f64, height as f64),
            half: 0.5 * longer,
        };
        let area = (width * height) as f64 / WANTED;
        let places = one_in(area, 0..width, 0..height).filter(|&(x, y)| mask.at(x, y));
        let least_z = MOST_LEAN_DEG.to_radians().cos();
        let slopes: Vec<(DVec2, DVec2)> = places
            .map(|(x, y)| (bend.place(x, y), normal.at(x, y)))
            .filter(|(_, n)| n.z >= least_z)
            .map(|(place, n)| (place, -n.truncate() / n.z))
            .collect();
        if slopes.len() < FEWEST {
            return None;
        }
        let mut sigma = f64::INFINITY;
        for _ in 0..ROUNDS {
            bend.terms = bend.refitted(&slopes, sigma)?;
            let error = |(at, slope): &(DVec2, DVec2)| (*slope - bend.slope(*at)).length();
            let mut errors: Vec<f64> = slopes.iter().map(error).collect();
            let median = quantile(&mut errors, 0.5, f64::total_cmp)?;
            sigma = (median / MEDIAN_LENGTH).max(LEAST_ERROR);
        }
        Some(bend)
    }

    fn place(&self, x: usize, y: usize) -> DVec2 {
        let from = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - self.middle;
        DVec2::new(from.x, -from.y) / self.half
    }

    /// Its slope along x and y.
    fn slope(&self, at: DVec2) -> DVec2 {
        let [a, b, c, d, e] = self.terms;
        DVec2::new(2.0 * a * at.x + b * at.y + d, b * at.x + 2.0 * c * at.y + e)
    }

    /// The terms that fit best, by the weights of the last ones.
    fn refitted(&self, slopes: &[(DVec2, DVec2)], sigma: f64) -> Option<[f64; 5]> {
        let (mut left, mut right) = (SMatrix::<f64, 5, 5>::zeros(), SVector::<f64, 5>::zeros());
        for &(at, slope) in slopes {
            let error = (slope - self.slope(at)).length() / sigma;
            let weight = 1.0 / (1.0 + error * error);
            let rows = [
                (SVector::from([2.0 * at.x, at.y, 0.0, 1.0, 0.0]), slope.x),
                (SVector::from([0.0, at.x, 2.0 * at.y, 0.0, 1.0]), slope.y),
            ];
            for (row, slope) in rows {
                left += weight * row * row.transpose();
                right += weight * slope * row;
            }
        }
        Some(left.cholesky()?.solve(&right).into())
    }

    /// Subtracts its slopes: of n, n_z times them is added to x and y, which is no division where n_z is 0.
    pub(crate) fn subtract(&self, normal: &Vector3Planes) -> Vector3Planes {
        changed(normal, |x, y, n| {
            n + (n.z * self.slope(self.place(x, y))).extend(0.0)
        })
    }

    /// How far it leans in the middle, and turns from there to the end of the longer side, in degrees.
    pub(crate) fn in_words(&self) -> String {
        let [a, b, c, d, e] = self.terms;
        let lean = d.hypot(e).atan().to_degrees();
        let [along_x, along_y] = [a, c].map(|along| (2.0 * along).hypot(b));
        let turn = along_x.max(along_y).atan().to_degrees();
        format!(
            "a surface that leans by {lean:.1} degrees and bends by {turn:.1} from its middle is subtracted"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const SIZE: usize = 64;

    /// Normals of slopes at x and y in -1..1, y up.
    fn of_slopes(slope: impl Fn(f64, f64) -> [f64; 2]) -> Vector3Planes {
        Vector3Planes::from_fn(SIZE, SIZE, |x, y| {
            let [x, y] = [x as f64 + 0.5, 63.5 - y as f64].map(|at| at / 32.0 - 1.0);
            let [p, q] = slope(x, y);
            DVec3::new(-p, -q, 1.0).normalize()
        })
    }

    /// h = .05 x^2 - .1 x y + .02 y^2 + .1 x - .2 y has slopes .1 x - .1 y + .1 and -.1 x + .04 y - .2. Letters of slope .5, a
    /// tenth of the surface, lean by 27 degrees: they are outweighed, and what is left is theirs. With all weights 1 they
    /// would pull the fit by a tenth of .5.
    #[test]
    fn a_bend_is_subtracted_and_letters_stay() {
        let is_letter = |x: f64, y: f64| (x * 10.0).rem_euclid(2.0) < 0.2 && y > -0.9;
        let letter = |x, y| if is_letter(x, y) { 0.5 } else { 0.0 };
        let bent = of_slopes(|x, y| {
            let [p, q] = [0.1 * x - 0.1 * y + 0.1, -0.1 * x + 0.04 * y - 0.2];
            [p + letter(x, y), q]
        });
        let mask = Mask::full(SIZE, SIZE);
        let bend = Quadric::of(&bent, &mask).unwrap();
        let left = bend.subtract(&bent);
        let flat = of_slopes(|x, y| [letter(x, y), 0.0]);
        let off = left
            .vectors()
            .zip(flat.vectors())
            .map(|(a, b)| a.distance(b));
        let most = off.fold(0.0, f32::max);
        assert!(most < 2e-3, "{most}");
        // atan(.224) and atan(.141).
        let said = bend.in_words();
        assert!(said.contains("12.6") && said.contains("8.0"), "{said}");
    }

    #[test]
    fn what_faces_away_tells_of_no_bend() {
        let steep = of_slopes(|_, _| [2.0, 0.0]);
        assert!(Quadric::of(&steep, &Mask::full(SIZE, SIZE)).is_none());
        assert!(Quadric::of(&steep, &Mask::full(1, 1)).is_none());
    }
}
