//! Directions for pixels that have none of their own: their neighbours', in waves.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::sight::{SIGHT_LINES, lines};
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::{F32, U32};
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::frame::{Frame, SightLines};
use crate::line::direction::{
    ALONG, CANCELLED, EDGE_MARGIN_PX, PLANE_MARGIN_PX, SURFACE_MARGIN_PX,
};
use crate::line::direction_field::LEAST_LENGTH;
use crate::line::direction_field::setting::REST_REACH_PX;
use crate::shape::diffusion::gpu::FACE_CONDUCTANCE;

/// The direction where curvature leads nowhere.
pub(crate) const FALLBACK: Wgsl = wgsl!("fallback.wgsl", [("ALONG", F32(ALONG as f32))]);

/// Directions as twice their angle.
pub(crate) const DOUBLED: Wgsl = wgsl!("doubled.wgsl", [("LEAST_LENGTH", F32(LEAST_LENGTH))]);

/// Invocations per workgroup for processing a list of pixels.
pub(crate) const LIST_INVOCATIONS: u32 = 64;

/// Workgroups for processing such a list of any length.
pub(crate) const LIST_GROUPS: u32 = 256;

/// Indices of the lengths of the lists of pixels without a direction: open ones, if counted separately, and those on
/// edges.
pub(crate) const OPEN_COUNT: u32 = 0;
pub(crate) const CLOSED_COUNT: u32 = 1;

uniforms! {
    /// Uniforms of `spread_directions.wgsl`.
    SpreadParams {
        width: u32,
        height: u32,
        /// The direction of sight lines, scaled to z = -1: at the first column and row, and its increment per column
        /// and row.
        line_x: f32,
        line_x_step: f32,
        line_y: f32,
        line_y_step: f32,
        /// Height of a pixel over its width.
        pixel_shape: f32,
        /// Number of the wave, from 1 on.
        wave: u32,
        /// Index of its list's length, and of the next list's.
        list_count: u32,
        next_count: u32,
        /// Share by which directions turn to the fallback, 0..1: on planes, and elsewhere.
        flat_share: f32,
        share: f32,
        /// Which fallback, as in the field of stroke directions.
        order: u32,
        is_fixed: u32,
        fixed_x: f32,
        fixed_y: f32,
    }
}

bindings! {
    SpreadDirectionsBuffers {
        conductance: &[f32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32], list: &[u32], next: &mut [u32],
        counts: &mut [atomic<u32>], direction_x: &mut [f32], direction_y: &mut [f32],
        /// 1 more than the wave that gave a pixel its direction, 0 without one, and NOTHING outside the surface.
        filled: &mut [atomic<u32>],
        /// Twice the wave that a pixel was last listed for, and 1 more where the surface is a plane.
        marks: &mut [atomic<u32>],
    }
}

/// A wave over the pixels of a list.
pub(crate) static SPREAD_DIRECTIONS: Kernel = Kernel::new::<SpreadParams, SpreadDirectionsBuffers>(
    "SpreadDirections",
    &[
        FACE_CONDUCTANCE,
        SIGHT_LINES,
        FALLBACK,
        DOUBLED,
        wgsl!(
            "spread_directions.wgsl",
            [
                ("LIST_INVOCATIONS", U32(LIST_INVOCATIONS)),
                ("CANCELLED", F32(CANCELLED))
            ]
        ),
    ],
);

/// Waves over the pixels of a list, and after them the fallback.
pub(crate) struct Round {
    /// The list, by the index of its length.
    count: u32,
    waves: usize,
    /// Whether directions spread only through open faces, or to any neighbour.
    through_faces: bool,
    turning: Turning,
}

/// Turning of directions to the fallback.
enum Turning {
    /// Planes.
    Planes,
    /// Everything.
    All,
    /// None while spreading; all remaining pixels get the fallback in the end.
    None,
}

/// The rounds that fill directions of the surface, in order: see [`crate::line::direction::fill`].
pub(crate) const OF_SURFACES: &[Round] = &[
    Round {
        count: OPEN_COUNT,
        waves: PLANE_MARGIN_PX,
        through_faces: true,
        turning: Turning::Planes,
    },
    Round {
        count: OPEN_COUNT,
        waves: SURFACE_MARGIN_PX,
        through_faces: true,
        turning: Turning::All,
    },
    Round {
        count: CLOSED_COUNT,
        waves: EDGE_MARGIN_PX,
        through_faces: false,
        turning: Turning::All,
    },
];

