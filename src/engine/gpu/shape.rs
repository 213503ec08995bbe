//! The shape of a surface: weights, gradient, diffusion, Hessian, curvature.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::{AROUND, COVERAGE, INDEX, Kernel};
use crate::engine::gpu::run::{NOWHERE, Run};
use crate::engine::gpu::sight::to_eye;
use crate::engine::gpu::uniforms::uniforms;
use crate::frame::Frame;
use crate::params::ShapeParams;
use crate::plan::{Goal, Plan, Stage};
use crate::shape::crease::CreaseDetector;

/// How far a normal faces the eye.
pub(crate) const FACING: &str = include_str!("shaders/facing.wgsl");

/// The plane through the gradients around a pixel.
pub(crate) const PLANE_FIT: &str = include_str!("shaders/plane_fit.wgsl");

/// The mapped curvature.
pub(crate) const MAPPED_CURVATURE: &str = include_str!("shaders/mapped_curvature.wgsl");

/// The mapped curvature toward a light.
pub(crate) const MAPPED_CURVATURE_TOWARD: &str =
    include_str!("shaders/mapped_curvature_toward.wgsl");

uniforms! {
    /// Of kernels that are told nothing but the size of the picture.
    SizeParams {
        width: u32,
        height: u32,
    }

    /// Of `edges.wgsl`.
    EdgeParams {
        width: u32,
        height: u32,
        silhouette_lo: f32,
        silhouette_hi: f32,
        /// Angles in radians.
        crease_lo: f32,
        crease_hi: f32,
        /// Above this length a filtered normal surely hides no crease.
        flat_length: f32,
        foreshortening: f32,
        min_nz: f32,
        /// The direction to the eye, scaled to z = 1: at the first column and row, and what each further one adds.
        to_eye_x: f32,
        to_eye_x_step: f32,
        to_eye_y: f32,
        to_eye_y_step: f32,
    }

    /// Of `hessian.wgsl`.
    HessianParams {
        width: u32,
        height: u32,
        /// Pixels that stand for one of the reference.
        resolution_factor: f32,
    }
}

bindings! {
    LogDepthBuffers { covered, depth, log_depth }
    EdgesBuffers { covered, normal_x, normal_y, normal_z, silhouette_map, normal_length, conductance, gradient, weights }
    HessianBuffers { covered, conductance, gradient, trace, hessian_xx, hessian_xy, hessian_yy }
    CurvaturesBuffers { covered, hessian_xx, hessian_xy, hessian_yy, chosen, curvature, direction }
}

/// The logarithm of depth, in which silhouettes are found.
pub(crate) static LOG_DEPTH: Kernel = Kernel::new::<SizeParams, LogDepthBuffers>(
    "LogDepth",
    &[INDEX, COVERAGE, include_str!("shaders/log_depth.wgsl")],
);

/// Edges, and the gradient before diffusion.
pub(crate) static EDGES: Kernel = Kernel::new::<EdgeParams, EdgesBuffers>(
    "Edges",
    &[
        INDEX,
        AROUND,
        COVERAGE,
        include_str!("shaders/soft_threshold.wgsl"),
        FACING,
        include_str!("shaders/edges.wgsl"),
    ],
);

/// The Hessian of a gradient, or its trace alone.
pub(crate) static HESSIAN: Kernel = Kernel::new::<HessianParams, HessianBuffers>(
    "Hessian",
    &[
        INDEX,
        AROUND,
        COVERAGE,
        PLANE_FIT,
        include_str!("shaders/hessian.wgsl"),
    ],
);

/// What the layers of the descriptor take of the Hessian.
pub(crate) static CURVATURES: Kernel = Kernel::new::<SizeParams, CurvaturesBuffers>(
    "Curvatures",
    &[
        INDEX,
        COVERAGE,
        MAPPED_CURVATURE,
        include_str!("shaders/curvatures.wgsl"),
    ],
);

/// Edges on the device, and the gradient before diffusion.
pub(crate) struct Edges {
    pub(crate) conductance: wgpu::Buffer,
    /// Silhouette and crease weight of each pixel, where they are wanted.
    pub(crate) weights: Option<wgpu::Buffer>,
    pub(crate) gradient: wgpu::Buffer,
}

/// The descriptor on the device, as far as a plan asks for it.
pub(crate) struct Shape {
    pub(crate) conductance: wgpu::Buffer,
    /// Silhouette and crease weight of each pixel.
    pub(crate) weights: Option<wgpu::Buffer>,
    pub(crate) gradient: wgpu::Buffer,
    /// The gradient at further scales.
    pub(crate) more_gradients: Vec<wgpu::Buffer>,
    /// The Hessian at the first scale, unless it is used only once, where it is made.
    pub(crate) hessian: Option<Hessian>,
}

/// The Hessian on the device.
pub(crate) struct Hessian {
    pub(crate) trace: wgpu::Buffer,
    /// Its entries xx, xy and yy, where they are wanted.
    pub(crate) entries: Option<[wgpu::Buffer; 3]>,
}

impl Shape {
    /// What the gain is chosen from.
    pub(crate) fn of_gain(&self) -> [&wgpu::Buffer; 3] {
        let hessian = self.hessian.as_ref();
        let trace = &hessian.expect("the gain takes the trace").trace;
        [trace, &self.conductance, trace]
    }

