//! Edges as lists, so that only data along edges are read back.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::made::Shape;
use crate::engine::gpu::run::{NOWHERE, Run};
use crate::engine::gpu::sight::{is_eye_far, starts, to_eye};
use crate::engine::gpu::surface::deinterleave;
use crate::engine::gpu::uniforms::{SizeParams, uniforms};
use crate::engine::gpu::wgsl::Number::{F32, U32};
use crate::engine::gpu::wgsl::wgsl;
use crate::engine::outcome::add_timings;
use crate::error::Result;
use crate::frame::{Frame, Plane};
use crate::line::contours::coverage::{DrawnLine, Piece, strokes};
use crate::line::contours::cpu::{Weights, contours};
use crate::line::contours::crack::KINK;
use crate::line::contours::cracks::LEAST_STEP;
use crate::line::contours::found::{FoundCrack, FoundEdges};
use crate::line::contours::{Contour, HALF_PLAIN_JUMP};
use crate::line::gpu_canvas::PendingReadback;
use crate::params::{ContourParams, Style};
use crate::plan::{Available, Plan};
use crate::shape::edges::SilhouetteSource;
use crate::shape::edges::gpu::FACING;
use rayon::prelude::*;

/// Indices of the counts of candidate cracks, of cracks with silhouettes, and of creases.
const CANDIDATE_COUNT: u32 = 0;
const CRACK_COUNT: u32 = 1;
const CREASE_COUNT: u32 = 2;

uniforms! {
    /// Uniforms of `cracks.wgsl`.
    CrackParams {
        width: u32,
        height: u32,
        /// Largest step that is not a jump.
        least_jump: f32,
        /// The direction to the eye, scaled to z = 1: at the first column and row, and its increment per column and
        /// row.
        to_eye_x: f32,
        to_eye_x_step: f32,
        to_eye_y: f32,
        to_eye_y_step: f32,
        /// The step of the origin of parallel sight lines per column and row.
        start_x_step: f32,
        start_y_step: f32,
    }
}

bindings! {
    EdgeListsBuffers {
        /// Silhouette and crease weight.
        weights: &[vec2<f32>], counts: &mut [atomic<u32>],
        /// Four times the pixel behind a crack, plus 2 if it is left of that pixel and not above it.
        candidates: &mut [u32],
        /// A pixel, and its weight.
        creases: &mut [vec2<u32>],
    }
    CracksBuffers {
        covered: &[u32],
        /// Depth, or an occlusion map.
        silhouette_map: &[f32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32], counts: &mut [atomic<u32>],
        /// Four times the pixel behind a crack, plus 2 if it is left of that pixel and not above it.
        candidates: &[u32],
        /// The same, plus 1 if the border of coverage is close beside it; the offset of the silhouette, its strength and the
        /// logarithm of its depth.
        cracks: &mut [vec4<u32>],
    }
}

/// Lists cracks that silhouettes may pass, and creases.
pub(crate) static EDGE_LISTS: Kernel = Kernel::new::<SizeParams, EdgeListsBuffers>(
    "EdgeLists",
    &[wgsl!(
        "edge_lists.wgsl",
        [
            ("CANDIDATES", U32(CANDIDATE_COUNT)),
            ("CREASES", U32(CREASE_COUNT))
        ]
    )],
);

/// Lists the cracks that silhouettes do pass.
pub(crate) static CRACKS: Kernel = Kernel::new::<CrackParams, CracksBuffers>(
    "Cracks",
    &[
        FACING,
        wgsl!("crack.wgsl", [("KINK", F32(KINK))]),
        wgsl!(
            "cracks.wgsl",
            [
                ("CANDIDATES", U32(CANDIDATE_COUNT)),
                ("CRACKS", U32(CRACK_COUNT)),
                ("HALF_PLAIN_JUMP", F32(HALF_PLAIN_JUMP)),
                ("LEAST_STEP", F32(LEAST_STEP))
            ]
        ),
    ],
);

/// Bytes per entry in the lists of candidate cracks, cracks with silhouettes, and creases.
const CANDIDATE: u64 = 4;
const CRACK: u64 = 16;
const CREASE: u64 = 8;

/// Workgroups that examine cracks, for any number of them: enough to keep a device busy.
const GROUPS: u32 = 128;

