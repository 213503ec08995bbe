//! Radiance scaling of a picture on the device.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::{COVERAGE, INDEX, Kernel};
use crate::engine::gpu::made::Shape;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::surface::Picture;
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::F32;
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::frame::Frame;
use crate::light::radiance_scaling::{INVARIANT_MARGIN, MAX_EXPONENT};
use crate::plan::Plan;
use crate::shape::curvature::gpu::MAPPED_CURVATURE;

/// The scaling of light by curvature.
pub(crate) const RADIANCE_SCALING: Wgsl = wgsl!(
    "radiance_scaling.wgsl",
    [
        ("INVARIANT_MARGIN", F32(INVARIANT_MARGIN)),
        ("MAX_EXPONENT", F32(MAX_EXPONENT))
    ]
);

uniforms! {
    /// Uniforms of `scale_picture.wgsl`.
    ScaleParams {
        width: u32,
        height: u32,
        gain: f32,
        white: f32,
        scaling: f32,
        invariant_point: f32,
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
        /// Bits of a NaN, which WGSL cannot express as a literal.
        nan_bits: u32,
    }
}

bindings! {
    ScalePictureBuffers { covered, trace, red, green, blue }
}

/// Scales a picture by the trace of the Hessian.
pub(crate) static SCALE_PICTURE: Kernel = Kernel::new::<ScaleParams, ScalePictureBuffers>(
    "ScalePicture",
    &[
        INDEX,
        COVERAGE,
        MAPPED_CURVATURE,
        RADIANCE_SCALING,
        wgsl!("scale_picture.wgsl"),
    ],
);

/// Scales the picture.
pub(crate) fn scale(run: &mut Run) {
    run.change_picture(|run, shape, picture| run.scale(run.plan, run.frame, shape, picture));
}

impl Run<'_> {
    /// Scales a picture in place.
    pub(crate) fn scale(&mut self, plan: &Plan, frame: &Frame, shape: &Shape, picture: &Picture) {
        let weights = frame.luminance_weights();
        let [red, green, blue] = picture;
        let mut scaling = plan.scaling;
        if frame.light.picture_is_occlusion {
            scaling.scaling = scaling.magnitudes().ambient;
        }
        let [width, height] = self.surface.size;
        let params = ScaleParams {
            width,
            height,
            gain: self.gain(),
            white: self.host.outcome.white_level.expect("it is chosen first"),
            scaling: scaling.scaling,
            invariant_point: scaling.invariant_point,
            weight_r: weights[0],
            weight_g: weights[1],
            weight_b: weights[2],
            nan_bits: f32::NAN.to_bits(),
        };
        self.recorder.over_pixels(
            "radiance-scaling",
            (&SCALE_PICTURE, &[]),
            &params,
            &ScalePictureBuffers {
                covered: &self.surface.covered,
                trace: shape.trace(),
                red,
                green,
                blue,
            },
            [width, height],
        );
    }
}
