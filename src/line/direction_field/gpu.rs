//! The field of stroke directions: curvature patch by patch, averaged over surfaces, and brought back to pixels.

use crate::engine::gpu::run::Run;
use crate::frame::Frame;
use crate::line::direction::gpu::{Gaps, OF_THE_REST, SpreadParams, spread_params};
use crate::line::direction_field::gpu_kernels::{
    BETWEEN_PATCHES, BetweenPatchesBuffers, CHAIN_MEANS, ChainMeansBuffers, DirectionParams,
    PATCH_DIRECTIONS, PATCH_FORMS, PatchDirectionsBuffers, PatchFormsBuffers, RUN_CELLS,
    SETTLE_PATCHES, SUM_RUNS, SettlePatchesBuffers, SumRunsBuffers,
};
use crate::line::direction_field::gpu_patches::{Patches, STAGE};
use crate::line::direction_field::setting::{
    FORM_REACH, FieldSetting, NEAR, SURROUNDING_PASSES, SURROUNDINGS,
};
use crate::line::gpu_canvas::StrokeFields;
use crate::params::{FieldParams, StrokeDirections};
use crate::plan::Plan;

/// Finds the directions of strokes along the edges that the device has.
pub(crate) fn find(run: &mut Run) {
    let (plan, frame) = (run.plan, run.frame);
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let shape = run.made.shape.as_ref().expect("edges come first");
    let conductance = shape.conductance.clone();
    let fields = run.stroke_fields(plan, &params.field, params.directions, frame, &conductance);
    run.canvas.fields = Some(fields);
}

