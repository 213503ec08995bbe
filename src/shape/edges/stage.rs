//! Edges and the gradient: the first stage, since all others stop at edges.

use crate::frame::gap::GAP_REACH;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::outcome::Shape;
use crate::plan::stage::{Stage, Verdict, step};
use crate::product::Product;
use crate::shape::edges::SilhouetteSource;
use crate::shape::edges::cpu::edges_with_weights;

/// Silhouettes, creases, conductance and the gradient before diffusion.
pub(crate) static EDGES: Stage = Stage {
    reach_px: |plan| match SilhouetteSource::of(plan) {
        SilhouetteSource::Depth => GAP_REACH,
        SilhouetteSource::Occlusion | SilhouetteSource::Border => 1,
    },
    depends_on: |plan| {
        let shape = &plan.shape;
        let thresholds = (shape.silhouette, shape.occlusion_silhouette, shape.crease);
        let slopes = (shape.foreshortening, shape.min_nz);
        format!("{:?}", (SilhouetteSource::of(plan), thresholds, slopes))
    },
    reads_lengths: true,
    name: "edges-and-gradient",
    steps: &[
        step("depth-silhouettes", &[Product::Silhouette], |plan| {
            silhouettes(SilhouetteSource::Depth, plan, "gaps between surfaces")
        }),
        step("occlusion-silhouettes", &[Product::Silhouette], |plan| {
            silhouettes(
                SilhouetteSource::Occlusion,
                plan,
                "no depth: jumps of occlusion or alpha",
            )
        }),
        step("border-silhouettes", &[Product::Silhouette], |plan| {
            silhouettes(
                SilhouetteSource::Border,
                plan,
                "no depth: the border of the mask",
            )
        }),
        step("creases", &[Product::Crease], |plan| {
            where_edges_are_wanted(plan, "from normals")
        }),
        step("conductance", &[Product::Conductance], |plan| {
            where_edges_are_wanted(plan, "barriers for diffusion, flatness at edges")
        }),
        step("gradient", &[Product::Gradient], |plan| {
            match plan.wants(Product::Gradient) {
                true => Verdict::runs(format!("foreshortening {}", plan.shape.foreshortening)),
                false => plan.left_out("no curvature is needed"),
            }
        }),
    ],
    cpu: find_edges,
    #[cfg(feature = "gpu")]
    gpu: Some(super::gpu::find_edges),
    #[cfg(feature = "gpu")]
    gpu_planes: &[
        (&[Product::Conductance], &["conductance"]),
        (&[Product::Silhouette, Product::Crease], &["weights"]),
        (&[Product::Gradient], &["gradient"]),
    ],
    ..Stage::DEFAULT
};

/// Verdict on silhouettes from this source, with the reason `why`.
fn silhouettes(source: SilhouetteSource, plan: &Plan, why: &str) -> Verdict {
    let own = SilhouetteSource::of(plan);
    match (source, own) {
        _ if !plan.wants(Product::Conductance) => plan.left_out("nothing stops at edges"),
        _ if source == own => Verdict::runs(why),
        (SilhouetteSource::Depth, _) => Verdict::left_out("no depth"),
        (SilhouetteSource::Occlusion, SilhouetteSource::Depth) => Verdict::left_out("depth serves"),
        (SilhouetteSource::Occlusion, _) => Verdict::left_out("no occlusion map, no alpha"),
        (SilhouetteSource::Border, _) => Verdict::left_out("a map tells more"),
    }
}

fn where_edges_are_wanted(plan: &Plan, why: &str) -> Verdict {
    match plan.wants(Product::Conductance) {
        true => Verdict::runs(why),
        false => plan.left_out("nothing stops at edges"),
    }
}

/// The name by which a session keeps the gradient before diffusion.
pub(crate) const UNDIFFUSED: &str = "undiffused gradient";

fn find_edges(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let (key, is_wanted) = (plan.key(EDGES.name), plan.wants(Product::Silhouette));
    let weights = [Product::Silhouette, Product::Crease];
    let all = [weights[0], weights[1], Product::Conductance];
    if let Some(kept) = run.kept.as_deref_mut()
        && kept.has(&all, key)
        && kept.has_copy(UNDIFFUSED, key)
    {
        // Weights that are not wanted stay there.
        let taken = if is_wanted { &all[..] } else { &all[2..] };
        kept.take(taken, &mut run.made.outcome.shape);
        return;
    }
    // With a cache the weights may be requested later.
    let with_weights = is_wanted || run.kept.is_some();
    let lengths = run.lengths.take();
    let (found, gradient) = run.timed(EDGES.name, || {
        edges_with_weights(plan, frame, lengths, with_weights, memory)
    });
    let mut shape = Shape {
        silhouette: found.silhouette,
        crease: found.crease,
        conductance: Some(found.conductance),
        ..std::mem::take(&mut run.made.outcome.shape)
    };
    if let Some(kept) = run.kept_if_whole() {
        kept.keep(UNDIFFUSED, key, gradient.clone());
        if !is_wanted {
            kept.put(&weights, &mut shape);
        }
    }
    run.made.undiffused = Some(gradient);
    run.made.outcome.shape = shape;
}
