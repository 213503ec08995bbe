//! The curvature display on the device.

use crate::gpu::kernels::Kernel;
use crate::gpu::wgsl::Number::Color;
use crate::gpu::wgsl::wgsl;
use crate::plan::recording::Recording;
use crate::shape::curvature::gpu::{GainParams, MAPPED_CURVATURE};
use crate::shape::curvature_display::palette;

/// The curvature display.
pub(crate) static CURVATURE_DISPLAY: Kernel = Kernel::new::<GainParams>(
    "CurvatureDisplay",
    "covered: u32; conductance, trace: f32; red, green, blue: mut f32",
    &[
        MAPPED_CURVATURE,
        wgsl!(
            "curvature_display.wgsl",
            [
                ("NEUTRAL", Color(palette::NEUTRAL)),
                ("CONCAVE", Color(palette::CONCAVE)),
                ("CONVEX", Color(palette::CONVEX)),
                ("BACKGROUND", Color(palette::BACKGROUND))
            ]
        ),
    ],
);

/// Makes the curvature display.
pub(crate) fn display(run: &mut Recording) {
    let params = GainParams { gain: run.gain() };
    run.over_pixels("display", (&CURVATURE_DISPLAY, &[]), &params, &[]);
}
