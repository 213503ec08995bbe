//! The list of all kernels, for code that iterates over them; passes do not use it.

use crate::engine::gpu::kernels::Kernel;
use crate::light::layers::gpu::{ADD_CHANGE, CHANGE_PICTURE, GROUP_SIGMA, LOBE_SIGMA, OCCLUDE};
use crate::light::radiance_scaling::gpu::SCALE_PICTURE;
use crate::light::relight::gpu::RELIGHT;
use crate::line::contours::gpu::{CRACKS, EDGE_LISTS};
use crate::line::contours::gpu_coverage::LINE_COVERAGE;
use crate::line::direction::gpu::SPREAD_DIRECTIONS;
use crate::line::direction_field::gpu_kernels::{
    BETWEEN_PATCHES, CHAIN_MEANS, FIND_PATCHES, FIND_RUNS, LINK_PATCHES, PATCH_DIRECTIONS,
    PATCH_FORMS, SETTLE_PATCHES, SUM_RUNS,
};
use crate::line::hatching::gpu::{DENSITY, PICTURE_STROKES, STROKES};
use crate::line::normal_rays::gpu::NORMAL_RAYS;
use crate::shape::curvature::gpu::{CURVATURES, HESSIAN};
use crate::shape::curvature_display::gpu::CURVATURE_DISPLAY;
use crate::shape::diffusion::gpu::DIFFUSION;
use crate::shape::edges::gpu::{EDGES, LOG_DEPTH};

/// All kernels.
pub(crate) static ALL: [&Kernel; 30] = [
    &LOG_DEPTH,
    &EDGES,
    &EDGE_LISTS,
    &CRACKS,
    &DIFFUSION,
    &HESSIAN,
    &CURVATURES,
    &SCALE_PICTURE,
    &LOBE_SIGMA,
    &GROUP_SIGMA,
    &ADD_CHANGE,
    &CHANGE_PICTURE,
    &OCCLUDE,
    &CURVATURE_DISPLAY,
    &NORMAL_RAYS,
    &SPREAD_DIRECTIONS,
    &FIND_PATCHES,
    &LINK_PATCHES,
    &FIND_RUNS,
    &SUM_RUNS,
    &CHAIN_MEANS,
    &PATCH_FORMS,
    &PATCH_DIRECTIONS,
    &SETTLE_PATCHES,
    &BETWEEN_PATCHES,
    &DENSITY,
    &STROKES,
    &PICTURE_STROKES,
    &LINE_COVERAGE,
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
