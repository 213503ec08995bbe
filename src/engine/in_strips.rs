//! A frame in strips of rows, where a run may take less memory than the whole frame does.

use crate::engine::backends::Engine;
use crate::engine::cpu::runner::RunFrame;
use crate::engine::inputs::PlanInputs;
use crate::engine::part::FramePart;
use crate::engine::run::Run;
use crate::engine::strip_search::StripSearch;
use crate::engine::tiles::{Strips, rows_of};
use crate::error::{Error, Result};
use crate::frame::{Frame, LightLayers};
use crate::kernel::timings::add_timings;
use crate::light::shadows::keys::MOST_KEYS;
use crate::plan::Plan;
use crate::plan::outcome::Outcome;
use std::ops::Range;

/// Planes that stages take at most beside their results, three gradients of the diffusion above all.
const BESIDE: usize = 8;

/// Planes beside results where stages take the frame whole: also 16 horizons of a byte, shadows of keys, and normals at
/// three scales.
const BESIDE_WHOLE: usize = BESIDE + 4 + MOST_KEYS / 2 + 6;

/// Planes of layers of light, beside those of groups.
const OF_LIGHT: usize = 18;

/// Planes of curvature at a further scale, with its gradient and its Hessian.
const OF_SCALE: usize = 9;

/// Bytes that a pixel of a strip takes at most, beside the frame and the result.
fn bytes_a_pixel(plan: &Plan, frame: &Frame) -> u64 {
    let made = plan.stages.iter().flat_map(|stage| stage.gives());
    let made: usize = made.map(|product| product.row().components.len()).sum();
    let single = [
        &frame.depth,
        &frame.normal_length,
        &frame.occlusion,
        &frame.importance,
        &frame.strength,
        &frame.confidence,
        &frame.alpha,
    ];
    let colors = [&frame.color, &frame.albedo].into_iter().flatten().count();
    let light = match frame.light == LightLayers::default() {
        true => 0,
        false => OF_LIGHT + 3 * frame.light.groups.len(),
    };
    let of_frame = 3 + single.into_iter().flatten().count() + 3 * colors + light;
    let beside = if plan.takes_whole() {
        BESIDE_WHOLE
    } else {
        BESIDE
    };
    let planes = made + of_frame + beside + OF_SCALE * plan.more_px.len();
    (size_of::<f32>() * planes) as u64
}

impl Engine {
    /// As the frame whole, bit for bit, in strips that take as much memory as the run allows. The outcome of a picture lacks
    /// the shape.
    ///
    /// # Errors
    /// [`Error::Unfit`] where so much memory holds no strip, and for what takes a frame whole.
    pub(super) fn execute_in_strips(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: PlanInputs,
        run: &Run,
        most_bytes: u64,
    ) -> Result<Outcome> {
        let whole = frame.data_window;
        let of_row = (bytes_a_pixel(plan, frame) * whole.width() as u64).max(1);
        let most_rows = usize::try_from(most_bytes / of_row).unwrap_or(usize::MAX);
        if most_rows >= whole.height() {
            return self.execute_here(plan, RunFrame::Shared(frame), inputs, run);
        }
        if plan.drawing.is_some() || plan.takes_whole() {
            let found = "a drawing, heights, skies, cast shadows and light turned to the form take the frame whole";
            return Err(Error::Unfit {
                found: found.into(),
                remedy: "allow more memory, or leave shadows off",
            });
        }
        let strips = Strips::new(plan.reach(), whole.height(), most_rows);
        let strips = strips.ok_or_else(|| {
            let least = of_row * (2 * plan.reach() as u64 + 1);
            let found = format!("a strip takes {} MiB at least", least.div_ceil(1 << 20));
            Error::Unfit {
                found,
                remedy: "allow more memory",
            }
        })?;
        let choices = StripSearch::choices(self.cpu_runner(), plan, whole, |search| {
            strips.each().try_for_each(|(takes, gives)| {
                run.watch().check()?;
                let part = part_of(plan, frame, inputs, &takes, &gives)?;
                search.look(&part.frame, gives)
            })
        })?;
        let mut plan = plan.clone();
        choices.settle(&mut plan);
        let mut all: Option<Outcome> = None;
        for (takes, gives) in strips.each() {
            let part = part_of(&plan, frame, inputs, &takes, &gives)?;
            let rows = takes.start + gives.start..takes.start + gives.end;
            let mut made = self.execute_here(
                &part.plan,
                RunFrame::Shared(&part.frame),
                part.inputs(inputs),
                run,
            )?;
            let (from, to) = (part.frame.data_window, rows_of(whole, &rows));
            if !plan.makes_shape_alone() {
                let shape = std::mem::take(&mut made.shape);
                self.recycle(Outcome {
                    shape,
                    ..Outcome::default()
                });
            }
            made.crop(from, to);
            let all = all.get_or_insert_with(|| made.blank(whole));
            all.paste(&made, whole, to);
            add_timings(&mut all.timings, &made.timings);
            self.recycle(made);
        }
        Ok(all.unwrap_or_default())
    }
}

