//! Lit spheres, also called matcaps: shading painted or photographed on a ball, looked up by normal.

use super::environment_layout::{RIM_PX, on_disc};
use super::texels::Texels;
use crate::frame::ColorPlanes;

/// Colour by view-space normal: a picture of a sphere inscribed in the picture's borders.
#[derive(Debug, Clone, PartialEq)]
pub struct LitSphere {
    texels: Texels,
    is_for_display: bool,
}

impl LitSphere {
    /// The lit sphere in a picture, which need not be square. NaN and negative samples become 0,
    /// infinite ones 65504. Its white is 1, as a display's, unless a sample is above.
    ///
    /// # Panics
    /// If the planes differ in size or are empty.
    pub fn new(color: ColorPlanes) -> Self {
        let sphere = Self {
            texels: Texels::new(&color),
            is_for_display: false,
        };
        let channels = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let is_limited = |channel| sphere.largest_luminance(channel) <= 1.0;
        Self {
            is_for_display: channels.into_iter().all(is_limited),
            ..sphere
        }
    }

    /// The same sphere in light without an upper limit, as files of floating-point numbers hold it: its white is not 1,
    /// however dark it is.
    pub fn scene_linear(self) -> Self {
        Self {
            is_for_display: false,
            ..self
        }
    }

    /// Whether its white is that of a display.
    pub(crate) fn is_for_display(&self) -> bool {
        self.is_for_display
    }

    /// The colour at a unit normal with the components `normal_xy`, x right and y up: bilinear between
    /// pixel centres.
    ///
    /// Positions are kept 1.5 pixels inside the rim, where painted spheres are blended with their background. NaN reads
    /// the centre.
    #[inline]
    pub fn color(&self, normal_xy: [f32; 2]) -> [f32; 3] {
        on_disc(&self.texels, normal_xy)
    }

    /// Columns and rows of its picture.
    pub fn size(&self) -> [usize; 2] {
        [self.texels.width(), self.texels.height()]
    }

    /// Its pixels row by row: red, green, blue and an unused number.
    #[cfg(feature = "gpu")]
    pub(crate) fn texels(&self) -> &[[f32; 4]] {
        self.texels.all()
    }

    /// The largest luminance on the sphere; `weights` are those of linear red, green and blue.
    pub fn largest_luminance(&self, weights: [f32; 3]) -> f32 {
        let (width, height) = (self.texels.width() as f32, self.texels.height() as f32);
        let px = 2.0 / width.min(height);
        // Pixels that a look-up can touch: up to one pixel beyond the largest radius.
        let largest = (1.0 - (RIM_PX - 1.0) * px).max(px);
        let on_sphere = |x: usize, y: usize| {
            let x = (2 * x + 1) as f32 / width - 1.0;
            let y = (2 * y + 1) as f32 / height - 1.0;
            x * x + y * y <= largest * largest
        };
        self.texels.largest_luminance(weights, on_sphere)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    /// n.l in red, 1 in green, n.z in blue; poison off the sphere.
    fn lambert(width: usize, height: usize, l: [f32; 3]) -> LitSphere {
        let plane = |c: usize| {
            Plane::from_fn(width, height, |x, y| {
                let x = (2 * x + 1) as f32 / width as f32 - 1.0;
                let y = 1.0 - (2 * y + 1) as f32 / height as f32;
                let z2 = 1.0 - x * x - y * y;
                let z = z2.max(0.0).sqrt();
                let on_sphere = [(x * l[0] + y * l[1] + z * l[2]).max(0.0), 1.0, z];
                if z2 > 0.0 { on_sphere[c] } else { 1e6 }
            })
        };
        let [r, g, b] = [0, 1, 2].map(plane);
        LitSphere::new(ColorPlanes { r, g, b })
    }

    #[test]
    fn the_sphere_gives_its_shading_back() {
        let l = [0.48, 0.64, 0.6];
        for (width, height) in [(256, 256), (300, 200)] {
            let sphere = lambert(width, height, l);
            for i in 0..2000 {
                // Uniform over the disc, up to a radius of 0.98: within 1.5 of 100 pixels from the rim.
                let radius = 0.98 * (i as f32 / 2000.0).sqrt();
                let (sin, cos) = (2.399_963 * i as f32).sin_cos();
                let (x, y) = (radius * cos, radius * sin);
                let z = (1.0 - radius * radius).sqrt();
                let truth = (x * l[0] + y * l[1] + z * l[2]).max(0.0);
                let [r, g, b] = sphere.color([x, y]);
                // Next to the shadow, where the slope is up to 1.8, a quarter of a pixel of 0.01 is lost. The curvature
                // of z is largest at the rim: px^2 / 8 of 1 / z^3, which at radius 0.98 is 127.
                assert!((r - truth).abs() < 5e-3, "{x}, {y}: {r}, not {truth}");
                assert!((g - 1.0).abs() < 1e-6 && (b - z).abs() < 2e-3);
            }
        }
    }

    #[test]
    fn nothing_is_read_from_beyond_the_rim() {
        let sphere = lambert(64, 64, [0.0, 0.0, 1.0]);
        for i in 0..720 {
            let (sin, cos) = (i as f32).to_radians().sin_cos();
            for length in [0.97, 1.0, 1.02, 50.0, f32::MAX] {
                let [_, g, _] = sphere.color([length * cos, length * sin]);
                assert!((g - 1.0).abs() < 1e-6, "{length} at {i}: {g}");
            }
        }
        assert_eq!(sphere.largest_luminance([0.0, 1.0, 0.0]), 1.0);
        let largest = sphere.largest_luminance([0.0, 0.0, 1.0]);
        assert!(largest > 0.999 && largest <= 1.0, "{largest}");
    }

    #[test]
    fn hostile_normals_and_small_pictures_are_finite() {
        let values = [0.0, 1.0, -1e30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        for (width, height) in [(1, 1), (1, 9), (2, 2), (64, 64)] {
            let sphere = lambert(width, height, [0.0, 0.0, 1.0]);
            for (x, y) in values.iter().flat_map(|x| values.map(|y| (*x, y))) {
                let color = sphere.color([x, y]);
                assert!(color.iter().all(|v| v.is_finite()), "{x}, {y}: {color:?}");
            }
            assert!(sphere.largest_luminance([1.0; 3]) > 0.0, "{width}x{height}");
        }
    }
}