impl Run<'_> {
    /// One field for each of the directions wanted.
    pub(crate) fn stroke_fields(
        &mut self,
        plan: &Plan,
        params: &FieldParams,
        directions: StrokeDirections,
        frame: &Frame,
        conductance: &wgpu::Buffer,
    ) -> StrokeFields {
        let setting = FieldSetting::new(plan, params, frame);
        let patches = self.patches(plan, params, &setting, frame, conductance);
        let forms = self.patch_forms(&patches, FORM_REACH * setting.cells);
        let wanted = directions.wanted();
        let families = (0..).zip(wanted).filter(|(_, is_wanted)| *is_wanted);
        let directions = (0..).zip(families).map(|(order, (family, _))| {
            let mut of_family = DirectionParams {
                family,
                order,
                ..patches.params
            };
            if let Some(fixed) = setting.fixed {
                [of_family.fixed_x, of_family.fixed_y] = fixed[order as usize].to_array();
            }
            let settled = self.settled(&patches, &of_family, params, &setting, &forms);
            let gaps = self.between_patches(&patches, &of_family, &settled);
            self.buffers.recycle([settled]);
            let params = SpreadParams {
                order,
                is_fixed: of_family.is_fixed,
                fixed_x: of_family.fixed_x,
                fixed_y: of_family.fixed_y,
                ..spread_params(frame, &setting.sight)
            };
            self.fill_gaps(STAGE, OF_THE_REST, &params, conductance, gaps)
        });
        let directions = directions.collect();
        let (further, room) = (patches.further.clone(), patches.params.room);
        self.buffers.recycle(patches.into_buffers().chain([forms]));
        StrokeFields {
            directions,
            further,
            room,
        }
    }

    /// The means of `values` around each patch, up to `reach`, which follows depth if it `is_radius` of strokes and
    /// patches have depth.
    fn chain_means(
        &mut self,
        patches: &Patches,
        values: &wgpu::Buffer,
        reach: f32,
        is_radius: bool,
    ) -> wgpu::Buffer {
        let median = patches.median.filter(|_| is_radius);
        let farthest = reach * if median.is_some() { NEAR } else { 1.0 };
        let is_near = farthest <= RUN_CELLS as f32;
        for (axis, sums) in (0..).zip(&patches.sums).filter(|_| !is_near) {
            let along = DirectionParams {
                axis,
                ..patches.params
            };
            let buffers = SumRunsBuffers {
                held: &patches.held,
                links: &patches.links,
                values,
                sums,
            };
            self.over_runs(&SUM_RUNS, &along, &buffers);
        }
        let means = self.take(16 * patches.count());
        let [runs_across, runs_down] = &patches.runs;
        let [sums_across, sums_down] = &patches.sums;
        self.over_cells(
            (
                &CHAIN_MEANS,
                &[("IS_BY_DEPTH", median.is_some()), ("IS_NEAR", is_near)],
            ),
            &DirectionParams {
                reach,
                median: median.unwrap_or(1.0),
                ..patches.params
            },
            &ChainMeansBuffers {
                held: &patches.held,
                further: &patches.further,
                patches: &patches.all,
                links: &patches.links,
                runs_across,
                runs_down,
                sums_across,
                sums_down,
                depths: &patches.depths,
                values,
                means: &means,
            },
        );
        means
    }

    /// The curvature of every patch, averaged nearby.
    fn patch_forms(&mut self, patches: &Patches, reach: f32) -> wgpu::Buffer {
        let forms = self.take(16 * patches.count());
        self.over_cells(
            (&PATCH_FORMS, &[]),
            &patches.params,
            &PatchFormsBuffers {
                held: &patches.held,
                further: &patches.further,
                patches: &patches.all,
                links: &patches.links,
                forms: &forms,
            },
        );
        let means = self.chain_means(patches, &forms, reach, false);
        self.buffers.recycle([forms]);
        means
    }

    /// The direction of strokes of one family in each patch, as twice an angle.
    fn settled(
        &mut self,
        patches: &Patches,
        params: &DirectionParams,
        field: &FieldParams,
        setting: &FieldSetting,
        forms: &wgpu::Buffer,
    ) -> wgpu::Buffer {
        let mut own = self.take(16 * patches.count());
        self.over_cells(
            (&PATCH_DIRECTIONS, &[]),
            params,
            &PatchDirectionsBuffers {
                held: &patches.held,
                further: &patches.further,
                patches: &patches.all,
                forms,
                directions: &own,
            },
        );
        let reach = field.radius_px * setting.cells;
        let averaged = |run: &mut Self, values: wgpu::Buffer, reach: f32| {
            let means = run.chain_means(patches, &values, reach, true);
            run.buffers.recycle([values]);
            means
        };
        for _ in 0..field.passes {
            own = averaged(self, own, reach);
        }
        let is_calmed = field.passes > 0;
        let around = is_calmed.then(|| {
            let wide = SURROUNDINGS * reach;
            let first = self.chain_means(patches, &own, wide, true);
            (1..SURROUNDING_PASSES).fold(first, |around, _| averaged(self, around, wide))
        });
        let settled = self.take(8 * patches.count());
        self.over_cells(
            (&SETTLE_PATCHES, &[("IS_CALMED", is_calmed)]),
            params,
            &SettlePatchesBuffers {
                held: &patches.held,
                further: &patches.further,
                patches: &patches.all,
                links: &patches.links,
                own: &own,
                around: around.as_ref().unwrap_or(&own),
                settled: &settled,
            },
        );
        self.buffers.recycle(around.into_iter().chain([own]));
        settled
    }

    /// Directions of pixels, interpolated between those of the patches around them; covered pixels in no patch are
    /// gaps.
    fn between_patches(
        &mut self,
        patches: &Patches,
        params: &DirectionParams,
        settled: &wgpu::Buffer,
    ) -> Gaps {
        let counts = self.gap_counts(OF_THE_REST);
        let plane = self.surface.plane_bytes();
        let [x, y, filled, marks, lacking] = [(); 5].map(|()| self.take(plane));
        let covered = self.surface.covered.clone();
        self.over_cells(
            (&BETWEEN_PATCHES, &[]),
            params,
            &BetweenPatchesBuffers {
                covered: &covered,
                held: &patches.held,
                patches: &patches.all,
                links: &patches.links,
                settled,
                direction_x: &x,
                direction_y: &y,
                filled: &filled,
                marks: &marks,
                lacking: &lacking,
                counts: &counts,
            },
        );
        Gaps {
            directions: [x, y],
            filled,
            marks,
            lacking: vec![lacking],
            counts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::cpu;
    use crate::engine::cpu::memory::Memory;
    use crate::engine::gpu::device::{Choice, Device, to_test_on};
    use crate::engine::gpu::runner::{Beside, Runner};
    use crate::engine::inputs::Inputs;
    use crate::frame::{Camera, ColorPlanes, Plane, Projection};
    use crate::line::direction_field::cpu::stroke_fields;
    use crate::line::direction_field::patches::Patches;
    use crate::params::{Fallback, LineParams, ScalingParams, ShapeParams};
    use crate::plan::{Available, ToneFrom};
    use crate::product::Product;
    use crate::report::scenes::Scene;
    use glam::{DAffine3, DVec2};

    fn runner() -> Option<Runner> {
        to_test_on(Device::open(Choice::Any)).map(Runner::new)
    }

    fn plan_of(frame: &Frame, field: FieldParams) -> Plan {
        let line = LineParams {
            field,
            directions: StrokeDirections::Both,
            ..LineParams::default()
        };
        let available = Available {
            color: true,
            ..Available::in_frame(frame)
        };
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        Plan::hatch(available, shape, scaling, ToneFrom::Picture, line).unwrap()
    }

    /// A field as the device finds it.
    struct Found {
        conductance: Plane,
        planes: Vec<Vec<f32>>,
        /// Patches after the first ones of all cells, and the room for them.
        further: [u32; 2],
    }

    fn found(runner: &Runner, plan: &Plan, frame: &Frame) -> Found {
        let line = plan.drawing.as_ref().unwrap();
        let memory = Memory::default();
        let mut run = runner.start(plan, frame, Beside::nothing(&memory));
        let edges = run.edges(plan, frame);
        let fields = run.stroke_fields(
            plan,
            &line.field,
            line.directions,
            frame,
            &edges.conductance,
        );
        let planes = fields.directions.iter().flatten();
        let mut wanted = vec![&fields.further, &edges.conductance];
        wanted.extend(planes);
        let mut read = run.finish(&wanted).unwrap().read;
        let planes = read.split_off(2);
        let [further, conductance] = read.try_into().unwrap();
        let (width, height) = (frame.mask.width(), frame.mask.height());
        Found {
            conductance: Plane::from_samples(width, height, conductance),
            planes,
            further: [further[0].to_bits(), fields.room],
        }
    }

    /// The sine of the angle between the directions of both backends along the same edges: its mean over covered
    /// pixels, and the share of them where it exceeds a hundredth.
    fn apart_from_the_cpu(runner: &Runner, frame: &Frame, field: FieldParams) -> [f64; 2] {
        let plan = plan_of(frame, field);
        let line = plan.drawing.as_ref().unwrap();
        let found = found(runner, &plan, frame);
        assert!(found.further[0] <= found.further[1]);
        let (wanted, memory) = (line.directions, Memory::default());
        let patches = Patches::new(frame, &found.conductance, line.field.cell_px as usize);
        let expected = stroke_fields(&plan, &line.field, wanted, frame, &patches, None, &memory);
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let (mut sum, mut wide, mut count) = (0.0, 0, 0);
        for (found, expected) in found.planes.chunks(2).zip(&expected) {
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let at = |plane: &[f32]| f64::from(plane[y * width + x]);
                let found = DVec2::new(at(&found[0]), at(&found[1]));
                let expected = DVec2::new(expected.x.at(x, y).into(), expected.y.at(x, y).into());
                if !frame.mask.at(x, y) {
                    assert_eq!([found, expected], [DVec2::ZERO; 2], "({x}, {y})");
                    continue;
                }
                assert!((found.length() - 1.0).abs() < 1e-5, "({x}, {y}): {found}");
                let sine = found.perp_dot(expected).abs();
                sum += sine;
                wide += i32::from(sine > 0.01);
                count += 1;
            }
        }
        let count = f64::from(count.max(1));
        [sum / count, f64::from(wide) / count]
    }

    /// A frame with two depths, seen from near.
    fn from_near(mut frame: Frame) -> Frame {
        let (width, height) = (frame.mask.width(), frame.mask.height());
        frame.camera = Some(Camera {
            projection: Projection::Perspective {
                fx: 130.0,
                fy: 110.0,
                cx: 0.4 * width as f64,
                cy: 0.6 * height as f64,
            },
            view_from_world: DAffine3::IDENTITY,
        });
        frame.depth = Some(Plane::from_fn(width, height, |x, y| {
            let step = if x + y > width { 9.0 } else { 3.0 };
            if (x * 31 + y * 17) % 97 == 0 {
                f32::NAN
            } else {
                step
            }
        }));
        frame
    }

    /// Open pixels, each surrounded by closed ones: filtered normals give edges pixel by pixel.
    fn crowded(width: usize, height: usize) -> Frame {
        let mut frame = Scene::waves(width, height).frame;
        frame.normal_length = Some(Plane::from_fn(width, height, |x, y| {
            if (x + y) % 2 == 0 { 1.0 } else { 0.2 }
        }));
        frame
    }

    #[test]
    fn directions_are_those_of_the_cpu() {
        let Some(runner) = runner() else { return };
        let usual = FieldParams::default();
        let scenes = [
            ("waves", Scene::waves(211, 157).frame),
            ("ellipsoid", Scene::ellipsoid(190, 140).frame),
            ("barriers", Scene::barriers(150, 130).frame),
            ("ball", Scene::ball(131, 131).frame),
            ("from near", from_near(Scene::waves(230, 170).frame)),
        ];
        let fields = [
            ("usual", usual),
            (
                "fallback",
                FieldParams {
                    fallback: Fallback::Surface,
                    ..usual
                },
            ),
            (
                "wide",
                FieldParams {
                    radius_px: 64.0,
                    passes: 1,
                    ..usual
                },
            ),
            ("as found", FieldParams { passes: 0, ..usual }),
            (
                "pixels",
                FieldParams {
                    cell_px: 1,
                    passes: 6,
                    ..usual
                },
            ),
            (
                "small cells",
                FieldParams {
                    cell_px: 3,
                    radius_px: 1.0,
                    ..usual
                },
            ),
            (
                "large cells",
                FieldParams {
                    cell_px: 8,
                    ..usual
                },
            ),
        ];
        for (scene, frame) in &scenes {
            for (name, field) in fields {
                let [mean, wide] = apart_from_the_cpu(&runner, frame, field);
                println!("{scene}, {name}: {mean:.1e}, {wide:.1e}");
                assert!(
                    mean < 1e-5 && wide < 1e-4,
                    "{scene}, {name}: {mean:e}, {wide:e}"
                );
            }
        }
    }

    #[test]
    fn what_falls_apart_into_more_patches_than_there_is_room_for_is_drawn_all_the_same() {
        let Some(runner) = runner() else { return };
        let mut frame = crowded(90, 70);
        let grey = Plane::filled(90, 70, 0.3);
        frame.color = Some(ColorPlanes {
            r: grey.clone(),
            g: grey.clone(),
            b: grey,
        });
        let plan = plan_of(&frame, FieldParams::default());
        let [further, room] = found(&runner, &plan, &frame).further;
        assert!(further > room, "{further} of {room}");
        let inputs = Inputs::default();
        let found = runner.execute(&plan, &frame, inputs).unwrap();
        let expected = cpu::Runner::default()
            .execute(&plan, &frame, inputs)
            .unwrap();
        let [found, expected] = [&found, &expected].map(|outcome| outcome.planes(Product::Strokes));
        assert_eq!(found.len(), 1);
        assert!(Product::Strokes.difference(&found, &expected) <= Product::Strokes.tolerance());
    }
}