/// The round that gives stroke directions to pixels that belong to no patch.
pub(crate) const OF_THE_REST: &[Round] = &[Round {
    count: OPEN_COUNT,
    waves: REST_REACH_PX,
    through_faces: false,
    turning: Turning::None,
}];

/// Directions before the gaps between them are filled.
pub(crate) struct Gaps {
    /// Unit directions in the picture, x right and y up: x, and y; 0 for none.
    pub(crate) directions: [wgpu::Buffer; 2],
    /// Whether pixels have a direction.
    pub(crate) filled: wgpu::Buffer,
    /// Marks of planar surface.
    pub(crate) marks: wgpu::Buffer,
    /// Lists of the pixels that lack a direction, in the order of their counts.
    pub(crate) lacking: Vec<wgpu::Buffer>,
    /// Their lengths, and those of the lists of all waves.
    pub(crate) counts: wgpu::Buffer,
}

/// Index of the length of the list that a wave makes for the next one.
const fn count_after(wave: u32) -> u32 {
    CLOSED_COUNT + wave
}

impl Run<'_> {
    /// Lengths of the lists of pixels, all 0: those without a direction, and one after each wave.
    pub(crate) fn gap_counts(&mut self, rounds: &[Round]) -> wgpu::Buffer {
        let waves: u32 = rounds.iter().map(|round| round.waves as u32 + 1).sum();
        let counts = self.take(4 * u64::from(count_after(waves) + 1));
        self.recorder.clear(&counts);
        counts
    }

    /// The directions found, with gaps filled; `params` holds the uniforms of sight lines and the fallback.
    pub(crate) fn fill_gaps(
        &mut self,
        stage: &'static str,
        rounds: &[Round],
        params: &SpreadParams,
        conductance: &wgpu::Buffer,
        gaps: Gaps,
    ) -> [wgpu::Buffer; 2] {
        let Gaps {
            directions: [x, y],
            filled,
            marks,
            lacking,
            counts,
        } = gaps;
        let [normal_x, normal_y, normal_z] = self.surface.normal.clone();
        let plane = self.surface.plane_bytes();
        let fronts = [(); 2].map(|()| self.take(plane));
        let mut wave = 0;
        for round in rounds {
            for number in 1..=round.waves + 1 {
                wave += 1;
                let is_last = number > round.waves;
                let is_of_all = number == 1 || is_last;
                let turned = (number as f32 / round.waves as f32).min(1.0);
                let params = SpreadParams {
                    wave,
                    list_count: match is_of_all {
                        true => round.count,
                        false => count_after(wave - 1),
                    },
                    next_count: count_after(wave),
                    flat_share: turned,
                    share: match round.turning {
                        Turning::Planes => 0.0,
                        Turning::All => turned,
                        Turning::None => f32::from(u8::from(is_last)),
                    },
                    ..*params
                };
                let [last, next] = [wave - 1, wave].map(|wave| &fronts[wave as usize % 2]);
                let list = if is_of_all {
                    &lacking[round.count as usize]
                } else {
                    last
                };
                let switches = [
                    ("THROUGH_FACES", round.through_faces),
                    ("IS_FIXED", is_last),
                ];
                self.recorder.dispatch(
                    stage,
                    (&SPREAD_DIRECTIONS, &switches),
                    &params,
                    &SpreadDirectionsBuffers {
                        conductance,
                        normal_x: &normal_x,
                        normal_y: &normal_y,
                        normal_z: &normal_z,
                        list,
                        next,
                        counts: &counts,
                        direction_x: &x,
                        direction_y: &y,
                        filled: &filled,
                        marks: &marks,
                    },
                    [LIST_GROUPS, 1],
                );
            }
        }
        let used = [filled, marks, counts].into_iter();
        self.buffers.recycle(used.chain(lacking).chain(fronts));
        [x, y]
    }
}

/// The uniforms of a frame's sight lines for waves; the fallback is that of the surface.
pub(crate) fn spread_params(frame: &Frame, sight: &SightLines) -> SpreadParams {
    let line = lines(frame, sight);
    SpreadParams {
        width: frame.mask.width() as u32,
        height: frame.mask.height() as u32,
        line_x: line.first[0],
        line_x_step: line.step[0],
        line_y: line.first[1],
        line_y_step: line.step[1],
        pixel_shape: sight.pixel_shape() as f32,
        wave: 0,
        list_count: 0,
        next_count: 0,
        flat_share: 0.0,
        share: 0.0,
        order: 0,
        is_fixed: 0,
        fixed_x: 0.0,
        fixed_y: 0.0,
    }
}
