//! The height: only where it is asked for.

use super::cpu::find_height;
use super::{NAME, goes_over_edges};
use crate::plan::stage::{Stage, Verdict, step};
use crate::product::Product;

/// The height from normals, and what it misses of them.
pub(crate) static HEIGHT: Stage = Stage {
    name: NAME,
    steps: &[
        step(NAME, &[Product::Height], |plan| {
            match plan.wants(Product::Height) || plan.wants(Product::HeightResidual) {
                true => Verdict::runs("asked for"),
                false => Verdict::left_out("not asked for"),
            }
        }),
        step(
            "height-residual",
            &[Product::HeightResidual],
            |plan| match plan.wants(Product::HeightResidual) {
                true => Verdict::runs("asked for"),
                false => Verdict::left_out("not asked for"),
            },
        ),
    ],
    takes: |plan| match goes_over_edges(plan) {
        true => Vec::new(),
        false => vec![Product::Conductance],
    },
    depends_on: |plan| {
        let shape = &plan.shape;
        format!(
            "{} {} {} {}",
            shape.min_nz,
            shape.height_tolerance,
            shape.height_detail,
            goes_over_edges(plan)
        )
    },
    cpu: find_height,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("height"),
    ..Stage::DEFAULT
};
