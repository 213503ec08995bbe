//! The list of all kernels, for code that iterates over them; passes do not use it.

use crate::gpu::kernels::Kernel;
use crate::light::radiance_scaling::gpu::SCALE_PICTURE;
use crate::light::relight::gpu::RELIGHT;
use crate::line::hatching::gpu::{DENSITY, PICTURE_STROKES, STROKES};
use crate::line::normal_rays::gpu::NORMAL_RAYS;
use crate::shape::curvature::gpu::{CURVATURES, HESSIAN};
use crate::shape::curvature_display::gpu::CURVATURE_DISPLAY;
use crate::shape::diffusion::gpu::DIFFUSION;
use crate::shape::edges::gpu::{EDGES, GAPS};

/// All kernels.
pub(crate) static ALL: [&Kernel; 12] = [
    &GAPS,
    &EDGES,
    &DIFFUSION,
    &HESSIAN,
    &CURVATURES,
    &SCALE_PICTURE,
    &CURVATURE_DISPLAY,
    &NORMAL_RAYS,
    &DENSITY,
    &STROKES,
    &PICTURE_STROKES,
    &RELIGHT,
];

/// The name and the complete WGSL of every kernel.
pub fn kernel_sources() -> impl Iterator<Item = (String, String)> {
    let all = ALL.into_iter();
    all.map(|kernel| (kernel.name.into(), kernel.source()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_kernels_have_the_same_name() {
        let names: BTreeSet<_> = ALL.iter().map(|kernel| kernel.name).collect();
        assert_eq!(names.len(), ALL.len());
    }
}
