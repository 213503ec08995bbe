//! Edges on the device, and the gradient.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::made::Shape;
use crate::engine::gpu::run::{NOWHERE, Run};
use crate::engine::gpu::sight::to_eye;
use crate::engine::gpu::uniforms::{SizeParams, uniforms};
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::frame::Frame;
use crate::params::ShapeParams;
use crate::plan::Plan;
use crate::product::Product;
use crate::shape::crease::CreaseDetector;
use crate::shape::edges::SilhouetteSource;

/// How far a normal faces the eye.
pub(crate) const FACING: Wgsl = wgsl!("../facing.wgsl");

uniforms! {
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
    LogDepthBuffers {
        covered: &[u32], depth: &[f32], log_depth: &mut [f32],
    }
    EdgesBuffers {
        covered: &[u32], normal_x: &[f32], normal_y: &[f32], normal_z: &[f32],
        /// The logarithm of depth, or an occlusion map.
        silhouette_map: &[f32], normal_length: &[f32], conductance: &mut [f32], gradient: &mut [vec2<f32>],
        /// Silhouette and crease weight, if requested.
        weights: &mut [vec2<f32>],
    }
}

/// The logarithm of depth, used for silhouettes.
pub(crate) static LOG_DEPTH: Kernel =
    Kernel::new::<SizeParams, LogDepthBuffers>("LogDepth", &[wgsl!("log_depth.wgsl")]);

/// Edges, and the gradient before diffusion.
pub(crate) static EDGES: Kernel = Kernel::new::<EdgeParams, EdgesBuffers>(
    "Edges",
    &[wgsl!("soft_threshold.wgsl"), FACING, wgsl!("edges.wgsl")],
);

/// Finds edges and the gradient.
pub(crate) fn find_edges(run: &mut Run) {
    run.made.shape = Some(run.edges(run.plan, run.frame));
}

impl Run<'_> {
    /// Edges, and the gradient before diffusion.
    pub(crate) fn edges(&mut self, plan: &Plan, frame: &Frame) -> Shape {
        let [width, height] = self.surface.size;
        let plane = self.surface.plane_bytes();
        let of_depth = SilhouetteSource::of(plan) == SilhouetteSource::Depth;
        let log_depth = of_depth.then(|| {
            let log_depth = self.take(plane);
            let depth = self.surface.map.as_ref();
            let depth = depth.expect("the plan found it in the frame");
            let params = SizeParams { width, height };
            let buffers = LogDepthBuffers {
                covered: &self.surface.covered,
                depth,
                log_depth: &log_depth,
            };
            self.recorder.over_pixels(
                "edges-and-gradient",
                (&LOG_DEPTH, &[]),
                &params,
                &buffers,
                [width, height],
            );
            log_depth
        });
        let keeps_weights = plan.wants(Product::Silhouette);
        let weights = self.take(if keeps_weights { 2 * plane } else { NOWHERE });
        let (conductance, gradient) = (self.take(plane), self.take(2 * plane));
        let surface = &self.surface;
        let [x, y, z] = &surface.normal;
        let map = log_depth.as_ref().or(surface.map.as_ref());
        let switches = [
            ("HAS_MAP", map.is_some()),
            ("HAS_LENGTHS", surface.normal_length.is_some()),
            ("WEIGHTS_WANTED", keeps_weights),
        ];
        let buffers = EdgesBuffers {
            covered: &surface.covered,
            normal_x: x,
            normal_y: y,
            normal_z: z,
            silhouette_map: map.unwrap_or(x),
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
        self.buffers.recycle(log_depth);
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
}

fn edge_params(plan: &Plan, frame: &Frame) -> EdgeParams {
    let params: &ShapeParams = &plan.shape;
    let silhouette = match SilhouetteSource::of(plan) == SilhouetteSource::Depth {
        true => params.silhouette,
        false => params.occlusion_silhouette,
    };
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
