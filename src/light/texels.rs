//! Pictures for colour look-ups: red, green and blue interleaved, so that one look-up touches few cache lines.

use crate::frame::ColorPlanes;

/// Replacement of infinite samples: the largest half float, at which files clip.
const INFINITE: f32 = 65504.0;

/// Largest sample kept: sums over any picture stay finite.
const MAX_SAMPLE: f32 = 1e30;

/// A colour and one unused value, which make 16 bytes.
pub(crate) type Texel = [f32; 4];

/// A picture of at least one pixel, with finite non-negative samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Texels {
    width: usize,
    height: usize,
    texels: Vec<Texel>,
}

impl Texels {
    /// The picture `color`; NaN and negative samples become 0, infinite ones 65504.
    ///
    /// # Panics
    /// If the planes differ in size or are empty.
    pub(super) fn new(color: &ColorPlanes) -> Self {
        let planes = [&color.r, &color.g, &color.b];
        let (width, height) = (color.r.width(), color.r.height());
        assert!(width > 0 && height > 0, "a picture of no pixels");
        for plane in planes {
            let size = (plane.width(), plane.height());
            assert_eq!(size, (width, height), "planes differ in size");
        }
        let [r, g, b] = planes.map(|plane| plane.samples());
        let texels = r.iter().zip(g).zip(b);
        let texels = texels.map(|((&r, &g), &b)| [sane(r), sane(g), sane(b), 0.0]);
        Self {
            width,
            height,
            texels: texels.collect(),
        }
    }

    /// The picture with the pixel `color(x, y)` at column `x` of row `y`, samples sanitised.
    pub(super) fn from_fn(
        width: usize,
        height: usize,
        mut color: impl FnMut(usize, usize) -> [f32; 3],
    ) -> Self {
        assert!(width > 0 && height > 0, "a picture of no pixels");
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            texels.extend((0..width).map(|x| {
                let [r, g, b] = color(x, y).map(sane);
                [r, g, b, 0.0]
            }));
        }
        Self {
            width,
            height,
            texels,
        }
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn height(&self) -> usize {
        self.height
    }

    /// All texels, row by row.
    #[cfg(feature = "gpu")]
    pub(super) fn all(&self) -> &[Texel] {
        &self.texels
    }

    #[inline(always)]
    pub(super) fn at(&self, x: usize, y: usize) -> Texel {
        self.texels[y * self.width + x]
    }

    pub(super) fn row(&self, y: usize) -> &[Texel] {
        &self.texels[y * self.width..(y + 1) * self.width]
    }

    /// The colour at position (`column`, `row`), integers being pixel centres: bilinear between them, clamped at the
    /// picture's edge. NaN reads the first pixel.
    #[inline]
    pub(super) fn clamped(&self, column: f32, row: f32) -> [f32; 3] {
        let (x, across) = cell(column.clamp(0.0, (self.width - 1) as f32));
        let (y, down) = cell(row.clamp(0.0, (self.height - 1) as f32));
        // Only NaN is below 0.
        let (x, y) = (x.max(0) as usize, y.max(0) as usize);
        let (x1, y1) = ((x + 1).min(self.width - 1), (y + 1).min(self.height - 1));
        let upper = mixed(self.at(x, y), self.at(x1, y), across);
        let lower = mixed(self.at(x, y1), self.at(x1, y1), across);
        rgb(mixed(upper, lower, down))
    }

    /// The largest luminance of the pixels for which `counts(x, y)`; 0 if there are none.
    pub(super) fn largest_luminance(
        &self,
        weights: [f32; 3],
        counts: impl Fn(usize, usize) -> bool,
    ) -> f32 {
        let mut largest = 0.0_f32;
        for y in 0..self.height {
            for (x, texel) in self.row(y).iter().enumerate() {
                let luminance: f32 = texel.iter().zip(weights).map(|(v, w)| v * w).sum();
                if luminance > largest && counts(x, y) {
                    largest = luminance;
                }
            }
        }
        largest
    }
}

/// The integer below a position from -1 up, and the remainder; NaN gives -1 and 0.
#[inline(always)]
pub(super) fn cell(position: f32) -> (i32, f32) {
    // Truncation of a non-negative number rounds down, and needs no call.
    let whole = (position + 1.0) as i32 - 1;
    (whole, (position - whole as f32).max(0.0))
}

/// From `a` at 0 to `b` at 1, exact at both.
#[inline(always)]
pub(crate) fn mixed(a: Texel, b: Texel, t: f32) -> Texel {
    std::array::from_fn(|i| a[i] * (1.0 - t) + b[i] * t)
}

#[inline(always)]
pub(super) fn rgb([r, g, b, _]: Texel) -> [f32; 3] {
    [r, g, b]
}

/// A sanitised sample: finite and non-negative.
pub(crate) fn sane(sample: f32) -> f32 {
    if sample == f32::INFINITY {
        INFINITE
    } else {
        // NaN fails the comparison.
        if sample > 0.0 {
            sample.min(MAX_SAMPLE)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    #[test]
    fn samples_are_finite_and_not_negative() {
        let given = vec![f32::NAN, -1.0, f32::INFINITY, f32::NEG_INFINITY, 1e38, 0.5];
        let plane = Plane::from_samples(3, 2, given);
        let texels = Texels::new(&ColorPlanes {
            r: plane.clone(),
            g: plane.clone(),
            b: plane,
        });
        let kept: Vec<f32> = (0..6).map(|i| texels.at(i % 3, i / 3)[1]).collect();
        assert_eq!(kept, [0.0, 0.0, 65504.0, 0.0, 1e30, 0.5]);
    }

    #[test]
    fn look_ups_are_linear_between_centres_and_constant_beyond() {
        let texels = Texels::from_fn(4, 3, |x, y| [x as f32, y as f32, 1.0]);
        assert_eq!(texels.clamped(1.25, 0.5), [1.25, 0.5, 1.0]);
        assert_eq!(texels.clamped(-3.0, 9.0), [0.0, 2.0, 1.0]);
        assert_eq!(texels.clamped(f32::NAN, f32::INFINITY), [0.0, 2.0, 1.0]);
    }
}
