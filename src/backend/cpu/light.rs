//! Passes that make colours.

use super::ROWS_PER_TASK;
use super::passes::map_covered;
use crate::frame::{ColorPlanes, Frame, Mask, Plane};
use crate::light::radiance_scaling::scaling;
use crate::params::ScalingParams;
use crate::shape::curvature::mapped_curvature;
use rayon::prelude::*;

/// Weights of linear red, green and blue in luminance, Rec. 709, where a file names no primaries.
const REC709_LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

pub(super) fn luminance_weights(frame: &Frame) -> [f32; 3] {
    frame.source.luminance_weights.unwrap_or(REC709_LUMINANCE)
}

#[inline(always)]
pub(super) fn luminance(rgb: [f32; 3], weights: [f32; 3]) -> f32 {
    rgb[0] * weights[0] + rgb[1] * weights[1] + rgb[2] * weights[2]
}

/// Radiance scaling of a finished picture: intensity is its luminance over the white level.
pub(super) struct Scaler {
    pub(super) params: ScalingParams,
    pub(super) gain: f32,
    pub(super) white: f32,
    pub(super) weights: [f32; 3],
}

impl Scaler {
    /// The scaled picture. Uncovered pixels, and those where curvature is 0, keep their bits.
    pub(super) fn scale(&self, color: &ColorPlanes, trace: &Plane, mask: &Mask) -> ColorPlanes {
        let width = mask.width();
        let mut scaled = color.clone();
        scaled
            .r
            .samples_mut()
            .par_chunks_mut(width)
            .zip(scaled.g.samples_mut().par_chunks_mut(width))
            .zip(scaled.b.samples_mut().par_chunks_mut(width))
            .enumerate()
            .with_min_len(ROWS_PER_TASK)
            .for_each(|(y, ((r, g), b))| {
                let (covered, trace) = (mask.row(y), trace.row(y));
                for x in mask.span(y).filter(|&x| covered[x] && trace[x] != 0.0) {
                    let sigma = self.sigma([r[x], g[x], b[x]], trace[x]);
                    for channel in [&mut *r, &mut *g, &mut *b] {
                        channel[x] = (channel[x] * sigma).clamp(-f32::MAX, f32::MAX);
                    }
                }
            });
        scaled
    }

    #[inline(always)]
    fn sigma(&self, rgb: [f32; 3], trace: f32) -> f32 {
        let exponent = self.params.scaling * mapped_curvature(trace, self.gain);
        let intensity = luminance(rgb, self.weights) / self.white;
        scaling(intensity, exponent, self.params.invariant_point)
    }
}

/// Display colours, sRGB-encoded 0..1, of [LW] figure 6.
mod palette {
    pub(super) const NEUTRAL: [f32; 3] = [0.90, 0.90, 0.88];
    pub(super) const CONCAVE: [f32; 3] = [0.86, 0.22, 0.08];
    pub(super) const CONVEX: [f32; 3] = [0.08, 0.32, 0.78];
    pub(super) const BACKGROUND: [f32; 3] = [1.0, 1.0, 1.0];
}

/// The curvature display: silhouettes and creases black, concave warm, convex cold, plane neutral,
/// background white. Values are display-referred: to be written without a view transform.
pub(super) fn curvature_display(
    trace: &Plane,
    conductance: &Plane,
    mask: &Mask,
    gain: f32,
) -> ColorPlanes {
    let [r, g, b] = map_covered(mask, |y| {
        let (trace, open) = (trace.row(y), conductance.row(y));
        move |x| {
            let kappa = mapped_curvature(trace[x], gain);
            let toward = if kappa >= 0.0 {
                palette::CONVEX
            } else {
                palette::CONCAVE
            };
            let blend = |neutral: f32, toward: f32| neutral + kappa.abs() * (toward - neutral);
            std::array::from_fn(|i| open[x] * blend(palette::NEUTRAL[i], toward[i]))
        }
    });
    let mut display = ColorPlanes { r, g, b };
    let channels = [&mut display.r, &mut display.g, &mut display.b];
    for (plane, background) in channels.into_iter().zip(palette::BACKGROUND) {
        for (sample, &covered) in plane.samples_mut().iter_mut().zip(mask.plane().samples()) {
            if !covered {
                *sample = background;
            }
        }
    }
    display
}
