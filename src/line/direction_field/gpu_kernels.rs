//! The kernels of the field of stroke directions, with their uniforms and buffers.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::sight::SIGHT_LINES;
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::{F32, U32};
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::line::direction::gpu::{DOUBLED, FALLBACK, OPEN_COUNT};
use crate::line::direction_field::{AGREE, ROUND, setting};
use crate::line::normal_rays::MIN_UPRIGHT;
use crate::line::normal_rays::gpu::NORMAL_RAY;

/// Cells of a run, along which chains of patches are summed up at a time.
pub(crate) const RUN_CELLS: u32 = 16;

/// The patches of cells.
const PATCHES: Wgsl = wgsl!("patches.wgsl");

/// Iterates over runs.
const RUNS: Wgsl = wgsl!("runs.wgsl", [("RUN_CELLS", U32(RUN_CELLS))]);

/// Sums over part of a run.
const SUMS: Wgsl = wgsl!("sums.wgsl");

/// Iterates over all patches.
const OVER_PATCHES: Wgsl = wgsl!("over_patches.wgsl");

/// Position of a patch, and its upright tangents.
const PATCH_LINES: Wgsl = wgsl!(
    "patch_lines.wgsl",
    [("MIN_UPRIGHT", F32(MIN_UPRIGHT as f32))]
);

uniforms! {
    /// Uniforms of the kernels of the field of stroke directions.
    DirectionParams {
        width: u32,
        height: u32,
        /// Side of a cell in pixels, and the part of the first one before the picture.
        cell_px: u32,
        cut_x: u32,
        cut_y: u32,
        columns: u32,
        rows: u32,
        /// Room for patches after the first one of each cell.
        room: u32,
        /// Axis of kernels that work along one: 0 across, 1 down.
        axis: u32,
        /// Reach of a mean, in cells.
        reach: f32,
        /// The median depth of patches.
        median: f32,
        /// The direction of sight lines, scaled to z = -1: at the first column and row, and its increment per column
        /// and row.
        line_x: f32,
        line_x_step: f32,
        line_y: f32,
        line_y_step: f32,
        /// Distance between points at a depth of 1 in adjacent pixels.
        apart_x_step: f32,
        apart_y_step: f32,
        /// Height of a pixel over its width.
        pixel_shape: f32,
        /// Converts curvature per unit of length to curvature per pixel.
        per_pixel: f32,
        /// Turn of normals per pixel that counts half.
        doubt: f32,
        /// 0 for the curvature larger in size, 1 for the other.
        family: u32,
        /// Index of the field, in the order of computation.
        order: u32,
        is_fixed: u32,
        fixed_x: f32,
        fixed_y: f32,
    }
}

bindings! {
    FindPatchesBuffers {
        conductance: &[f32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32],
        /// Any buffer if there is no depth.
        depth: &[f32],
        /// Number of patches of each cell, and the index of those after the first one.
        held: &mut [vec2<u32>], patches: &mut [Patch],
        /// Depth of each patch, 0 without one.
        depths: &mut [f32],
        /// Number of patches after the first ones.
        further: &mut [atomic<u32>],
    }
    LinkPatchesBuffers {
        held: &[vec2<u32>], patches: &[Patch],
        /// The continuation of each patch to the left, to the right, above and below.
        links: &mut [vec4<u32>],
    }
    FindRunsBuffers {
        held: &[vec2<u32>], links: &[vec4<u32>],
        /// The first and the last patch of the run, and their distances in cells.
        runs: &mut [vec4<u32>],
    }
    SumRunsBuffers {
        held: &[vec2<u32>], links: &[vec4<u32>], values: &[vec4<f32>], sums: &mut [Sums],
    }
    ChainMeansBuffers {
        held: &[vec2<u32>], further: &[u32], patches: &[Patch], links: &[vec4<u32>], runs_across: &[vec4<u32>],
        runs_down: &[vec4<u32>], sums_across: &[Sums], sums_down: &[Sums], depths: &[f32], values: &[vec4<f32>],
        means: &mut [vec4<f32>],
    }
    PatchFormsBuffers {
        held: &[vec2<u32>], further: &[u32], patches: &[Patch], links: &[vec4<u32>], forms: &mut [vec4<f32>],
    }
    PatchDirectionsBuffers {
        held: &[vec2<u32>], further: &[u32], patches: &[Patch], forms: &[vec4<f32>], directions: &mut [vec4<f32>],
    }
    SettlePatchesBuffers {
        held: &[vec2<u32>], further: &[u32], patches: &[Patch], links: &[vec4<u32>], own: &[vec4<f32>],
        around: &[vec4<f32>], settled: &mut [vec2<f32>],
    }
    BetweenPatchesBuffers {
        covered: &[u32], held: &[vec2<u32>], patches: &[Patch], links: &[vec4<u32>], settled: &[vec2<f32>],
        direction_x: &mut [f32], direction_y: &mut [f32],
        /// 1 for a pixel with a direction, 0 without one, and NOTHING outside the surface.
        filled: &mut [u32],
        /// Marks set by waves at pixels: none as yet.
        marks: &mut [u32], lacking: &mut [u32], counts: &mut [atomic<u32>],
    }
}

