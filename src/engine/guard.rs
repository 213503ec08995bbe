//! The last guard: results are finite wherever all inputs are.
//!
//! Ranges of parameters, cameras and attributes keep every stage within single precision. Exceptions, such as
//! brightened pictures of 1e38, are found here before anything is written.

use crate::engine::cpu;
use crate::engine::outcome::Outcome;
use crate::frame::{ColorPlanes, Frame, Plane};
use crate::params::{Adaptive, Scale, ScalingParams, ShapeParams};
use crate::plan::stage::Step;
use crate::plan::stages::stages;
use crate::plan::{Available, Goal, Plan};
use crate::product::Product;
use glam::Vec2;
use rayon::prelude::*;

/// Non-finite results from finite inputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct NotFinite {
    /// The first stage that produced one; several if they cannot be separated.
    pub stage: String,
    /// Number of samples, and where.
    pub found: String,
}

/// Finds non-finite samples of `results` where all planes of `frame` are finite. `results` have the size of the frame,
/// and derive from `outcome` of `plan`.
pub(crate) fn not_finite(
    plan: &Plan,
    frame: &Frame,
    outcome: &Outcome,
    results: &[&Plane],
) -> Option<NotFinite> {
    let spoiled = results.iter().filter(|plane| !is_finite(plane));
    let spoiled = spoiled.flat_map(|plane| non_finite_pixels(plane));
    let inputs = inputs(frame);
    let mut ours = spoiled.filter(|&(x, y)| inputs.iter().all(|plane| plane.at(x, y).is_finite()));
    let (x, y) = ours.next()?;
    let count = 1 + ours.count();
    let samples = if count == 1 { "sample" } else { "samples" };
    let corner = frame.data_window;
    Some(NotFinite {
        stage: stage(plan, frame, outcome),
        found: format!(
            "{count} {samples} that are not finite, the first at ({}, {})",
            i64::from(corner.x0) + x as i64,
            i64::from(corner.y0) + y as i64
        ),
    })
}

/// Finds non-finite lines of a drawing.
pub(crate) fn lines_not_finite(plan: &Plan, frame: &Frame, outcome: &Outcome) -> Option<NotFinite> {
    let drawing = outcome.drawing.as_ref()?;
    let strokes = drawing.lines.iter().map(|l| (&l.points[..], &l.widths[..]));
    let contours = drawing.contour_lines.iter().chain(&drawing.interior_lines);
    let contours = contours.map(|l| (&l.points[..], &l.widths[..]));
    let is_finite = |(points, widths): &(&[Vec2], &[f32])| {
        points.iter().all(|point| point.is_finite()) && widths.iter().all(|width| width.is_finite())
    };
    let count = strokes
        .chain(contours)
        .filter(|line| !is_finite(line))
        .count();
    (count > 0).then(|| NotFinite {
        stage: stage(plan, frame, outcome),
        found: format!("{count} lines that are not finite"),
    })
}

/// Samples checked by one task.
const SAMPLES_PER_TASK: usize = 1 << 16;

/// Exponent bits of a single: all set in infinities and NaN only.
const EXPONENT: u32 = 0x7f80_0000;

/// Whether all samples are finite. Counts bit patterns, so that the loop vectorises.
fn is_finite(plane: &Plane) -> bool {
    let finite = |samples: &[f32]| {
        let bad = samples
            .iter()
            .map(|v| u32::from(v.to_bits() & EXPONENT == EXPONENT));
        bad.sum::<u32>() == 0
    };
    plane.samples().par_chunks(SAMPLES_PER_TASK).all(finite)
}

/// Column and row of each non-finite sample.
fn non_finite_pixels(plane: &Plane) -> impl Iterator<Item = (usize, usize)> {
    let samples = plane.samples().iter().enumerate();
    let bad = samples.filter(|(_, sample)| !sample.is_finite());
    bad.map(|(i, _)| (i % plane.width(), i / plane.width()))
}

