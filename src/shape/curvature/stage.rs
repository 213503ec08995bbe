//! From the gradient to curvature: only its trace if that suffices, else the Hessian and planes derived from it.

use crate::frame::{CurvaturePlanes, Plane, SymmetricPlanes, Vector2Planes};
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::outcome::{ScaleShape, Shape};
use crate::plan::stage::{Stage, Verdict, step};
use crate::product::Product;
use crate::shape::curvature::cpu;
use crate::shape::diffusion::stage::DIFFUSION;
use crate::shape::hessian::REACH;

/// The sum of the curvatures alone, or the Hessian of the height with the curvatures and directions that are wanted.
pub(crate) static CURVATURE: Stage = Stage {
    takes: |_| vec![Product::Gradient, Product::Conductance],
    reach_px: |_| REACH,
    reads_normals: false,
    depends_on: |plan| plan.resolution_factor.to_string(),
    by_rows: true,
    name: "curvature",
    steps: &[
        step("trace", &[Product::Trace], |plan| {
            match (plan.wants(Product::Hessian), plan.wants(Product::Trace)) {
                (true, _) => plan.left_out("part of the hessian"),
                (false, true) => Verdict::runs(format!(
                    "only the sum of curvatures is needed{}",
                    unit(plan)
                )),
                (false, false) => plan.left_out("no curvature is needed"),
            }
        }),
        step("hessian", &[Product::Trace, Product::Hessian], |plan| {
            let why = match plan.wants(Product::Curvature) {
                true => "asked for as layers",
                false => "light has a direction: so has curvature",
            };
            match plan.wants(Product::Hessian) {
                true => Verdict::runs(format!("{why}{}", unit(plan))),
                false => plan.left_out("its trace is enough: no eigenvectors, no directions"),
            }
        }),
        step("curvatures", &[Product::Curvature], |plan| {
            asked_for(plan, Product::Curvature, "their sum is enough")
        }),
        step("directions", &[Product::ViewDirection], |plan| {
            let why_not = "no eigenvectors: what follows a direction uses the hessian itself";
            asked_for(plan, Product::ViewDirection, why_not)
        }),
    ],
    cpu: find_curvature,
    // What derives from the Hessian is made with the mapped curvature.
    #[cfg(feature = "gpu")]
    gpu: Some(super::gpu::find_hessian),
    #[cfg(feature = "gpu")]
    gpu_planes: &[(&[Product::Hessian], &super::gpu::HESSIAN_PLANES)],
    ..Stage::DEFAULT
};

/// Curvature mapped to -1..1, and curvature at further scales.
pub(crate) static MAPPED_CURVATURE: Stage = Stage {
    takes: |plan| match maps_trace(plan) {
        true => vec![Product::Trace, Product::Conductance],
        false => vec![Product::Curvature, Product::Hessian, Product::Conductance],
    },
    reads_normals: false,
    by_rows: true,
    name: "mapped-curvature",
    steps: &[step(
        "mapped-curvature",
        &[Product::MappedCurvature],
        |plan| match plan.wants(Product::MappedCurvature) {
            true => Verdict::runs("asked for as a layer"),
            false => plan.left_out("made on the fly where it is used"),
        },
    )],
    cpu: map_curvature,
    #[cfg(feature = "gpu")]
    gpu: Some(super::gpu::describe),
    #[cfg(feature = "gpu")]
    gpu_planes: &[
        (super::gpu::DESCRIBED, &["curvature"]),
        (&[Product::ViewDirection], &["direction"]),
    ],
    #[cfg(feature = "gpu")]
    gpu_lacks: |plan| maps_trace(plan).then_some("mapped curvature alone"),
    ..Stage::DEFAULT
};

/// Whether curvature is mapped of which nothing else is wanted: its trace is enough.
fn maps_trace(plan: &Plan) -> bool {
    plan.wants(Product::MappedCurvature)
        && !plan.wants(Product::Curvature)
        && plan.more_px.is_empty()
}

fn asked_for(plan: &Plan, product: Product, why_not: &str) -> Verdict {
    match plan.wants(product) {
        true => Verdict::runs("asked for as layers"),
        false => plan.left_out(why_not),
    }
}

/// The unit of curvature, if it is not per pixel of the picture.
fn unit(plan: &Plan) -> String {
    match plan.shape.reference_height {
        None => String::new(),
        Some(height) => {
            let factor = plan.resolution_factor;
            format!(", times {factor:.4}: per pixel at a height of {height}")
        }
    }
}

/// Finds what is wanted of curvature. Relighting computes both the trace and the Hessian row by row: only the gain takes the
/// trace of the frame.
fn find_curvature(run: &mut Execution) {
    let plan = run.plan;
    let is_whole = plan.relighting().is_none();
    if !plan.wants(Product::Hessian) {
        if is_whole || plan.chooses_gain() || plan.shows_shape {
            trace_of_gradient(run);
        }
    } else if is_whole {
        describe(run);
    }
}

