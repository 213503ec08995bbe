//! Edges on the device, and the gradient.

use crate::frame::Frame;
use crate::frame::gap::noise::TILE;
use crate::frame::gap::of_frame::Gaps;
use crate::frame::gap::pair::{CLOSED, DEPARTS, NOISES, STEEPEST, TURNS};
use crate::frame::gap::scale::{FARTHEST, NEAREST};
use crate::gpu::kernels::Kernel;
use crate::gpu::sight::{linear, to_eye};
use crate::gpu::uniforms::uniforms;
use crate::gpu::wgsl::Number::{F32, I32};
use crate::gpu::wgsl::{Wgsl, wgsl};
use crate::params::ShapeParams;
use crate::plan::Plan;
use crate::plan::recording::Recording;
use crate::product::Product;
use crate::shape::crease::CreaseDetector;
use crate::shape::edges::SilhouetteSource;

/// How far a normal faces the eye.
pub(crate) const FACING: Wgsl = wgsl!("../facing.wgsl");

uniforms! {
    /// Uniforms of `gaps.wgsl`.
    GapParams {
        /// In pixels.
        silhouette_lo: f32,
        silhouette_hi: f32,
        /// Pixels per unit of length, and the step to the next pixel, at depth 1.
        pitch: vec2,
        step: vec2,
        /// The rounding of depth: a share of it, and a length.
        rounding: vec2,
        to_eye: vec4,
        tile_columns: u32,
        tile_rows: u32,
        tile_x: i32,
        tile_y: i32,
    }

    /// Uniforms of `edges.wgsl`.
    EdgeParams {
        silhouette_lo: f32,
        silhouette_hi: f32,
        /// Angles in radians.
        crease_lo: f32,
        crease_hi: f32,
        /// Above this length a filtered normal certainly hides no crease.
        flat_length: f32,
        foreshortening: f32,
        min_nz: f32,
        /// The direction to the eye, scaled to z = 1, as [`linear`] has it.
        to_eye: vec4,
    }
}

/// Gaps between the surfaces of neighbouring pixels.
pub(crate) static GAPS: Kernel = Kernel::new::<GapParams>(
    "Gaps",
    // The noise of depth is in tiles.
    "covered: u32; depth, normal_x, normal_y, normal_z, noise?: f32; gaps: mut vec2<f32>",
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
pub(crate) static EDGES: Kernel = Kernel::new::<EdgeParams>(
    "Edges",
    // An occlusion map, or the strengths of the gaps to the right and below; silhouette and crease weights.
    "covered: u32; normal_x, normal_y, normal_z, silhouette_map?: f32; gaps?: vec2<f32>; \
     normal_length?: f32; conductance: mut f32; gradient: mut vec2<f32>; weights?: mut vec2<f32>",
    &[wgsl!("soft_threshold.wgsl"), FACING, wgsl!("edges.wgsl")],
)
.by_strips();

/// Finds edges, and the gradient before diffusion.
pub(crate) fn find_edges(run: &mut Recording) {
    let (plan, frame) = (run.plan, run.frame);
    let is_wanted = plan.wants(Product::Conductance);
    let (is_depth, is_map) = match SilhouetteSource::of(plan) {
        SilhouetteSource::Depth => (is_wanted, false),
        SilhouetteSource::Occlusion => (false, is_wanted),
        SilhouetteSource::Border => (false, false),
    };
    if is_depth {
        run.upload_as("depth", frame.depth.as_ref());
        run.gaps();
    }
    let map = frame.occlusion.as_ref().filter(|_| is_map);
    let keeps_weights = plan.wants(Product::Silhouette);
    let weights = keeps_weights.then(|| run.take_plane(2));
    let switches = [
        ("HAS_MAP", run.upload_as("silhouette_map", map)),
        ("HAS_GAPS", is_depth),
        ("HAS_LENGTHS", run.has("normal_length")),
        ("WEIGHTS_WANTED", keeps_weights),
    ];
    if let Some(weights) = weights {
        run.put("weights", weights);
    }
    let kernel: (&Kernel, &[_]) = (&EDGES, &switches);
    run.over_pixels("edges-and-gradient", kernel, &edge_params(plan, frame), &[]);
    run.drop_plane("gaps");
}

impl Recording<'_> {
    /// Strengths of the gaps from each pixel to the next ones, to the right and below.
    fn gaps(&mut self) {
        let (plan, frame) = (self.plan, self.frame);
        let depth = frame.depth.as_ref();
        let depth = depth.expect("the plan found it in the frame");
        let found = Gaps::new(frame, depth, plan.shape.silhouette);
        let scale = &found.scale;
        let noise = found.noise_tiles();
        let tiles = noise.as_ref();
        let (size, offset) = tiles.map_or(([0; 2], [0; 2]), |(tiles, offset)| {
            ([tiles.width() as u32, tiles.height() as u32], *offset)
        });
        let switches = [
            ("IS_PERSPECTIVE", scale.is_perspective),
            ("DEPTH_ALONG_RAY", scale.along_lines),
            (
                "HAS_NOISE",
                self.upload_as("noise", tiles.map(|(tiles, _)| tiles)),
            ),
        ];
        let params = GapParams {
            silhouette_lo: scale.threshold.lo,
            silhouette_hi: scale.threshold.hi,
            pitch: scale.pitch,
            step: scale.step,
            rounding: scale.rounding,
            to_eye: linear(frame, |x, y| scale.projection.to_eye(x, y)),
            tile_columns: size[0],
            tile_rows: size[1],
            tile_x: offset[0],
            tile_y: offset[1],
        };
        self.over_pixels("edges-and-gradient", (&GAPS, &switches), &params, &[]);
    }
}

fn edge_params(plan: &Plan, frame: &Frame) -> EdgeParams {
    let params: &ShapeParams = &plan.shape;
    let silhouette = params.occlusion_silhouette;
    let creases = CreaseDetector::new(params.crease);
    EdgeParams {
        silhouette_lo: silhouette.lo,
        silhouette_hi: silhouette.hi,
        crease_lo: creases.threshold_rad.lo,
        crease_hi: creases.threshold_rad.hi,
        flat_length: creases.flat_length,
        foreshortening: params.foreshortening,
        min_nz: params.min_nz,
        to_eye: to_eye(frame),
    }
}
