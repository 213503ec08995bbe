//! The coloured curvature display of [LW] figure 6.

#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod palette;
pub(crate) mod stage;

use crate::frame::memory::Memory;
use crate::frame::rows::map_covered;
use crate::frame::{ColorPlanes, Mask, Plane};
use crate::shape::curvature::mapped_curvature;

/// The curvature display: silhouettes and creases black, concave warm, convex cold, flat neutral, background white.
/// Values are display-referred: write them without a view transform.
pub(crate) fn curvature_display(
    trace: &Plane,
    conductance: &Plane,
    mask: &Mask,
    gain: f32,
    memory: &Memory,
) -> ColorPlanes {
    let [r, g, b] = map_covered(mask, memory, |y| {
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
        plane.each_with(mask.plane(), |sample, covered| {
            *sample = if covered { *sample } else { background };
        });
    }
    display
}
