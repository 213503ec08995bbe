//! The curvature display on the device.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::{COVERAGE, INDEX, Kernel};
use crate::engine::gpu::made::Shape;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::surface::Picture;
use crate::engine::gpu::wgsl::Number::Color;
use crate::engine::gpu::wgsl::wgsl;
use crate::shape::curvature::gpu::{GainParams, MAPPED_CURVATURE};
use crate::shape::curvature_display::palette;

bindings! {
    CurvatureDisplayBuffers { covered, conductance, trace, red, green, blue }
}

/// The curvature display.
pub(crate) static CURVATURE_DISPLAY: Kernel = Kernel::new::<GainParams, CurvatureDisplayBuffers>(
    "CurvatureDisplay",
    &[
        INDEX,
        COVERAGE,
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
pub(crate) fn display(run: &mut Run) {
    let shape = run.made.shape.take().expect("the display takes curvature");
    run.made.picture = Some(run.display(&shape));
    run.made.shape = Some(shape);
}

impl Run<'_> {
    /// The curvature display.
    pub(crate) fn display(&mut self, shape: &Shape) -> Picture {
        let [width, height] = self.surface.size;
        let picture = [(); 3].map(|()| self.take(self.surface.plane_bytes()));
        let [red, green, blue] = &picture;
        self.recorder.over_pixels(
            "display",
            (&CURVATURE_DISPLAY, &[]),
            &GainParams {
                width,
                height,
                gain: self.gain(),
            },
            &CurvatureDisplayBuffers {
                covered: &self.surface.covered,
                conductance: &shape.conductance,
                trace: shape.trace(),
                red,
                green,
                blue,
            },
            [width, height],
        );
        picture
    }
}