/// The patches of each cell.
pub(crate) static FIND_PATCHES: Kernel = Kernel::new::<DirectionParams, FindPatchesBuffers>(
    "FindPatches",
    &[
        PATCHES,
        wgsl!("find_patches.wgsl", [("OPEN", F32(setting::OPEN))]),
    ],
);

/// Continuations of each patch.
pub(crate) static LINK_PATCHES: Kernel = Kernel::new::<DirectionParams, LinkPatchesBuffers>(
    "LinkPatches",
    &[PATCHES, wgsl!("link_patches.wgsl")],
);

/// The first and the last patch of each run.
pub(crate) static FIND_RUNS: Kernel = Kernel::new::<DirectionParams, FindRunsBuffers>(
    "FindRuns",
    &[PATCHES, RUNS, wgsl!("find_runs.wgsl")],
);

/// Sums over each run.
pub(crate) static SUM_RUNS: Kernel = Kernel::new::<DirectionParams, SumRunsBuffers>(
    "SumRuns",
    &[PATCHES, RUNS, SUMS, wgsl!("sum_runs.wgsl")],
);

/// Means around each patch.
pub(crate) static CHAIN_MEANS: Kernel = Kernel::new::<DirectionParams, ChainMeansBuffers>(
    "ChainMeans",
    &[
        PATCHES,
        SUMS,
        OVER_PATCHES,
        wgsl!(
            "chain_means.wgsl",
            [
                ("RUN_CELLS", U32(RUN_CELLS)),
                ("NEAR", F32(setting::NEAR)),
                ("FAR", F32(setting::FAR))
            ]
        ),
    ],
);

/// The curvature of each patch.
pub(crate) static PATCH_FORMS: Kernel = Kernel::new::<DirectionParams, PatchFormsBuffers>(
    "PatchForms",
    &[
        PATCHES,
        SIGHT_LINES,
        PATCH_LINES,
        NORMAL_RAY,
        OVER_PATCHES,
        wgsl!("patch_forms.wgsl"),
    ],
);

/// The direction of each patch.
pub(crate) static PATCH_DIRECTIONS: Kernel = Kernel::new::<DirectionParams, PatchDirectionsBuffers>(
    "PatchDirections",
    &[
        PATCHES,
        SIGHT_LINES,
        PATCH_LINES,
        FALLBACK,
        DOUBLED,
        OVER_PATCHES,
        wgsl!(
            "patch_directions.wgsl",
            [
                ("FACING", F32(setting::FACING as f32)),
                ("ROUND", F32(ROUND as f32))
            ]
        ),
    ],
);

/// The direction of strokes in each patch.
pub(crate) static SETTLE_PATCHES: Kernel = Kernel::new::<DirectionParams, SettlePatchesBuffers>(
    "SettlePatches",
    &[
        PATCHES,
        SIGHT_LINES,
        PATCH_LINES,
        FALLBACK,
        DOUBLED,
        OVER_PATCHES,
        wgsl!(
            "settle_patches.wgsl",
            [
                ("FALLBACK", F32(setting::FALLBACK)),
                ("FREE", F32(setting::FREE)),
                ("AGREE_FROM", F32(AGREE.start)),
                ("AGREE_TO", F32(AGREE.end))
            ]
        ),
    ],
);

/// Directions of pixels between patches.
pub(crate) static BETWEEN_PATCHES: Kernel = Kernel::new::<DirectionParams, BetweenPatchesBuffers>(
    "BetweenPatches",
    &[
        PATCHES,
        DOUBLED,
        wgsl!("between_patches.wgsl", [("OPEN_COUNT", U32(OPEN_COUNT))]),
    ],
);
