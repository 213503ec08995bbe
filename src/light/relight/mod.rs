//! Relighting: batches of covered pixels, gathered from the frame's planes, lit, and scattered back.

pub(crate) mod albedo;
pub(crate) mod albedo_search;
pub(crate) mod batch;
pub(crate) mod curvature;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu_lights;
pub(crate) mod grain;
pub(crate) mod look_up;
pub(crate) mod mirrors;
pub(crate) mod pilot;
pub(crate) mod raking;
pub(crate) mod rim;
pub(crate) mod samples;
pub(crate) mod scene;
pub(crate) mod setting;
pub(crate) mod shade;
pub(crate) mod stage;
pub(crate) mod traced;

use crate::frame::memory::Memory;
use crate::frame::{ColorPlanes, Frame, Projection, SightLines, Vector3Planes};
use crate::kernel::simd::wide;
use crate::light::alignment::SIGMAS_PX;
use crate::light::prepared_environment::EnvironmentCache;
use crate::light::prepared_environment::Illuminants;
use crate::light::relight::albedo_search::AlbedoSearch;
use crate::light::relight::batch::{Batch, RowShape};
use crate::light::relight::curvature::{CurvatureRow, CurvedBy, FlowSlopes};
use crate::light::relight::grain::without_grain;
use crate::light::relight::mirrors::Mirrors;
use crate::light::relight::scene::{Aligned, LitScene};
use crate::light::relight::setting::{Albedo, Relighting};
use crate::light::shadows::cast::cast;
use crate::light::sum::lobes::Lobes;
use crate::light::sum::{Directed, Scaled, Shading, TowardLight};
use crate::params::Magnitudes;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::outcome::Shape;
use crate::product::Product;
use crate::shape::coarse_normals::coarse_normals;
use rayon::prelude::*;
use std::borrow::Cow;

/// Rows per task: few, so that threads finish together, and enough to fill batches.
const ROWS_PER_TASK: usize = 8;

/// Relights the frame of a run.
pub(crate) fn relight(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let relighting = plan.relighting().expect("the plan says how to light");
    let (illumination, specular) = (run.illumination(), run.inputs.specular);
    let illumination = illumination.expect("new light has lights");
    let weights = frame.luminance_weights();
    let kept = &run.runner.caches.of::<EnvironmentCache>();
    let around = Illuminants::new(illumination, relighting, weights, kept, memory, |make| {
        run.timed("environment", make)
    });
    if memory.is_cancelled() {
        return;
    }
    run.made.outcome.environment_gain = around.gain();
    run.made.outcome.takes_picture = relighting.takes_picture();
    run.made.outcome.casts_shadows = relighting.casting.choices();
    run.made.outcome.light_choice = around.choice();
    let estimate = (relighting.albedo == Albedo::Estimate).then(|| {
        run.copied_or("albedo", Some(""), |run| {
            run.timed_on("albedo-estimate", |run| match relighting.estimate {
                Some(found) => found,
                None => run.searched(AlbedoSearch::default()).estimate(),
            })
        })
    });
    let normals = run.normals.take();
    let normal = normals.as_ref().unwrap_or(&frame.normal);
    let traced = specular.zip(plan.specular).filter(|_| relighting.traced);
    let specular_mask = traced.and_then(|(scene, _)| scene.mask_in(frame));
    let lit_mask = specular_mask.as_ref().unwrap_or(&frame.mask);
    let mirrors = traced.and_then(|(scene, params)| {
        run.timed("specular-maps", || {
            Mirrors::new((frame, lit_mask), scene, &params, (relighting, &around))
        })
    });
    run.made.outcome.middle_light = mirrors
        .as_ref()
        .and_then(|mirrors| mirrors.intensity.middle());
    let for_diffuse = match around.sampled() {
        Some(_) => around.base_lights(),
        None => around.lights(),
    };
    let shadows = cast(run, normal, for_diffuse);
    if memory.is_cancelled() {
        return;
    }
    let turns = match relighting.rakes {
        true => raking::turns(run, normal, &illumination.directional),
        false => None,
    };
    let quiet = without_grain(run).map(Cow::Owned);
    let aligned = relighting.aligns.then(|| Aligned {
        coarse: coarse_normals(run, normal, &SIGMAS_PX),
        strength: relighting.params.align,
        gain: 1.0,
    });
    let shape = std::mem::take(&mut run.made.outcome.shape);
    let gain = run.made.outcome.gain.unwrap_or(0.0);
    let eye = eye_directions(frame);
    let shading = shading(plan, relighting, gain, eye.is_none());
    let mirror_shading = shading.filter(|_| relighting.gloss);
    let mirror_shading = mirror_shading.map(|shading| Shading {
        lobes: Lobes::Mirror,
        ..shading
    });
    let tones = relighting.params.tones();
    let most_tone = around.most_tone(illumination, relighting, weights);
    let mut scene = LitScene {
        frame,
        relighting,
        curvature: curvature(plan, &shape),
        grain: shape.direction.as_ref().filter(|_| relighting.grain),
        albedo: match relighting.albedo {
            Albedo::Layer => frame.albedo.as_ref(),
            Albedo::Picture | Albedo::Estimate => frame.color.as_ref(),
            Albedo::White => None,
        },
        estimate,
        gain,
        magnitudes: plan.scaling.magnitudes(),
        invariant_point: plan.scaling.invariant_point,
        luminance: weights,
        gloss: frame.light.gloss.as_ref().filter(|_| relighting.gloss),
        mirror_shading,
        keeps_mirrored: around.ready.gloss.is_none(),
        is_glossy: mirrors.is_some()
            || relighting.gloss
            || around.is_mirrored()
            || shading.is_some_and(|s| s.lobes.are_glossy()),
        shading,
        lights: match relighting.casting.lamps.is_cast {
            true => Vec::new(),
            false => Directed::all(&illumination.directional),
        },
        shadows: shadows.unwrap_or_default(),
        around_lights: Directed::all(around.lights()),
        base_lights: Directed::all(around.base_lights()),
        occlusion: quiet.or(frame.light.occlusion.as_ref().map(Cow::Borrowed)),
        turns,
        aligned,
        points: &illumination.points,
        sight: SightLines::of(frame),
        around,
        mirrors,
        lit: lit_mask,
        eye,
        tones: tones.map(|tones| (tones, most_tone)),
    };
    if relighting.aligns {
        let gain = run.timed("light-mean", || kept_mean(&scene, normal, memory));
        scene.aligned = scene.aligned.map(|aligned| Aligned { gain, ..aligned });
    }
    let color = run.timed("relight", || lit(&scene, normals, memory));
    drop(scene);
    run.made.outcome.shape = shape;
    run.made.outcome.color = Some(color);
}

