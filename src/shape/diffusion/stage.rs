//! Diffusion of the gradient ([LW] section 4.3): one gradient per scale.

use crate::frame::{Vector2Planes, Window};
use crate::params::ShapeParams;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::planned::Tile;
use crate::plan::stage::{Stage, Verdict, step};
use crate::product::Product;
use crate::shape::diffusion::cpu::Diffused;
use crate::shape::diffusion::importance::ImportanceLevels;
use crate::shape::diffusion::medium::Medium;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use crate::shape::diffusion::{REACH, cpu};
use crate::shape::edges::stage::{EDGES, UNDIFFUSED};

/// The gradient at the requested scales.
pub(crate) static DIFFUSION: Stage = Stage {
    // Without sweeps the gradient is kept unchanged.
    also_runs: |plan| plan.wants(Product::Gradient),
    takes: |_| vec![Product::Gradient, Product::Conductance],
    // A tile is diffused as a whole, with its borders joined.
    reach_px: |plan| match plan.tile {
        Some(_) => 0,
        None => plan.sweeps().count() * REACH,
    },
    depends_on: |plan| format!("{:?}", plan.sweeps()),
    reads_normals: false,
    name: "diffusion",
    steps: &[step("diffusion", &[Product::Gradient], decide)],
    cpu: diffuse,
    #[cfg(feature = "gpu")]
    gpu: Some(super::gpu::diffuse),
    ..Stage::DEFAULT
};

fn decide(plan: &Plan) -> Verdict {
    let factor = plan.resolution_factor;
    match (plan.wants(Product::Gradient), plan.sweeps().count()) {
        (false, _) => plan.left_out("no curvature is needed"),
        (true, 0) => plan.left_out("a scale of 0"),
        (true, _) => {
            let scale = scale(&plan.shape, factor);
            Verdict::runs(format!("{scale}, {}", plan.sweeps().described()))
        }
    }
}

/// The scale in pixels of the picture, and in pixels of the reference.
fn scale(shape: &ShapeParams, factor: f64) -> String {
    let at = |factor: f64| {
        let sigmas = shape.scales_px().into_iter();
        let said: Vec<_> = sigmas.map(|s| format!("{:.2}", s * factor)).collect();
        said.join(" and ")
    };
    let here = format!("scale {} px", at(factor));
    match shape.reference_height {
        None => here,
        Some(height) => format!("{here} ({} px at a height of {height})", at(1.0)),
    }
}

fn diffuse(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let options = &run.runner.options;
    let key = plan.key(DIFFUSION.name);
    // Only the gradient at the first scale is cached.
    if run.has_kept(&[Product::Gradient], key) && plan.more_px.is_empty() {
        return;
    }
    let kept = run.kept.as_deref();
    let undiffused = run.made.undiffused.take();
    let undiffused = undiffused.or_else(|| kept?.copy(UNDIFFUSED, plan.key(EDGES.name)));
    let undiffused = undiffused.expect("the gradient is kept with its edges");
    let mut gradients = match plan.sweeps().count() {
        0 => vec![undiffused; 1 + plan.more_px.len()],
        _ => {
            let conductance = run.made.outcome.shape.conductance.take();
            let conductance = conductance.expect("slopes spread by conductance");
            let diffused = run.timed("diffusion", || {
                let importance = ImportanceLevels::of(frame, plan.sweeps());
                let medium = Medium {
                    importance: importance.as_ref(),
                    ..Medium::of_whole(&conductance, &frame.mask)
                };
                let sweeps = plan.sweeps();
                let Some(tile) = plan.tile else {
                    return cpu::diffusion(undiffused, medium, sweeps, options, memory);
                };
                let memory = &memory.at_other_size();
                in_tile(undiffused, medium, tile, frame.data_window, |g, medium| {
                    cpu::diffusion(g, medium, sweeps, options, memory)
                })
            });
            run.made.outcome.shape.conductance = Some(conductance);
            run.made.outcome.left_out = diffused.left_out;
            diffused.scales
        }
    };
    run.made.more_gradients = gradients.split_off(1);
    run.made.outcome.shape.gradient = gradients.pop();
}

/// Two planes spread by the conductance of the frame, at every scale of the sweeps.
pub(crate) fn spread(
    run: &mut Execution,
    name: &'static str,
    planes: Vector2Planes,
    sweeps: &DiffusionSchedule,
) -> Vec<Vector2Planes> {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let options = &run.runner.options;
    let conductance = run.made.outcome.shape.conductance.take();
    let conductance = conductance.expect("what spreads takes conductance");
    let spread = run.timed(name, || {
        let medium = Medium::of_whole(&conductance, &frame.mask);
        let Some(tile) = plan.tile else {
            return cpu::diffusion(planes, medium, sweeps, options, memory);
        };
        let memory = &memory.at_other_size();
        in_tile(planes, medium, tile, frame.data_window, |planes, medium| {
            cpu::diffusion(planes, medium, sweeps, options, memory)
        })
    });
    run.made.outcome.shape.conductance = Some(conductance);
    spread.scales
}

/// Diffusion in a frame, of the window `whole`, that repeats a tile: in the tile alone, with its borders joined.
pub(crate) fn in_tile(
    gradient: Vector2Planes,
    medium: Medium,
    tile: Tile,
    whole: Window,
    spread: impl FnOnce(Vector2Planes, Medium) -> Diffused,
) -> Diffused {
    let importance = medium.importance.map(|levels| ImportanceLevels {
        plane: levels.plane.crop(whole, tile.window),
        weights: levels.weights.clone(),
        ..*levels
    });
    let gradient = gradient.mapped(|plane| plane.crop(whole, tile.window));
    let of_tile = Medium {
        conductance: &medium.conductance.crop(whole, tile.window),
        mask: &medium.mask.crop(whole, tile.window),
        importance: importance.as_ref(),
        wraps: tile.wraps,
    };
    let spread = spread(gradient, of_tile);
    let scales = spread.scales.into_iter();
    let repeated = scales.map(|field| field.mapped(|plane| plane.repeated(tile.window, whole)));
    Diffused {
        scales: repeated.collect(),
        ..spread
    }
}
