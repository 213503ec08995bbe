//! The Hessian, and curvatures.

use crate::gpu::kernels::Kernel;
use crate::gpu::uniforms::uniforms;
use crate::gpu::wgsl::Number::F32;
use crate::gpu::wgsl::{Wgsl, wgsl};
use crate::plan::Plan;
use crate::plan::recording::Recording;
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
        /// Pixels per pixel of the reference.
        resolution_factor: f32,
    }

    /// For kernels that map curvature.
    GainParams {
        gain: f32,
    }
}

/// The products in a plane of curvature, in order.
pub(crate) const DESCRIBED: &[Product] = &[Product::Curvature, Product::MappedCurvature];

/// The planes of the Hessian's entries.
pub(crate) const HESSIAN_PLANES: [&str; 3] = ["hessian_xx", "hessian_xy", "hessian_yy"];

/// The Hessian of a gradient, or only its trace.
pub(crate) static HESSIAN: Kernel = Kernel::new::<HessianParams>(
    "Hessian",
    "covered: u32; conductance: f32; gradient: vec2<f32>; trace: mut f32; \
     hessian_xx?, hessian_xy?, hessian_yy?: mut f32",
    &[wgsl!("../hessian.wgsl", [("RIDGE", F32(RIDGE))])],
)
.by_strips();

/// Planes that the layers of the descriptor derive from the Hessian.
pub(crate) static CURVATURES: Kernel = Kernel::new::<GainParams>(
    "Curvatures",
    // View-centred curvature: u, v, mean and kappa.
    "covered: u32; hessian_xx, hessian_xy, hessian_yy: f32; curvature: mut vec4<f32>; \
     direction: mut vec2<f32>",
    &[
        MAPPED_CURVATURE,
        wgsl!("curvatures.wgsl", [("UMBILIC", F32(UMBILIC))]),
    ],
);

/// Computes the Hessian, or only its trace, if curvature is wanted.
pub(crate) fn find_hessian(run: &mut Recording) {
    let plan = run.plan;
    if !plan.wants_curvature() {
        return;
    }
    let entries_wanted = plan.wants(Product::Hessian);
    if entries_wanted {
        for name in HESSIAN_PLANES {
            run.put(name, run.take_plane(1));
        }
    }
    let stage = if entries_wanted { "hessian" } else { "trace" };
    let switches = [("ENTRIES_WANTED", entries_wanted)];
    run.over_pixels(stage, (&HESSIAN, &switches), &hessian_params(plan), &[]);
}

/// Computes the planes derived from the Hessian for layers, at every scale, with the chosen gain.
pub(crate) fn describe(run: &mut Recording) {
    let params = GainParams { gain: run.gain() };
    run.over_pixels("curvatures", (&CURVATURES, &[]), &params, &[]);
    if run.more_gradients.is_empty() {
        return;
    }
    // Results at further scales leave those at the first as they are.
    let names = ["trace", "hessian_xx", "hessian_xy", "hessian_yy"];
    let hessian = names.map(|_| run.take_plane(1));
    let direction = run.take_plane(2);
    for gradient in run.more_gradients.clone() {
        let curvature = run.take_plane(4);
        let mut named: Vec<_> = names.into_iter().zip(&hessian).collect();
        named.extend([
            ("gradient", &gradient),
            ("curvature", &curvature),
            ("direction", &direction),
        ]);
        let entries_wanted = [("ENTRIES_WANTED", true)];
        let of_plan = hessian_params(run.plan);
        run.over_pixels("hessian", (&HESSIAN, &entries_wanted), &of_plan, &named);
        run.over_pixels("curvatures", (&CURVATURES, &[]), &params, &named);
        run.more_curvatures.push(curvature);
    }
    run.buffers.recycle(hessian.into_iter().chain([direction]));
}

fn hessian_params(plan: &Plan) -> HessianParams {
    HessianParams {
        resolution_factor: plan.resolution_factor as f32,
    }
}