/// Every plane of a frame.
fn inputs(frame: &Frame) -> Vec<&Plane> {
    let light = &frame.light;
    let lobes = light.lobes.iter();
    let lobes = lobes.flat_map(|l| [&l.direct, &l.indirect, &l.color, &l.albedo]);
    let colors = [&frame.color, &frame.albedo].into_iter().chain(lobes);
    let colors = colors.flatten();
    let colors = colors.chain(light.groups.iter().map(|group| &group.light));
    let normal = &frame.normal;
    let single = [
        &frame.normal_length,
        &frame.depth,
        &frame.occlusion,
        &frame.importance,
        &frame.alpha,
        &light.occlusion,
    ];
    colors
        .flat_map(planes_of)
        .chain([&normal.x, &normal.y, &normal.z])
        .chain(single.into_iter().flatten())
        // Normals may have been consumed; where they are not finite the mask shows no surface.
        .filter(|plane| !plane.samples().is_empty())
        .collect()
}

fn planes_of(color: &ColorPlanes) -> [&Plane; 3] {
    [&color.r, &color.g, &color.b]
}

/// The first step of `plan` that gives non-finite samples. Shape is recomputed: this is rare, and a device or a picture
/// output does not hold it. Without normals and depth it cannot be.
fn stage(plan: &Plan, frame: &Frame, outcome: &Outcome) -> String {
    let by_shape = || {
        let is_there = !frame.normal.z.samples().is_empty()
            && (frame.depth.is_some() || !plan.available.depth);
        (plan.wants_curvature() && is_there).then(|| shape_step(plan, frame, outcome))
    };
    if let Some(step) = by_shape().flatten() {
        return step.name.into();
    }
    let spoiled: &[Product] = match outcome.planes(Product::Picture).into_iter().all(is_finite) {
        false => &[Product::Picture],
        true if outcome.drawing.is_some() => {
            &[Product::Strokes, Product::Contours, Product::Interior]
        }
        true => &[],
    };
    let gives = |step: &&Step| spoiled.iter().any(|product| step.gives.contains(product));
    let names: Vec<_> = steps(plan).filter(gives).map(|step| step.name).collect();
    match names.is_empty() {
        // Everything is finite until colours are converted for a display.
        true => "view-transform".into(),
        false => names.join(" or "),
    }
}

/// The steps that a plan runs, in order.
fn steps(plan: &Plan) -> impl Iterator<Item = &'static Step> {
    let all = stages().flat_map(|stage| stage.steps);
    all.filter(|step| plan.runs(step.name))
}

/// The first failing step of shape: on the CPU, undiffused and diffused, else where it was run.
fn shape_step(plan: &Plan, frame: &Frame, outcome: &Outcome) -> Option<&'static Step> {
    let again = |scale| {
        let shape = ShapeParams {
            scale,
            ..plan.shape
        };
        let scaling = ScalingParams {
            curvature_gain: outcome.gain.map_or(Adaptive::Auto, Adaptive::Fixed),
            ..plan.scaling
        };
        let plan = Plan::new(Goal::Layers, Available::in_frame(frame), shape, scaling).ok()?;
        let outcome = cpu::run(&plan, frame).ok()?;
        first_of_shape(&plan, &outcome)
    };
    again(Scale::Iterations(0))
        .or_else(|| again(plan.shape.scale))
        .or_else(|| first_of_shape(plan, outcome))
        .filter(|step| !step.gives.contains(&Product::ViewDirection) || plan.runs(step.name))
}