/// The source of curvature, if it is needed.
fn curvature<'s>(plan: &Plan, shape: &'s Shape) -> Option<CurvedBy<'s>> {
    let slopes = || {
        let shape_is_there = "curvature is planned with its gradient";
        FlowSlopes {
            gradient: shape.gradient.as_ref().expect(shape_is_there),
            conductance: shape.conductance.as_ref().expect(shape_is_there),
            factor: plan.resolution_factor as f32,
        }
    };
    match &shape.trace {
        _ if plan.wants(Product::Hessian) => Some(CurvedBy::Hessian(slopes())),
        Some(trace) => Some(CurvedBy::Made(trace)),
        None if plan.wants(Product::Trace) => Some(CurvedBy::Trace(slopes())),
        None => None,
    }
}

/// Shading by single lights, if any are summed.
fn shading(plan: &Plan, relighting: &Relighting, gain: f32, far: bool) -> Option<Shading> {
    let scaling = &plan.scaling;
    let Magnitudes {
        diffuse, specular, ..
    } = scaling.magnitudes();
    let toward_light = relighting.toward_light.then_some(TowardLight {
        gain,
        anisotropy: scaling.anisotropy,
        magnitudes: [diffuse, specular],
    });
    let lobes = Lobes::of(&relighting.params.material, far)?;
    relighting.sums.then_some(Shading {
        warped: relighting.has_jacobian(),
        scaled: relighting.scales.then_some(Scaled {
            invariant_point: scaling.invariant_point,
            toward_light,
        }),
        lobes,
    })
}

/// Directions to the eye by column and by row; `None` if all are along z.
fn eye_directions(frame: &Frame) -> Option<[Vec<f32>; 2]> {
    let projection = frame.camera.as_ref()?.projection;
    let Projection::Perspective { .. } = projection else {
        return None;
    };
    let data = frame.data_window;
    let centre = |first: i32, i: usize| f64::from(first) + i as f64 + 0.5;
    let columns = (0..data.width()).map(|x| projection.to_eye(centre(data.x0, x), 0.0).x as f32);
    let rows = (0..data.height()).map(|y| projection.to_eye(0.0, centre(data.y0, y)).y as f32);
    Some([columns.collect(), rows.collect()])
}

