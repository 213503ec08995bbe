//! Pictures: radiance scaling, and the curvature display.

use crate::engine::gpu::bindings;
use crate::engine::gpu::choose::{Search, Searching};
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::shape::Shape;
use crate::engine::gpu::surface::Picture;
use crate::engine::gpu::uniforms::{ScaleParams, SizeParams};
use crate::frame::Frame;
use crate::params::Adaptive;
use crate::plan::{Plan, Stage};

/// The white level where it does not depend on the picture.
pub(crate) fn known_white_level(plan: &Plan, frame: &Frame) -> Option<f32> {
    match plan.scaling.white_level {
        Adaptive::Fixed(level) => Some(level),
        // What arrives of ambient light is a share of 1.
        Adaptive::Auto => frame.light.picture_is_occlusion.then_some(1.0),
    }
}

impl Run<'_> {
    /// Chooses the gain of curvature, where it is left open.
    pub(crate) fn choose_gain(&mut self, plan: &Plan, shape: &Shape) {
        if plan.has(Stage::AutoGain) && plan.scaling.curvature_gain == Adaptive::Auto {
            let size = self.surface.size.map(|side| side as usize);
            let factor = plan.resolution_factor as f32;
            let search = Searching::new(self, Search::Gain { size, factor });
            let chosen = self.chosen.clone();
            search.choose(self, shape.of_gain(), &chosen);
        }
    }

    /// Scales a picture in place, by a white level that is chosen first where it is not known.
    pub(crate) fn scale(&mut self, plan: &Plan, frame: &Frame, shape: &Shape, picture: &Picture) {
        if !plan.has(Stage::RadianceScaling) {
            return;
        }
        let weights = frame.luminance_weights();
        let [red, green, blue] = picture;
        if known_white_level(plan, frame).is_none() {
            let search = Searching::new(self, Search::White(weights));
            let chosen = self.chosen.clone();
            search.choose(self, [red, green, blue], &chosen);
        }
        let mut scaling = plan.scaling;
        if frame.light.picture_is_occlusion {
            scaling.scaling = scaling.magnitudes().ambient;
        }
        let [width, height] = self.surface.size;
        let params = ScaleParams {
            width,
            height,
            resolution_factor: plan.resolution_factor as f32,
            scaling: scaling.scaling,
            invariant_point: scaling.invariant_point,
            weight_r: weights[0],
            weight_g: weights[1],
            weight_b: weights[2],
            nan_bits: f32::NAN.to_bits(),
        };
        let size = [width, height];
        let (covered, chosen) = (&self.surface.covered, &self.chosen);
        match &shape.hessian {
            Some(hessian) => self.recorder.over_pixels(
                "radiance-scaling",
                (Kernel::ScalePicture, &[]),
                &params,
                &bindings::ScalePicture {
                    covered,
                    trace: &hessian.trace,
                    chosen,
                    red,
                    green,
                    blue,
                },
                size,
            ),
            None => self.recorder.over_rows(
                "radiance-scaling",
                (Kernel::ScaleByGradient, &[]),
                &params,
                &bindings::ScaleByGradient {
                    covered,
                    conductance: &shape.conductance,
                    gradient: &shape.gradient,
                    chosen,
                    red,
                    green,
                    blue,
                },
                size,
            ),
        }
    }

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
            (Kernel::CurvatureDisplay, &[]),
            &SizeParams { width, height },
            &bindings::CurvatureDisplay {
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
