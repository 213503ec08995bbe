//! Edges on the device, and the gradient.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::made::Shape;
use crate::engine::gpu::recording::{NOWHERE, Recording};
use crate::engine::gpu::sight::{Linear, to_eye};
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::{F32, I32};
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::frame::Frame;
use crate::params::ShapeParams;
use crate::plan::Plan;
use crate::product::Product;
use crate::shape::crease::CreaseDetector;
use crate::shape::edges::SilhouetteSource;
use crate::shape::gap::noise::TILE;
use crate::shape::gap::of_frame::Gaps;
use crate::shape::gap::pair::{CLOSED, DEPARTS, NOISES, STEEPEST, TURNS};
use crate::shape::gap::scale::{FARTHEST, NEAREST};

/// How far a normal faces the eye.
pub(crate) const FACING: Wgsl = wgsl!("../facing.wgsl");

uniforms! {
    /// Uniforms of `gaps.wgsl`.
    GapParams {
        width: u32,
        height: u32,
        /// In pixels.
        silhouette_lo: f32,
        silhouette_hi: f32,
        /// Pixels per unit of length, and the step to the next pixel, at depth 1.
        pitch_x: f32,
        pitch_y: f32,
        step_x: f32,
        step_y: f32,
        rounding_share: f32,
        rounding_unit: f32,
        to_eye_x: f32,
        to_eye_x_step: f32,
        to_eye_y: f32,
        to_eye_y_step: f32,
        tile_columns: u32,
        tile_rows: u32,
        tile_x: i32,
        tile_y: i32,
    }

    /// Uniforms of `edges.wgsl`.
    EdgeParams {
        width: u32,
        height: u32,
        silhouette_lo: f32,
        silhouette_hi: f32,
        /// Angles in radians.
        crease_lo: f32,
        crease_hi: f32,
        /// Above this length a filtered normal certainly hides no crease.
        flat_length: f32,
        foreshortening: f32,
        min_nz: f32,
        /// The direction to the eye, scaled to z = 1: at the first column and row, and its increments per column and
        /// row.
        to_eye_x: f32,
        to_eye_x_step: f32,
        to_eye_y: f32,
        to_eye_y_step: f32,
    }
}

bindings! {
    GapBuffers {
        covered: &[u32], depth: &[f32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32],
        /// The noise of depth in tiles.
        noise: &[f32],
        gaps: &mut [vec2<f32>],
    }
    EdgesBuffers {
        covered: &[u32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32],
        /// An occlusion map, and the weights of the gaps to the right and below.
        silhouette_map: &[f32], gaps: &[vec2<f32>], normal_length: &[f32], conductance: &mut [f32], gradient: &mut [vec2<f32>],
        /// Silhouette and crease weight, if requested.
        weights: &mut [vec2<f32>],
    }
}

/// Gaps between the surfaces of neighbouring pixels.
pub(crate) static GAPS: Kernel = Kernel::new::<GapParams, GapBuffers>(
    "Gaps",
    &[
        wgsl!("soft_threshold.wgsl"),
        FACING,
        wgsl!(
            "gaps.wgsl",
            [
                ("DEPARTS_LO", F32(DEPARTS.lo)),
                ("DEPARTS_HI", F32(DEPARTS.hi)),
                ("TURNS_LO", F32(TURNS.lo)),
                ("TURNS_HI", F32(TURNS.hi)),
                ("NOISES", F32(NOISES)),
                ("CLOSED", F32(CLOSED)),
                ("STEEPEST", F32(STEEPEST)),
                ("NEAREST", F32(NEAREST)),
                ("FARTHEST", F32(FARTHEST)),
                ("TILE", I32(TILE)),
            ]
        ),
    ],
);

/// Edges, and the gradient before diffusion.
pub(crate) static EDGES: Kernel = Kernel::new::<EdgeParams, EdgesBuffers>(
    "Edges",
    &[wgsl!("soft_threshold.wgsl"), FACING, wgsl!("edges.wgsl")],
);

/// Finds edges and the gradient.
pub(crate) fn find_edges(run: &mut Recording) {
    run.made.shape = Some(run.edges(run.plan, run.frame));
}