/// The lit picture, in the memory of `normals` that the frame no longer has; where uncovered the frame's own, or black.
fn lit(scene: &LitScene, normals: Option<Vector3Planes>, memory: &Memory) -> ColorPlanes {
    let mask = scene.lit;
    let width = mask.width();
    let light = |batch: &mut Batch, rows: &mut [&mut [f32]; 3], first| {
        wide!(|fma| shade::light_batch(fma, batch, scene));
        batch.scatter(rows, first, width);
    };
    let is_in_place = normals.is_some();
    let mut planes = match normals {
        Some(Vector3Planes { x, y, z }) => [x, y, z],
        None => [(); 3].map(|()| memory.unwritten(mask)),
    };
    let own = &scene.frame.normal;
    let own = [&own.x, &own.y, &own.z];
    let row = || vec![0.0; width];
    let [r, g, b] = planes
        .each_mut()
        .map(|plane| plane.samples_mut().par_chunks_mut(width * ROWS_PER_TASK));
    r.zip(g).zip(b).enumerate().for_each_init(
        || {
            let normal = [row(), row(), row()];
            (Box::new(Batch::new()), CurvatureRow::new(width), normal)
        },
        |(batch, curvature, normal), (task, ((r, g), b))| {
            let first = task * ROWS_PER_TASK;
            let mut rows = [r, g, b];
            keep_uncovered(scene, first, &mut rows);
            let count = rows[0].len() / width;
            for y in (first..first + count).take_while(|_| !memory.is_cancelled()) {
                if let Some(made_of) = &scene.curvature {
                    curvature.make(made_of, scene.frame, y);
                }
                if is_in_place {
                    let of_row = (y - first) * width..(y - first + 1) * width;
                    let copies = normal.iter_mut().zip(&rows);
                    copies.for_each(|(copy, row)| copy.copy_from_slice(&row[of_row.clone()]));
                }
                let shape = RowShape {
                    normal: match is_in_place {
                        true => normal.each_ref().map(Vec::as_slice),
                        false => own.map(|plane| plane.row(y)),
                    },
                    curvature,
                };
                for run in mask.runs(y) {
                    batch.take_run(scene, shape, y, run, |batch| light(batch, &mut rows, first));
                }
            }
            batch.finish(|batch| light(batch, &mut rows, first));
        },
    );
    let [r, g, b] = planes;
    let mut color = ColorPlanes { r, g, b };
    if let Some(alpha) = &scene.frame.alpha
        && mask.count() < alpha.samples().len()
    {
        rim::light_rims(&mut color, alpha, mask);
    }
    color
}

/// Rows between those that the mean of the light is taken from.
const ROWS_APART: usize = 4;

/// The gain of turned light that keeps its mean luminance over the surface.
fn kept_mean(scene: &LitScene, normal: &Vector3Planes, memory: &Memory) -> f32 {
    let mask = scene.lit;
    let rows: Vec<usize> = (0..mask.height()).step_by(ROWS_APART).collect();
    let of_rows = rows.par_iter().map_init(
        || (Box::new(Batch::new()), CurvatureRow::new(0)),
        |(batch, curvature), &y| {
            let mut sums = [0.0; 2];
            let mut add = |batch: &mut Batch| {
                let found = wide!(|fma| shade::measure_turned(fma, batch, scene));
                sums = [sums[0] + found[0], sums[1] + found[1]];
            };
            let normal = [&normal.x, &normal.y, &normal.z].map(|plane| plane.row(y));
            let shape = RowShape { normal, curvature };
            let runs = mask.runs(y).take_while(|_| !memory.is_cancelled());
            runs.for_each(|run| batch.take_run(scene, shape, y, run, &mut add));
            batch.finish(add);
            sums
        },
    );
    let sums: Vec<[f64; 2]> = of_rows.collect();
    let [before, after] = [0, 1].map(|k| sums.iter().map(|sum| sum[k]).sum::<f64>());
    let is_lit = before > 0.0 && after > 0.0;
    if is_lit { (before / after) as f32 } else { 1.0 }
}

/// Fills pixels without a surface from the frame's picture, or with black.
fn keep_uncovered(scene: &LitScene, first: usize, rows: &mut [&mut [f32]; 3]) {
    let mask = scene.lit;
    let width = mask.width();
    let planes = scene.frame.color.as_ref();
    let planes = planes.map(|color| [&color.r, &color.g, &color.b]);
    for (k, rows) in rows.iter_mut().enumerate() {
        for (i, row) in rows.chunks_mut(width).enumerate() {
            let y = first + i;
            for gap in mask.gaps(y) {
                let out = &mut row[gap.clone()];
                match planes {
                    Some(planes) => out.copy_from_slice(&planes[k].row(y)[gap]),
                    None => out.fill(0.0),
                }
            }
        }
    }
}
