//! The Hessian, and curvatures.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::kernels::Kernel;
use crate::engine::gpu::made::{Curvatures, Hessian, Shape};
use crate::engine::gpu::recording::{NOWHERE, Recording};
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::F32;
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::plan::Plan;
use crate::product::Product;
use crate::shape::curvature::UMBILIC;
use crate::shape::hessian::RIDGE;

/// The mapped curvature.
pub(crate) const MAPPED_CURVATURE: Wgsl = wgsl!("mapped_curvature.wgsl");

/// The mapped curvature toward a light.
pub(crate) const MAPPED_CURVATURE_TOWARD: Wgsl = wgsl!("mapped_curvature_toward.wgsl");

uniforms! {
    /// Uniforms of `hessian.wgsl`.
    HessianParams {
        width: u32,
        height: u32,
        /// Pixels per pixel of the reference.
        resolution_factor: f32,
    }

    /// For kernels that map curvature.
    GainParams {
        width: u32,
        height: u32,
        gain: f32,
    }
}

bindings! {
    HessianBuffers {
        covered: &[u32], conductance: &[f32], gradient: &[vec2<f32>], trace: &mut [f32], hessian_xx: &mut [f32],
        hessian_xy: &mut [f32], hessian_yy: &mut [f32],
    }
    CurvaturesBuffers {
        covered: &[u32], hessian_xx: &[f32], hessian_xy: &[f32], hessian_yy: &[f32],
        /// View-centred curvature: u, v, mean and kappa.
        curvature: &mut [vec4<f32>], direction: &mut [vec2<f32>],
    }
}

/// The Hessian of a gradient, or only its trace.
pub(crate) static HESSIAN: Kernel = Kernel::new::<HessianParams, HessianBuffers>(
    "Hessian",
    &[wgsl!("../hessian.wgsl", [("RIDGE", F32(RIDGE))])],
);

/// Planes that the layers of the descriptor derive from the Hessian.
pub(crate) static CURVATURES: Kernel = Kernel::new::<GainParams, CurvaturesBuffers>(
    "Curvatures",
    &[
        MAPPED_CURVATURE,
        wgsl!("curvatures.wgsl", [("UMBILIC", F32(UMBILIC))]),
    ],
);

/// Computes the Hessian, or only its trace.
pub(crate) fn find_hessian(run: &mut Recording) {
    run.change_shape(Recording::with_hessian);
}

/// Computes the planes derived from the Hessian for layers, at every scale, with the chosen gain.
pub(crate) fn describe(run: &mut Recording) {
    let shape = run.made.shape.take().expect(FROM_HESSIAN);
    let hessian = shape.hessian.as_ref().expect(FROM_HESSIAN);
    let mut curvatures = vec![run.curvatures(hessian)];
    for gradient in &shape.more_gradients {
        let hessian = run.hessian(run.plan, gradient, &shape.conductance, true);
        curvatures.push(run.curvatures(&hessian));
    }
    run.made.curvatures = curvatures;
    run.made.shape = Some(shape);
}

const FROM_HESSIAN: &str = "curvatures are planned with their Hessian";

impl Recording<'_> {
    /// Adds the Hessian to a shape, if curvature is wanted.
    pub(crate) fn with_hessian(&mut self, shape: Shape) -> Shape {
        let plan = self.plan;
        let hessian = plan.wants_curvature().then(|| {
            let entries = plan.wants(Product::Hessian);
            self.hessian(plan, &shape.gradient, &shape.conductance, entries)
        });
        Shape { hessian, ..shape }
    }

    /// The Hessian of a gradient, or only its trace.
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

    /// Curvatures, directions and mapped curvature from a Hessian with entries.
    pub(crate) fn curvatures(&mut self, hessian: &Hessian) -> Curvatures {
        let [width, height] = self.surface.size;
        let plane = self.surface.plane_bytes();
        let (curvature, direction) = (self.take(4 * plane), self.take(2 * plane));
        let [xx, xy, yy] = hessian.entries.as_ref().expect("the entries are wanted");
        self.recorder.over_pixels(
            "curvatures",
            (&CURVATURES, &[]),
            &GainParams {
                width,
                height,
                gain: self.gain(),
            },
            &CurvaturesBuffers {
                covered: &self.surface.covered,
                hessian_xx: xx,
                hessian_xy: xy,
                hessian_yy: yy,
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