/// Lists of edges on the device.
pub(crate) struct EdgeLists {
    /// Number of entries, including those without room.
    pub(crate) counts: wgpu::Buffer,
    candidates: wgpu::Buffer,
    cracks: wgpu::Buffer,
    creases: wgpu::Buffer,
}

/// Lists edges, and has the device hand them out: their numbers are waited for.
pub(crate) fn list_edges(run: &mut Run) {
    let (plan, frame) = (run.plan, run.frame);
    let params = plan.contours().expect("contours are asked for");
    let shape = run.made.shape.take().expect("edges come first");
    let lists = run.edge_lists(plan, frame, &shape, &params);
    let counted = run.recorder.submit(&[&lists.counts]).read();
    let weights = shape.weights.as_ref();
    let weights = weights.expect("contours are planned with their weights");
    run.canvas.edges = Some(counted.map(|(read, times)| {
        add_timings(&mut run.waited, &times.unwrap_or_default());
        run.dispatch(lists, &read[0], weights)
    }));
    run.made.shape = Some(shape);
}

/// Follows the listed edges from pixel to pixel, which a device cannot do; it makes strokes meanwhile. Records the
/// coverage of the lines.
///
/// # Errors
/// [`crate::Error::Gpu`] where the device fails.
pub(crate) fn follow_listed(run: &mut Run) -> Result<()> {
    let (plan, frame) = (run.plan, run.frame);
    let edges = run.canvas.edges.take().expect("edges were listed")?;
    let host = &mut run.host;
    let lines = host.timed("contour-lines", || {
        edges.lines(
            plan,
            frame,
            &plan.contours().expect("contours are asked for"),
        )
    })?;
    let strokes = plan.drawing.as_ref().map(|params| &params.strokes);
    let grain = strokes.filter(|strokes| strokes.style == Style::Pencil);
    let seed = grain.map(|strokes| strokes.seed);
    run.canvas.contours = Some(run.covered_by_lines(frame, &contour_pieces(&lines), seed));
    run.host.canvas.contours = Some((Plane::default(), lines));
    Ok(())
}

/// The pieces that contours are drawn in: lines that meet are one.
fn contour_pieces(lines: &[Contour]) -> Vec<Piece> {
    let pieces = lines.par_iter();
    let pieces = pieces.flat_map_iter(|line| strokes(&DrawnLine::from(line)));
    pieces.map(|piece| (0, piece)).collect()
}

impl<'a> Run<'a> {
    /// Lists the edges of these weights, with room for one crack per four pixels, one candidate per pixel, and one
    /// crease per two.
    pub(crate) fn edge_lists(
        &mut self,
        plan: &Plan,
        frame: &Frame,
        edges: &Shape,
        params: &ContourParams,
    ) -> EdgeLists {
        let [width, height] = self.surface.size;
        let room = self.surface.plane_bytes().max(NOWHERE);
        let counts = self.take(12);
        let [candidates, cracks, creases] = [(); 3].map(|()| self.take(room));
        self.recorder.clear(&counts);
        let weights = edges.weights.as_ref();
        let weights = weights.expect("contours are planned with their weights");
        self.recorder.over_pixels(
            "edge-lists",
            (&EDGE_LISTS, &[("CREASES_WANTED", params.has_creases())]),
            &SizeParams { width, height },
            &EdgeListsBuffers {
                weights,
                counts: &counts,
                candidates: &candidates,
                creases: &creases,
            },
            [width, height],
        );
        let surface = &self.surface;
        let [x, y, z] = &surface.normal;
        let is_depth = SilhouetteSource::of(plan) == SilhouetteSource::Depth;
        let threshold = match is_depth {
            true => plan.shape.silhouette,
            false => plan.shape.occlusion_silhouette,
        };
        let (to_eye, starts) = (to_eye(frame), starts(frame));
        self.recorder.dispatch(
            "edge-lists",
            (
                &CRACKS,
                &[
                    ("HAS_MAP", surface.map.is_some()),
                    ("IS_DEPTH", is_depth),
                    ("HAS_SIGHT", Available::in_frame(frame).positions),
                    ("IS_EYE_FAR", is_eye_far(frame)),
                ],
            ),
            &CrackParams {
                width,
                height,
                least_jump: threshold.lo,
                to_eye_x: to_eye.first[0],
                to_eye_x_step: to_eye.step[0],
                to_eye_y: to_eye.first[1],
                to_eye_y_step: to_eye.step[1],
                start_x_step: starts.step[0],
                start_y_step: starts.step[1],
            },
            &CracksBuffers {
                covered: &surface.covered,
                silhouette_map: surface.map.as_ref().unwrap_or(x),
                normal_x: x,
                normal_y: y,
                normal_z: z,
                counts: &counts,
                candidates: &candidates,
                cracks: &cracks,
            },
            [GROUPS, 1],
        );
        EdgeLists {
            counts,
            candidates,
            cracks,
            creases,
        }
    }

