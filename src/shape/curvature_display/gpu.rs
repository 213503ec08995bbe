//! The curvature display on the device.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::{COVERAGE, INDEX, Kernel};
use crate::engine::gpu::run::Run;
use crate::engine::gpu::surface::Picture;
use crate::engine::gpu::uniforms::SizeParams;
use crate::shape::curvature::gpu::MAPPED_CURVATURE;
use crate::shape::gpu::Shape;

bindings! {
    CurvatureDisplayBuffers { covered, conductance, trace, chosen, red, green, blue }
}

/// The curvature display.
pub(crate) static CURVATURE_DISPLAY: Kernel = Kernel::new::<SizeParams, CurvatureDisplayBuffers>(
    "CurvatureDisplay",
    &[
        INDEX,
        COVERAGE,
        MAPPED_CURVATURE,
        include_str!("curvature_display.wgsl"),
    ],
);

impl Run<'_> {
    /// The curvature display.
    pub(crate) fn display(&mut self, shape: &Shape) -> Picture {
        let [width, height] = self.surface.size;
        let picture = [(); 3].map(|()| self.take(self.surface.plane_bytes()));
        let [red, green, blue] = &picture;
        let trace = &shape
            .hessian
            .as_ref()
            .expect("the display takes curvature")
            .trace;
        self.recorder.over_pixels(
            "display",
            (&CURVATURE_DISPLAY, &[]),
            &SizeParams { width, height },
            &CurvatureDisplayBuffers {
                covered: &self.surface.covered,
                conductance: &shape.conductance,
                trace,
                chosen: &self.chosen,
                red,
                green,
                blue,
            },
            [width, height],
        );
        picture
    }
}