/// The first step of shape with non-finite planes. If a product takes several steps the last one is blamed: after
/// diffusion the earlier gradient is no longer available.
fn first_of_shape(plan: &Plan, outcome: &Outcome) -> Option<&'static Step> {
    let mut bad = Product::all()
        .filter(|product| product.is_of_shape() && !outcome.at_all_scales(*product).all(is_finite));
    let product = bad.next()?;
    steps(plan)
        .filter(|step| step.gives.contains(&product))
        .last()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::scenes::Scene;

    /// Waves with a grey picture, and the plan that enhances them with these parameters.
    fn waves(shape: ShapeParams) -> (Plan, Frame) {
        let mut frame = Scene::waves(40, 30).frame;
        let grey = Plane::filled(40, 30, 0.5);
        frame.color = Some(ColorPlanes {
            r: grey.clone(),
            g: grey.clone(),
            b: grey,
        });
        let scaling = ScalingParams::default();
        let plan = Plan::new(Goal::Enhance, Available::in_frame(&frame), shape, scaling);
        (plan.unwrap(), frame)
    }

    fn checked(plan: &Plan, frame: &Frame, outcome: &Outcome) -> Option<NotFinite> {
        let color = outcome.color.as_ref().unwrap();
        not_finite(plan, frame, outcome, &planes_of(color))
    }

    #[test]
    fn a_result_that_is_not_finite_passes_only_where_an_input_is_not() {
        let (plan, mut frame) = waves(ShapeParams::default());
        let mut outcome = cpu::run(&plan, &frame).unwrap();
        assert_eq!(checked(&plan, &frame, &outcome), None);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            // The last sample of the plane, and two of one pixel.
            let color = outcome.color.as_mut().unwrap();
            color.b.samples_mut()[40 * 30 - 1] = bad;
            color.r.samples_mut()[40 * 7 + 3] = bad;
            let found = checked(&plan, &frame, &outcome).unwrap();
            assert_eq!(found.stage, "radiance-scaling");
            assert!(found.found.starts_with("2 samples") && found.found.ends_with("(3, 7)"));
        }
        // Fireflies in the input picture.
        let color = frame.color.as_mut().unwrap();
        color.g.samples_mut()[40 * 7 + 3] = f32::NAN;
        let found = checked(&plan, &frame, &outcome).unwrap();
        assert!(found.found.starts_with("1 sample that"), "{found:?}");
        let color = frame.color.as_mut().unwrap();
        color.g.samples_mut()[40 * 30 - 1] = f32::INFINITY;
        assert_eq!(checked(&plan, &frame, &outcome), None);
    }

    #[test]
    fn the_stage_that_failed_first_is_named() {
        let (plan, frame) = waves(ShapeParams::default());
        let mut outcome = cpu::run(&plan, &frame).unwrap();
        let name = |outcome: &Outcome| stage(&plan, &frame, outcome);
        // The result is finite, and so is the recomputed shape: the colour conversion came after it.
        assert_eq!(name(&outcome), "view-transform");
        let spoil = |plane: &mut Plane| plane.samples_mut()[77] = f32::NAN;
        spoil(&mut outcome.color.as_mut().unwrap().g);
        assert_eq!(name(&outcome), "radiance-scaling");
        // Values that only a device gave, from the last stage to the first.
        spoil(outcome.shape.trace.as_mut().unwrap());
        assert_eq!(name(&outcome), "trace");
        spoil(&mut outcome.shape.gradient.as_mut().unwrap().y);
        assert_eq!(name(&outcome), "diffusion");
        spoil(outcome.shape.conductance.as_mut().unwrap());
        assert_eq!(name(&outcome), "conductance");
    }

    #[test]
    fn slopes_that_the_gradient_itself_makes_infinite_are_its_own() {
        // Normals of length 1e30, which no file gives: where n_z is 0 slopes are 0.001^-4 times as large, 1e42.
        let (plan, mut frame) = waves(ShapeParams {
            foreshortening: 4.0,
            min_nz: 1e-3,
            ..ShapeParams::default()
        });
        frame.normal.x.samples_mut().fill(1e30);
        frame.normal.z.samples_mut().fill(0.0);
        let outcome = cpu::run(&plan, &frame).unwrap();
        let gradient = outcome.shape.gradient.as_ref().unwrap();
        assert!(!is_finite(&gradient.x));
        let conductance = outcome.shape.conductance.as_ref().unwrap();
        assert!(is_finite(conductance));
        assert_eq!(stage(&plan, &frame, &outcome), "gradient");
    }
}
