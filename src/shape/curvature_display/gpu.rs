//! The curvature display on the device.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::recording::Recording;
use crate::engine::gpu::wgsl::Number::Color;
use crate::engine::gpu::wgsl::wgsl;
use crate::shape::curvature::gpu::{GainParams, MAPPED_CURVATURE};
use crate::shape::curvature_display::palette;

bindings! {
    CurvatureDisplayBuffers {
        covered: &[u32], conductance: &[f32], trace: &[f32], red: &mut [f32], green: &mut [f32], blue: &mut [f32],
    }
}

/// The curvature display.
pub(crate) static CURVATURE_DISPLAY: Kernel = Kernel::new::<GainParams, CurvatureDisplayBuffers>(
    "CurvatureDisplay",
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
    let shape = run.made.shape.as_ref();
    let shape = shape.expect("the display takes curvature");
    let [width, height] = run.surface.size;
    let gain = run.gain();
    let picture = [(); 3].map(|()| run.take(run.surface.plane_bytes()));
    let [red, green, blue] = &picture;
    run.recorder.over_pixels(
        "display",
        (&CURVATURE_DISPLAY, &[]),
        &GainParams {
            width,
            height,
            gain,
        },
        &CurvatureDisplayBuffers {
            covered: &run.surface.covered,
            conductance: &shape.conductance,
            trace: shape.trace(),
            red,
            green,
            blue,
        },
        [width, height],
    );
    run.made.picture = Some(picture);
}
