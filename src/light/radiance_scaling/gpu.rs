//! Radiance scaling of a picture on the device.

use crate::gpu::kernels::Kernel;
use crate::gpu::uniforms::uniforms;
use crate::gpu::wgsl::Number::F32;
use crate::gpu::wgsl::{Wgsl, wgsl};
use crate::light::radiance_scaling::cpu::Scaler;
use crate::light::radiance_scaling::{INVARIANT_MARGIN, MAX_EXPONENT};
use crate::plan::recording::Recording;
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
        gain: f32,
        white: f32,
        invariant_point: f32,
        /// Of convexities, and of concavities.
        magnitude: vec2,
        /// Weights of luminance.
        weights: vec3,
        /// Bits of a NaN, which WGSL cannot express as a literal.
        nan_bits: u32,
    }
}

/// Scales a picture by the trace of the Hessian.
pub(crate) static SCALE_PICTURE: Kernel = Kernel::new::<ScaleParams>(
    "ScalePicture",
    "covered: u32; trace: f32; red, green, blue: mut f32",
    &[
        MAPPED_CURVATURE,
        RADIANCE_SCALING,
        wgsl!("scale_picture.wgsl"),
    ],
);

/// Scales the picture in place.
pub(crate) fn scale(scaler: Scaler, run: &mut Recording) {
    let params = ScaleParams {
        gain: scaler.gain,
        white: scaler.white,
        invariant_point: scaler.invariant_point,
        magnitude: [scaler.magnitude.convex, scaler.magnitude.concave],
        weights: scaler.weights,
        nan_bits: f32::NAN.to_bits(),
    };
    run.over_pixels("radiance-scaling", (&SCALE_PICTURE, &[]), &params, &[]);
}
