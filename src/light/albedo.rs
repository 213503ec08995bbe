//! Albedo from a picture under unknown light: the picture divided by the best-fitting smooth shading.
//!
//! A diffuse surface under any distant light shows approximately `a + b . n` of its normal n (the first two orders of
//! spherical harmonics hold 9/10 of a cosine lobe's energy; R. Ramamoorthi, P. Hanrahan: An Efficient Representation
//! for Irradiance Environment Maps, 2001). Four numbers are fitted to the luminance of all pixels; the remainder is
//! colour of the surface.

use nalgebra::{Matrix4, Vector4};

/// Sums over pixels for the least-squares fit of the shading.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ShadingFit {
    normal_matrix: Matrix4<f64>,
    right_side: Vector4<f64>,
}

/// Luminance as a function of the normal, `a + b . n`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FittedShading {
    coefficients: [f32; 4],
    /// Lower bound of the shading: below it shadows would burn out.
    floor: f32,
}

/// The fit for estimating albedo, the same for all strips of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AlbedoEstimate {
    /// The divisor of the picture; `None` where the picture is black, and its albedo white.
    pub shading: Option<FittedShading>,
    /// Factor applied after dividing the picture by its shading.
    pub factor: f32,
}

impl AlbedoEstimate {
    /// The albedo of a pixel with this unit normal and colour, divided by its coverage.
    #[inline(always)]
    pub(crate) fn at(&self, normal: [f32; 3], bare: [f32; 3]) -> [f32; 3] {
        let albedo = match self.shading {
            Some(shading) => shading.under(normal, bare),
            None => [1.0; 3],
        };
        albedo.map(|channel| (channel * self.factor).clamp(0.0, 1.0))
    }
}

/// Share of the mean shading below which a fitted value is not trusted.
const DARKEST: f64 = 0.2;

/// Regularisation toward even light, as a share of the pixels: a flat picture has no information about directions.
const RIDGE: f64 = 1e-3;

impl ShadingFit {
    /// Adds one pixel.
    #[inline]
    pub(crate) fn add(&mut self, normal: [f32; 3], luminance: f32) {
        let row = Vector4::new(1.0, normal[0].into(), normal[1].into(), normal[2].into());
        self.normal_matrix += row * row.transpose();
        self.right_side += f64::from(luminance) * row;
    }

    /// The sums of both.
    pub(crate) fn merged(self, other: Self) -> Self {
        Self {
            normal_matrix: self.normal_matrix + other.normal_matrix,
            right_side: self.right_side + other.right_side,
        }
    }

    /// The least-squares shading; `None` without pixels or light.
    pub(crate) fn solved(&self) -> Option<FittedShading> {
        let count = self.normal_matrix[(0, 0)];
        let mean = self.right_side[0] / count;
        if !(count > 0.0 && mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let ridge = Vector4::new(0.0, 1.0, 1.0, 1.0) * (RIDGE * count);
        let matrix = self.normal_matrix + Matrix4::from_diagonal(&ridge);
        let solution = matrix.lu().solve(&self.right_side)?;
        let coefficients = [0, 1, 2, 3].map(|i| solution[i] as f32);
        coefficients
            .iter()
            .all(|c| c.is_finite())
            .then_some(FittedShading {
                coefficients,
                floor: (DARKEST * mean) as f32,
            })
    }
}

impl FittedShading {
    /// The colour of a surface with this normal that shows the colour `bare`.
    #[inline(always)]
    pub(crate) fn under(&self, normal: [f32; 3], bare: [f32; 3]) -> [f32; 3] {
        let per_light = 1.0 / self.at(normal);
        bare.map(|channel| channel * per_light)
    }

    /// The shading at a unit normal, above 0.
    #[inline(always)]
    pub(crate) fn at(&self, n: [f32; 3]) -> f32 {
        let [a, x, y, z] = self.coefficients;
        let shading = a + x * n[0] + y * n[1] + z * n[2];
        if shading > self.floor {
            shading
        } else {
            self.floor.max(f32::MIN_POSITIVE)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normals over the visible half sphere.
    fn normals() -> Vec<[f32; 3]> {
        let grid = (0..900).map(|i| [(i % 30) as f32 / 16.0 - 0.9, (i / 30) as f32 / 16.0 - 0.9]);
        grid.filter(|[x, y]| x * x + y * y < 0.95)
            .map(|[x, y]| [x, y, (1.0 - x * x - y * y).sqrt()])
            .collect()
    }

    #[test]
    fn linear_shading_is_found_whatever_the_colours_do() {
        // Colours independent of normals: a checkerboard of 0.3 and 0.7, mean 0.5.
        let shading = |n: [f32; 3]| 0.6 + 0.2 * n[0] - 0.1 * n[1] + 0.1 * n[2];
        let mut fit = ShadingFit::default();
        for n in normals() {
            for color in [0.3, 0.7] {
                fit.add(n, color * shading(n));
            }
        }
        let found = fit.solved().unwrap();
        for n in normals() {
            let ratio = found.at(n) / (0.5 * shading(n));
            // The ridge, a thousandth of the pixels, changes the fit by less than a hundredth.
            assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
        }
    }

    #[test]
    fn a_plane_is_lit_evenly() {
        let mut fit = ShadingFit::default();
        (0..100).for_each(|_| fit.add([0.0, 0.0, 1.0], 0.4));
        let found = fit.solved().unwrap();
        assert!((found.at([0.0, 0.0, 1.0]) - 0.4).abs() < 1e-4);
        assert!((found.at([0.6, 0.0, 0.8]) - 0.4).abs() < 0.2);
    }

    #[test]
    fn nothing_tells_nothing() {
        assert_eq!(ShadingFit::default().solved(), None);
        let mut black = ShadingFit::default();
        black.add([0.0, 0.0, 1.0], 0.0);
        assert_eq!(black.solved(), None);
    }
}
