//! Occlusion: only where it is asked for.

use super::cpu::{find_sky, radius_px};
use crate::plan::Plan;
use crate::plan::stage::{Stage, Verdict, step};
use crate::product::Product;

/// The sky seen from each pixel, and from where on average.
pub(crate) static OCCLUSION: Stage = Stage {
    name: "occlusion",
    steps: &[step(
        "occlusion",
        &[Product::Sky, Product::BentNormal],
        |plan| match is_wanted(plan) {
            true => Verdict::runs(format!(
                "asked for, within {} px",
                plan.shape.occlusion_radius
            )),
            false => Verdict::left_out("not asked for"),
        },
    )],
    takes: |_| vec![Product::Height],
    reach_px: |plan| match plan.tile {
        // What lies around a tile is known from the tile.
        Some(_) => 0,
        None => radius_px(plan),
    },
    depends_on: |plan| {
        format!(
            "{} {}",
            plan.shape.occlusion_radius, plan.shape.occlusion_slices
        )
    },
    cpu: find_sky,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("occlusion"),
    ..Stage::DEFAULT
};

fn is_wanted(plan: &Plan) -> bool {
    plan.wants(Product::Sky) || plan.wants(Product::BentNormal)
}