    /// Has the device hand out the edges whose numbers were read from `lists`; where there was no room for all, their
    /// weights.
    pub(crate) fn dispatch(
        &mut self,
        lists: EdgeLists,
        counts: &[f32],
        weights: &wgpu::Buffer,
    ) -> PendingReadback<'a> {
        let EdgeLists {
            counts: counted,
            candidates,
            cracks,
            creases,
        } = lists;
        let [may_be, counts @ ..] =
            [CANDIDATE_COUNT, CRACK_COUNT, CREASE_COUNT].map(|at| counts[at as usize].to_bits());
        let is_looked_at = u64::from(may_be) * CANDIDATE <= candidates.size();
        let listed = [(&cracks, CRACK), (&creases, CREASE)];
        let parts = listed
            .into_iter()
            .zip(counts)
            .map(|((list, bytes), count)| {
                // In few sizes, so that buffers can be reused.
                let wanted = u64::from(count).max(1).next_power_of_two() * bytes;
                let has_room = u64::from(count) * bytes <= list.size();
                (has_room && is_looked_at).then_some((list, wanted.min(list.size())))
            });
        let coming = match parts.collect::<Option<Vec<_>>>() {
            Some(parts) => {
                let submitted = self.recorder.submit_for_parts(parts);
                PendingReadback::Listed(submitted, counts.map(|count| count as usize))
            }
            None => PendingReadback::InPlanes(self.recorder.submit(&[weights])),
        };
        self.buffers.recycle([counted, candidates, cracks, creases]);
        coming
    }
}

impl PendingReadback<'_> {
    /// The lines along these edges, once they are here.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device fails.
    pub(crate) fn lines(
        self,
        plan: &Plan,
        frame: &Frame,
        params: &ContourParams,
    ) -> Result<Vec<Contour>> {
        match self {
            Self::Listed(submitted, counts) => {
                let (read, _) = submitted.read()?;
                let edges = listed(&read, counts);
                Ok(edges.contours(frame, &plan.shape, params))
            }
            Self::InPlanes(submitted) => {
                let (read, _) = submitted.read()?;
                let plane =
                    |samples| Plane::from_samples(frame.mask.width(), frame.mask.height(), samples);
                let [silhouette, crease] = &deinterleave::<2>(&read[0]).map(plane);
                let weights = Weights { silhouette, crease };
                Ok(contours(&weights, frame, &plan.shape, params))
            }
        }
    }
}

/// The edges from lists with these numbers of cracks and creases, sorted.
fn listed(read: &[Vec<f32>], [crack_count, crease_count]: [usize; 2]) -> FoundEdges {
    let (cracks, _) = read[0].as_chunks::<4>();
    let mut cracks = cracks[..crack_count].to_vec();
    cracks.par_sort_unstable_by_key(|crack| crack[0].to_bits());
    let found = |[key, offset, strength, log_depth]: [f32; 4]| FoundCrack {
        pixel: key.to_bits() >> 2,
        is_left: key.to_bits() & 2 != 0,
        is_beside: key.to_bits() & 1 != 0,
        offset,
        strength,
        log_depth,
    };
    let (creases, _) = read[1].as_chunks::<2>();
    let creases = creases[..crease_count].iter();
    let mut creases: Vec<(u32, f32)> = creases
        .map(|&[pixel, weight]| (pixel.to_bits(), weight))
        .collect();
    creases.par_sort_unstable_by_key(|crease| crease.0);
    FoundEdges {
        cracks: cracks.into_iter().map(found).collect(),
        creases,
    }
}