/// The Hessian with its trace, or, where curvatures are wanted, which have the same sum, with these; and directions.
fn describe(run: &mut Execution) {
    let (plan, mask, memory) = (run.plan, &run.frame.mask, run.memory);
    let layers = [Product::Curvature, Product::ViewDirection];
    let wanted = layers.map(|product| plan.wants(product));
    let mut made = vec![Product::Hessian];
    made.extend((!wanted[0]).then_some(Product::Trace));
    made.extend(layers.into_iter().filter(|&product| plan.wants(product)));
    if run.has_kept(&made, plan.key(CURVATURE.name)) {
        return;
    }
    let (shape, factor) = (
        std::mem::take(&mut run.made.outcome.shape),
        plan.resolution_factor as f32,
    );
    let (gradient, conductance) = slopes(&shape);
    let (hessian, trace, layers) = run.timed(CURVATURE.name, || {
        let (hessian, layers) = if wanted == [false; 2] {
            let hessian = cpu::described(gradient, conductance, factor, mask, memory);
            (symmetric(hessian), None)
        } else {
            let [xx, xy, yy, u, v, mean, x, y] =
                cpu::described(gradient, conductance, factor, mask, memory);
            let layers = (CurvaturePlanes { u, v, mean }, Vector2Planes { x, y });
            (SymmetricPlanes { xx, xy, yy }, Some(layers))
        };
        let trace = (!wanted[0]).then(|| cpu::trace_of(&hessian, mask, memory));
        (hessian, trace, layers)
    });
    let (curvatures, directions) = layers.unzip();
    run.made.outcome.shape = Shape {
        hessian: Some(hessian),
        trace,
        curvatures: curvatures.filter(|_| wanted[0]),
        direction_view: directions.filter(|_| wanted[1]),
        ..shape
    };
}

/// The trace of the Hessian, from the gradient; rounded as the sum of the curvatures where these are wanted too.
pub(crate) fn trace_of_gradient(run: &mut Execution) {
    let (plan, mask, memory) = (run.plan, &run.frame.mask, run.memory);
    let factor = plan.resolution_factor;
    let key = format!("{} {factor}", plan.key(DIFFUSION.name));
    if run.has_kept(&[Product::Trace], &key) {
        return;
    }
    let shape = std::mem::take(&mut run.made.outcome.shape);
    let (gradient, conductance) = slopes(&shape);
    let trace = run.timed(CURVATURE.name, || {
        if factor != 1.0 && plan.wants(Product::Curvature) {
            let described = cpu::described(gradient, conductance, factor as f32, mask, memory);
            let hessian = symmetric(described);
            let trace = cpu::trace_of(&hessian, mask, memory);
            memory.recycle([hessian.xx, hessian.xy, hessian.yy]);
            return trace;
        }
        per_reference_pixel(cpu::trace(gradient, conductance, mask, memory), factor)
    });
    run.made.outcome.shape = Shape {
        trace: Some(trace),
        ..shape
    };
}

fn map_curvature(run: &mut Execution) {
    let (plan, mask, memory) = (run.plan, &run.frame.mask, run.memory);
    let (gain, factor) = (run.gain(), plan.resolution_factor as f32);
    let (shape, summed) = (&run.made.outcome.shape, run.made.trace.take());
    let summed = summed.or_else(|| shape.curvatures.as_ref().map(CurvaturePlanes::trace));
    let trace = summed.as_ref().or(shape.trace.as_ref());
    let trace = trace.expect("curvature comes before its map");
    run.made.outcome.shape.kappa = Some(cpu::mapped_curvature(trace, gain, mask, memory));
    if plan.more_px.is_empty() {
        return;
    }
    let gradients = std::mem::take(&mut run.made.more_gradients);
    let conductance = run.made.outcome.shape.conductance.take().expect(SLOPES);
    let scales = run.timed("more-scales", || {
        let scales = gradients.into_iter().zip(&plan.more_px);
        let described = scales.map(|(gradient, &sigma_px)| {
            let [xx, xy, yy, u, v, mean] =
                cpu::described(&gradient, &conductance, factor, mask, memory);
            memory.recycle([xx, xy, yy]);
            let curvatures = CurvaturePlanes { u, v, mean };
            let trace = curvatures.trace();
            ScaleShape {
                sigma_px,
                kappa: cpu::mapped_curvature(&trace, gain, mask, memory),
                curvatures,
            }
        });
        described.collect()
    });
    run.made.outcome.shape.conductance = Some(conductance);
    run.made.outcome.shape.more_scales = scales;
}

const SLOPES: &str = "curvature is planned with its gradient";

fn slopes(shape: &Shape) -> (&Vector2Planes, &Plane) {
    let gradient = shape.gradient.as_ref().expect(SLOPES);
    (gradient, shape.conductance.as_ref().expect(SLOPES))
}

fn symmetric([xx, xy, yy]: [Plane; 3]) -> SymmetricPlanes {
    SymmetricPlanes { xx, xy, yy }
}

/// Derivatives per pixel of the reference.
fn per_reference_pixel(mut per_pixel: Plane, factor: f64) -> Plane {
    if factor != 1.0 {
        let factor = factor as f32;
        per_pixel.each_row(|_, row| row.iter_mut().for_each(|v| *v *= factor));
    }
    per_pixel
}
