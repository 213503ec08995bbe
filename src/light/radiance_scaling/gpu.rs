//! Radiance scaling of a picture on the device.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::recording::Recording;
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::F32;
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::light::radiance_scaling::cpu::Scaler;
use crate::light::radiance_scaling::{INVARIANT_MARGIN, MAX_EXPONENT};
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
    ScalePictureBuffers {
        covered: &[u32], trace: &[f32], red: &mut [f32], green: &mut [f32], blue: &mut [f32],
    }
}

/// Scales a picture by the trace of the Hessian.
pub(crate) static SCALE_PICTURE: Kernel = Kernel::new::<ScaleParams, ScalePictureBuffers>(
    "ScalePicture",
    &[
        MAPPED_CURVATURE,
        RADIANCE_SCALING,
        wgsl!("scale_picture.wgsl"),
    ],
);

/// Scales the picture in place.
pub(crate) fn scale(scaler: Scaler, run: &mut Recording) {
    let Scaler {
        params: scaling,
        gain,
        white,
        weights: [weight_r, weight_g, weight_b],
    } = scaler;
    let [width, height] = run.surface.size;
    let params = ScaleParams {
        width,
        height,
        gain,
        white,
        scaling: scaling.scaling,
        invariant_point: scaling.invariant_point,
        weight_r,
        weight_g,
        weight_b,
        nan_bits: f32::NAN.to_bits(),
    };
    let shape = run.made.shape.as_ref().expect("scaling takes the shape");
    let picture = run.made.picture.as_ref();
    let [red, green, blue] = picture.expect("enhancing takes a picture");
    run.recorder.over_pixels(
        "radiance-scaling",
        (&SCALE_PICTURE, &[]),
        &params,
        &ScalePictureBuffers {
            covered: &run.surface.covered,
            trace: shape.trace(),
            red,
            green,
            blue,
        },
        [width, height],
    );
}