    /// All of its buffers.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        let hessian = self.hessian.into_iter();
        let hessian = hessian.flat_map(|Hessian { trace, entries }| {
            std::iter::once(trace).chain(entries.into_iter().flatten())
        });
        [self.conductance, self.gradient]
            .into_iter()
            .chain(self.weights)
            .chain(self.more_gradients)
            .chain(hessian)
    }
}

/// What is made of the Hessian for the layers of the descriptor.
pub(crate) struct Curvatures {
    /// u, v, mean and kappa of each pixel.
    pub(crate) curvature: wgpu::Buffer,
    /// The direction of the view-centred curvature larger in size.
    pub(crate) direction: wgpu::Buffer,
}

impl Run<'_> {
    /// Finds the shape that `plan` asks for.
    pub(crate) fn find_shape(&mut self, plan: &Plan, frame: &Frame) -> Shape {
        let edges = self.edges(plan, frame);
        self.shape_along(plan, edges)
    }

    /// The shape between edges.
    pub(crate) fn shape_along(&mut self, plan: &Plan, edges: Edges) -> Shape {
        let Edges {
            conductance,
            weights,
            gradient,
        } = edges;
        let mut gradients = match plan.has(Stage::Diffusion) {
            true => self.diffused(plan, gradient, &conductance),
            false => {
                let copies = plan.more_px.len();
                let more = (0..copies)
                    .map(|_| self.copy_of(&gradient))
                    .collect::<Vec<_>>();
                std::iter::once(gradient).chain(more).collect()
            }
        };
        let more_gradients = gradients.split_off(1);
        let gradient = gradients.remove(0);
        let wants =
            (plan.has(Stage::Hessian) || plan.has(Stage::Trace)) && !scales_by_gradient(plan);
        let hessian = wants.then(|| {
            let entries = plan.has(Stage::Hessian);
            self.hessian(plan, &gradient, &conductance, entries)
        });
        Shape {
            conductance,
            weights,
            gradient,
            more_gradients,
            hessian,
        }
    }

    /// Edges, and the gradient before diffusion.
    pub(crate) fn edges(&mut self, plan: &Plan, frame: &Frame) -> Edges {
        let [width, height] = self.surface.size;
        let plane = self.surface.plane_bytes();
        let log_depth = plan.has(Stage::DepthSilhouettes).then(|| {
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
        let keeps_weights = plan.keeps_edge_weights();
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
        Edges {
            conductance,
            weights,
            gradient,
        }
    }

    /// The Hessian of a gradient, or its trace alone.
    pub(crate) fn hessian(
        &mut self,
        plan: &Plan,
        gradient: &wgpu::Buffer,
        conductance: &wgpu::Buffer,
        entries_wanted: bool,
    ) -> Hessian {
        let [width, height] = self.surface.size;
        let plane = self.surface.plane_bytes();
        let params = HessianParams {
            width,
            height,
            resolution_factor: plan.resolution_factor as f32,
        };
        let trace = self.take(plane);
        let entries = [(); 3].map(|()| self.take(if entries_wanted { plane } else { NOWHERE }));
        let [xx, xy, yy] = &entries;
        self.recorder.over_rows(
            if entries_wanted { "hessian" } else { "trace" },
            (&HESSIAN, &[("ENTRIES_WANTED", entries_wanted)]),
            &params,
            &HessianBuffers {
                covered: &self.surface.covered,
                conductance,
                gradient,
                trace: &trace,
                hessian_xx: xx,
                hessian_xy: xy,
                hessian_yy: yy,
            },
            [width, height],
        );
        let entries = match entries_wanted {
            true => Some(entries),
            false => {
                self.buffers.recycle(entries);
                None
            }
        };
        Hessian { trace, entries }
    }

    /// Curvatures, directions and mapped curvature of a Hessian whose entries are there.
    pub(crate) fn curvatures(&mut self, hessian: &Hessian) -> Curvatures {
        let [width, height] = self.surface.size;
        let plane = self.surface.plane_bytes();
        let (curvature, direction) = (self.take(4 * plane), self.take(2 * plane));
        let [xx, xy, yy] = hessian.entries.as_ref().expect("the entries are wanted");
        self.recorder.over_pixels(
            "curvatures",
            (&CURVATURES, &[]),
            &SizeParams { width, height },
            &CurvaturesBuffers {
                covered: &self.surface.covered,
                hessian_xx: xx,
                hessian_xy: xy,
                hessian_yy: yy,
                chosen: &self.chosen,
                curvature: &curvature,
                direction: &direction,
            },
            [width, height],
        );
        Curvatures {
            curvature,
            direction,
        }
    }
}

/// Whether the trace of the Hessian is used once, and where it is made.
fn scales_by_gradient(plan: &Plan) -> bool {
    let is_used_again = plan.has(Stage::AutoGain) || plan.has(Stage::AmbientOcclusion);
    plan.goal == Goal::Enhance && plan.has(Stage::RadianceScaling) && !is_used_again
}

fn edge_params(plan: &Plan, frame: &Frame) -> EdgeParams {
    let params: &ShapeParams = &plan.shape;
    let silhouette = match plan.has(Stage::DepthSilhouettes) {
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