impl Recording<'_> {
    /// Edges, and the gradient before diffusion.
    pub(crate) fn edges(&mut self, plan: &Plan, frame: &Frame) -> Shape {
        let [width, height] = self.surface.size;
        let plane = self.surface.plane_bytes();
        let of_depth = SilhouetteSource::of(plan) == SilhouetteSource::Depth;
        let gaps = of_depth.then(|| self.gaps(plan, frame));
        let keeps_weights = plan.wants(Product::Silhouette);
        let weights = self.take(if keeps_weights { 2 * plane } else { NOWHERE });
        let (conductance, gradient) = (self.take(plane), self.take(2 * plane));
        let surface = &self.surface;
        let [x, y, z] = &surface.normal;
        let map = surface.map.as_ref().filter(|_| !of_depth);
        let switches = [
            ("HAS_MAP", map.is_some()),
            ("HAS_GAPS", of_depth),
            ("HAS_LENGTHS", surface.normal_length.is_some()),
            ("WEIGHTS_WANTED", keeps_weights),
        ];
        let buffers = EdgesBuffers {
            covered: &surface.covered,
            normal_x: x,
            normal_y: y,
            normal_z: z,
            silhouette_map: map.unwrap_or(x),
            gaps: gaps.as_ref().unwrap_or(x),
            normal_length: surface.normal_length.as_ref().unwrap_or(x),
            conductance: &conductance,
            gradient: &gradient,
            weights: &weights,
        };
        self.recorder.over_rows(
            "edges-and-gradient",
            (&EDGES, &switches),
            &edge_params(plan, frame),
            &buffers,
            [width, height],
        );
        self.buffers.recycle(gaps);
        let weights = match keeps_weights {
            true => Some(weights),
            false => {
                self.buffers.recycle([weights]);
                None
            }
        };
        Shape {
            conductance,
            weights,
            gradient,
            more_gradients: Vec::new(),
            hessian: None,
        }
    }

    /// Weights of the gaps from each pixel to the next ones, to the right and below.
    fn gaps(&mut self, plan: &Plan, frame: &Frame) -> wgpu::Buffer {
        let [width, height] = self.surface.size;
        let out = self.take(2 * self.surface.plane_bytes());
        let there = "the plan found it in the frame";
        let found = Gaps::new(
            frame,
            frame.depth.as_ref().expect(there),
            plan.shape.silhouette,
        );
        let scale = &found.scale;
        let noise = found.noise_tiles();
        let tiles = noise.as_ref();
        let (size, offset) = tiles.map_or(([0; 2], [0; 2]), |(tiles, offset)| {
            ([tiles.width() as u32, tiles.height() as u32], *offset)
        });
        let tiles = tiles.map(|(tiles, _)| self.uploaded(tiles.samples()));
        let to_eye = Linear::of(frame, |x, y| scale.projection.to_eye(x, y));
        let [x, y, z] = &self.surface.normal;
        let depth = self.surface.map.as_ref().expect(there);
        let switches = [
            ("IS_PERSPECTIVE", scale.is_perspective),
            ("DEPTH_ALONG_RAY", scale.along_lines),
            ("HAS_NOISE", tiles.is_some()),
        ];
        self.recorder.over_pixels(
            "edges-and-gradient",
            (&GAPS, &switches),
            &GapParams {
                width,
                height,
                silhouette_lo: scale.threshold.lo,
                silhouette_hi: scale.threshold.hi,
                pitch_x: scale.pitch[0],
                pitch_y: scale.pitch[1],
                step_x: scale.step[0],
                step_y: scale.step[1],
                rounding_share: scale.rounding[0],
                rounding_unit: scale.rounding[1],
                to_eye_x: to_eye.first[0],
                to_eye_x_step: to_eye.step[0],
                to_eye_y: to_eye.first[1],
                to_eye_y_step: to_eye.step[1],
                tile_columns: size[0],
                tile_rows: size[1],
                tile_x: offset[0],
                tile_y: offset[1],
            },
            &GapBuffers {
                covered: &self.surface.covered,
                depth,
                normal_x: x,
                normal_y: y,
                normal_z: z,
                noise: tiles.as_ref().unwrap_or(x),
                gaps: &out,
            },
            [width, height],
        );
        out
    }
}

fn edge_params(plan: &Plan, frame: &Frame) -> EdgeParams {
    let params: &ShapeParams = &plan.shape;
    let silhouette = params.occlusion_silhouette;
    let creases = CreaseDetector::new(params.crease);
    let to_eye = to_eye(frame);
    EdgeParams {
        width: frame.mask.width() as u32,
        height: frame.mask.height() as u32,
        silhouette_lo: silhouette.lo,
        silhouette_hi: silhouette.hi,
        crease_lo: creases.threshold_rad.lo,
        crease_hi: creases.threshold_rad.hi,
        flat_length: creases.flat_length,
        foreshortening: params.foreshortening,
        min_nz: params.min_nz,
        to_eye_x: to_eye.first[0],
        to_eye_x_step: to_eye.step[0],
        to_eye_y: to_eye.first[1],
        to_eye_y_step: to_eye.step[1],
    }
}