/// The rows that a strip takes, made for those that it gives.
fn part_of(
    plan: &Plan,
    frame: &Frame,
    inputs: PlanInputs,
    takes: &Range<usize>,
    gives: &Range<usize>,
) -> Result<FramePart> {
    let rows = takes.start + gives.start..takes.start + gives.end;
    FramePart::around(rows_of(frame.data_window, &rows), plan, frame, inputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Request;
    use crate::frame::{ColorPlanes, Plane};
    use crate::light::lights::{DirectionalLight, Illumination};
    use crate::params::{AlbedoSource, Method, Params, RelightParams, ScalingParams, ShapeParams};
    use crate::plan::Goal;
    use crate::product::Product;
    use crate::scenes::Scene;

    /// A row of 100 pixels of 40 to 80 planes takes 16,000 to 32,000 bytes: of 8 MB a strip has less than 500 of 900 rows.
    #[test]
    fn strips_are_the_whole_bit_for_bit() {
        let mut frame = Scene::waves(100, 900).frame;
        let tone = |hue: f32| {
            Plane::from_fn(100, 900, |x, y| {
                hue * (0.5 + 0.4 * ((x + 2 * y) as f32 / 9.0).sin())
            })
        };
        frame.color = Some(ColorPlanes {
            r: tone(0.9),
            g: tone(0.7),
            b: tone(0.5),
        });
        let light = Illumination {
            directional: vec![DirectionalLight::white([135.0, 40.0])],
            ..Illumination::default()
        };
        let relight = RelightParams {
            albedo: AlbedoSource::Estimate,
            method: Method::Both,
            ..RelightParams::default()
        };
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let engine = Engine::cpu();
        for request in [
            Request::enhance(Params::of(shape, scaling)),
            Request::new(
                Goal::Layers {
                    and: &[],
                    more_px: &[3.0],
                },
                Params::of(shape, scaling),
            ),
            Request::relight(
                Params {
                    relight,
                    ..Params::of(shape, scaling)
                },
                &light,
            ),
        ] {
            let whole = engine.run(&request, &frame, &Run::new()).unwrap();
            let limited = Run::new().max_memory(8_000_000);
            let strips = engine.run(&request, &frame, &limited).unwrap();
            assert_eq!(
                (strips.gain, strips.white_level),
                (whole.gain, whole.white_level)
            );
            // Pictures alone, without their shape.
            let is_made = |(product, _): &(Product, _)| !strips.planes(*product).is_empty();
            let both = strips.products().zip(whole.products().filter(is_made));
            assert!(strips.products().count() > 0);
            for ((product, a), (of_whole, b)) in both {
                assert!(product == of_whole && a == b, "{product:?}, {of_whole:?}");
            }
            let few = Run::new().max_memory(100_000);
            let refused = engine.run(&request, &frame, &few).unwrap_err().to_string();
            assert!(refused.contains("a strip takes"), "{refused}");
        }
    }
}
