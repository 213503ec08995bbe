//! The runner of the CPU: plans run one at a time, in recycled memory.

use crate::engine::inputs::PlanInputs;
use crate::engine::part::FramePart;
use crate::error::Result;
use crate::frame::memory::Memory;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes, Vector3Planes, Window};
use crate::light::prepared_environment::EnvironmentCache;
use crate::line::direction_field::cpu as direction_field;
use crate::line::direction_field::patches::Patches;
use crate::line::specular;
use crate::line::specular::map_directions::DirectionCache;
use crate::params::LineParams;
use crate::plan::Plan;
use crate::plan::execution::{Execution, Interim, RunInputs, Runner};
use crate::plan::frame_cache::FrameCache;
use crate::plan::outcome::{Outcome, Shape};
use crate::plan::stage::{Makes, Stage};
use crate::plan::watch::Watch;
use crate::product::Product;
use crate::shape::edges::cpu as edges;

/// A frame as a run has it.
pub(crate) enum RunFrame<'f> {
    /// Others read it too, and all that is made of it stays.
    Shared(&'f Frame),
    /// The run alone reads it. Of a picture or a drawing the outcome lacks the shape, whose products are recycled after their
    /// last reader, and the frame what no later stage reads.
    Own(&'f mut Frame),
}

impl RunFrame<'_> {
    pub(crate) fn get(&self) -> &Frame {
        match self {
            Self::Shared(frame) => frame,
            Self::Own(frame) => frame,
        }
    }

    /// The frame as it is, lent to a run within this one.
    pub(crate) fn again(&mut self) -> RunFrame<'_> {
        match self {
            Self::Shared(frame) => RunFrame::Shared(frame),
            Self::Own(frame) => RunFrame::Own(frame),
        }
    }
}

/// What stages of a plan are run with, but for their frame.
pub(crate) struct Passage<'a> {
    pub(crate) runner: &'a Runner,
    pub(crate) plan: &'a Plan,
    pub(crate) inputs: RunInputs<'a>,
    pub(crate) memory: Memory,
    pub(crate) watch: Watch<'a>,
    /// The cache of the frame.
    pub(crate) kept: Option<&'a mut FrameCache>,
    /// The frame that this one is a part of, if it is.
    pub(crate) whole: Option<&'a Frame>,
    /// What earlier stages made.
    pub(crate) made: Interim,
}

impl<'a> Passage<'a> {
    pub(crate) fn new(
        runner: &'a Runner,
        plan: &'a Plan,
        inputs: RunInputs<'a>,
        watch: Watch<'a>,
    ) -> Self {
        Self {
            runner,
            plan,
            inputs,
            memory: runner.memory.for_run(watch.token()),
            watch,
            kept: None,
            whole: None,
            made: Interim::default(),
        }
    }

    /// Runs stages one after another, in the caller's rayon pool.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), checked before and after each of them: the output of a cancelled
    /// stage is undefined.
    pub(crate) fn go(mut self, mut frame: RunFrame, stages: &[&'static Stage]) -> Result<Interim> {
        for i in 0..stages.len() {
            self.watch.check()?;
            let (normals, lengths, read_last) = match &mut frame {
                RunFrame::Own(frame) => self.free(frame, stages, i),
                RunFrame::Shared(_) => Default::default(),
            };
            let new = Execution::new(self.runner, self.plan, frame.get(), self.inputs);
            let mut run = Execution {
                memory: &self.memory,
                watch: self.watch,
                kept: self.kept.as_deref_mut(),
                whole: self.whole,
                normals,
                lengths,
                read_last,
                made: self.made,
                ..new
            };
            (stages[i].cpu)(&mut run);
            self.made = run.made;
        }
        self.watch.check()?;
        if let RunFrame::Own(_) = frame {
            self.memory
                .recycle(self.made.outcome.shape.take_others(&[]));
        }
        Ok(self.made)
    }

    /// Recycles what neither stage `i` nor a later one reads. The normals and lengths that this one reads last, and products
    /// of the shape.
    fn free(
        &mut self,
        frame: &mut Frame,
        stages: &[&'static Stage],
        i: usize,
    ) -> (Option<Vector3Planes>, Option<Plane>, Vec<Product>) {
        let (plan, memory) = (self.plan, &self.memory);
        let (stage, now, later) = (stages[i], &stages[i..], &stages[i + 1..]);
        let lines = plan.drawing.as_ref().and_then(|drawn| drawn.interior);
        let finds_shadows = lines.is_some_and(|lines| lines.has_shadows());
        if plan.relighting().is_none() && !finds_shadows {
            let albedo = frame.albedo.take().into_iter();
            memory.recycle(albedo.flat_map(|ColorPlanes { r, g, b }| [r, g, b]));
        }
        // A drawing takes its tone from the picture that was made, and most of its planes have other sizes.
        let draws = |stage: &Stage| stage.makes == Makes::Drawing;
        let begins_to_draw = draws(stage) && !stages[..i].last().is_some_and(|last| draws(last));
        if begins_to_draw && self.made.outcome.color.is_some() && !finds_shadows {
            (frame.color, frame.albedo) = (None, None);
            memory.release();
        }
        let of_shape = &mut self.made.outcome.shape;
        memory.recycle(of_shape.take_others(&taken_by(now, plan)));
        let read_later = taken_by(later, plan);
        let mut products = (stage.takes)(plan);
        products.retain(|product| !read_later.contains(product));
        // Lengths of normals are read once, unless rays meet the surface later.
        let is_last = stage.reads_lengths && plan.specular.is_none();
        let lengths = frame.normal_length.take_if(|_| is_last);
        let normals = take_unread(plan, frame, stage, later, memory);
        (normals, lengths, products)
    }
}

impl Runner {
    /// Runs `plan` on `frame`, in the caller's rayon pool.
    ///
    /// # Errors
    /// [`Error::Unfit`](crate::Error::Unfit) if the plan was made for other inputs.
    #[cfg(any(test, feature = "cli"))]
    pub(crate) fn execute(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: PlanInputs,
    ) -> Result<Outcome> {
        self.execute_watched(
            plan,
            RunFrame::Shared(frame),
            inputs,
            Watch::default(),
            None,
        )
    }

    /// [`Runner::execute`] with observers and the cache of the frame; the same bits, whoever has the frame.
    ///
    /// # Errors
    /// As [`Runner::execute`]; [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn execute_watched(
        &self,
        plan: &Plan,
        frame: RunFrame,
        inputs: PlanInputs,
        watch: Watch,
        kept: Option<&mut FrameCache>,
    ) -> Result<Outcome> {
        inputs.check(plan, frame.get())?;
        let frame = match frame {
            RunFrame::Own(frame) if plan.makes_shape_alone() => RunFrame::Shared(frame),
            RunFrame::Own(frame) => match changed_part(plan, frame) {
                Some(changed) => return self.execute_on_part(plan, frame, changed, inputs, watch),
                None => RunFrame::Own(frame),
            },
            shared => shared,
        };
        let passage = Passage {
            kept,
            ..Passage::new(self, plan, inputs.given(), watch)
        };
        Ok(passage.go(frame, &plan.stages)?.outcome)
    }

    /// The picture, made where `changed` and copied elsewhere, and what was chosen for it; no picture if nothing changes.
    fn execute_on_part(
        &self,
        plan: &Plan,
        whole: &Frame,
        changed: Window,
        inputs: PlanInputs,
        watch: Watch,
    ) -> Result<Outcome> {
        if changed.width() == 0 {
            let relit = plan.relighting();
            return Ok(Outcome {
                color: whole.color.clone().filter(|_| relit.is_some()),
                takes_picture: relit.is_some_and(|relit| relit.takes_picture()),
                ..Outcome::default()
            });
        }
        let part = FramePart::around(changed, plan, whole, inputs)?;
        let passage = Passage::new(self, plan, part.inputs(inputs).given(), watch);
        let passage = Passage {
            memory: passage.memory.at_other_size(),
            whole: Some(whole),
            ..passage
        };
        let made = passage.go(RunFrame::Shared(&part.frame), &plan.stages)?;
        let mut outcome = Outcome {
            shape: Shape::default(),
            ..made.outcome
        };
        let [at, of_whole] = [part.frame.data_window, whole.data_window];
        outcome.color = outcome
            .color
            .zip(whole.color.clone())
            .map(|(made, mut all)| {
                let planes = [
                    (&made.r, &mut all.r),
                    (&made.g, &mut all.g),
                    (&made.b, &mut all.b),
                ];
                for (made, all) in planes {
                    all.paste(of_whole, changed, made, at);
                }
                all
            });
        Ok(outcome)
    }

    /// Directions that strokes with `params` follow: see
    /// [`Engine::stroke_fields`](crate::engine::Engine::stroke_fields).
    ///
    /// # Panics
    /// If the plan leaves out conductance.
    pub(crate) fn stroke_fields(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: PlanInputs,
        params: &LineParams,
    ) -> Vec<Vector2Planes> {
        assert!(plan.wants(Product::Conductance), "strokes stop at edges");
        let (kept, memory) = (&self.caches.of::<DirectionCache>(), &self.memory);
        let through = inputs.specular.zip(plan.specular);
        let seen = through.and_then(|(scene, specular)| {
            specular::seen_through(plan, frame, scene, &specular, params, kept, memory)
        });
        let drawn = seen.as_ref().map_or(frame, |seen| &seen.frame);
        let given = seen.as_ref().map(|seen| &seen.directions[..]);
        let (edges, _) = edges::edges_and_gradient(plan, drawn, memory);
        let cell_px = params.field.cell_px as usize;
        let patches = Patches::new(drawn, &edges.conductance, cell_px);
        direction_field::stroke_fields(
            plan,
            &params.field,
            params.directions,
            drawn,
            &patches,
            (given, None, None),
            memory,
        )
    }

    /// Drops the prepared environment, so that benchmarks measure its preparation again.
    pub(crate) fn forget_environment(&self) {
        self.caches.of::<EnvironmentCache>().forget();
    }

    /// Reclaims the memory of an outcome.
    pub(crate) fn recycle(&self, outcome: Outcome) {
        self.memory.recycle(outcome.into_planes());
    }
}

/// The part of the frame that a plan changes, where it and its margin are no more than half of it: all other pixels are
/// those of the picture. `None` for plans that make more, and for new light that reaches all of a frame.
fn changed_part(plan: &Plan, frame: &Frame) -> Option<Window> {
    let is_relit = plan.relighting().is_some() && plan.specular.is_none();
    let is_masked = is_relit && frame.color.is_some() && frame.strength.is_some();
    if (plan.enhancement().is_none() && !is_masked) || plan.drawing.is_some() {
        return None;
    }
    let (whole, pixels) = (frame.data_window, |w: Window| w.width() * w.height());
    let changed = (0..frame.mask.height()).filter_map(|y| {
        // Rims take light beside the surface.
        let mut span = match is_masked {
            true => 0..frame.mask.width(),
            false => frame.mask.span(y),
        };
        if let Some(strength) = &frame.strength {
            let shares = &strength.row(y)[span.clone()];
            let first = shares.iter().position(|&share| share > 0.0)?;
            let last = shares.iter().rposition(|&share| share > 0.0)?;
            span = span.start + first..span.start + last + 1;
        }
        let [x, y] = [whole.x0 + span.start as i32, whole.y0 + y as i32];
        (!span.is_empty()).then(|| Window::at(x, y, span.len(), 1))
    });
    match changed.reduce(|a, b| a.joined(&b)) {
        None => Some(Window::at(whole.x0, whole.y0, 0, 0)),
        Some(part) => {
            let around = part.grown(plan.reach()).common(&whole)?;
            (2 * pixels(around) <= pixels(whole)).then_some(part)
        }
    }
}

/// The products of other stages that any of these takes.
pub(crate) fn taken_by(stages: &[&Stage], plan: &Plan) -> Vec<Product> {
    let stages = stages.iter();
    stages.flat_map(|stage| (stage.takes)(plan)).collect()
}

/// Recycles what neither `stage` nor a later one reads of a frame. Its normals are handed on where `stage` makes its results
/// in their memory, and no later one reads them.
fn take_unread(
    plan: &Plan,
    frame: &mut Frame,
    stage: &Stage,
    later: &[&Stage],
    memory: &Memory,
) -> Option<Vector3Planes> {
    let now = || later.iter().copied().chain([stage]);
    let reads_depth = |stage: &Stage| stage.reads_normals && (stage.reads_depth)(plan);
    if !now().any(reads_depth) {
        memory.recycle(frame.depth.take());
    }
    let is_left = later.iter().any(|stage| stage.reads_normals);
    let takes = !stage.reads_normals || (stage.takes_normals)(plan);
    if is_left || !takes || frame.normal.x.samples().is_empty() {
        return None;
    }
    let none = Vector3Planes::of(vec![Plane::default()]);
    let normals = std::mem::replace(&mut frame.normal, none);
    if stage.reads_normals {
        return Some(normals);
    }
    memory.recycle([normals.x, normals.y, normals.z]);
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Mask;
    use crate::frame::rows::map_covered;
    use crate::kernel::cancel::CancelToken;
    use crate::light::lights::{DirectionalLight, Illumination};
    use crate::params::{
        Adaptive, AlbedoSource, Method, RelightParams, RunOptions, ScalingParams, ShapeParams,
    };
    use crate::plan::{Available, Goal, Tone};
    use crate::shape::diffusion::cpu::diffusion;
    use crate::shape::diffusion::medium::Medium;
    use crate::shape::diffusion::sweeps::DiffusionSchedule;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Bumps of 20 pixels with a hole, under varying light.
    fn bumps() -> Frame {
        let (width, height) = (90, 150);
        let wave = |x: usize| x as f64 * std::f64::consts::TAU / 20.0;
        let normal = Vector3Planes::from_fn(width, height, |x, y| {
            let (x, y) = (wave(x), wave(y));
            glam::DVec3::new(0.5 * x.sin() * y.cos(), -0.5 * x.cos() * y.sin(), 1.0).normalize()
        });
        let covered = Plane::from_fn(width, height, |x, y| x.abs_diff(30) + y.abs_diff(70) > 9);
        let channel = |hue: f32| {
            Plane::from_fn(width, height, |x, y| {
                hue * (0.5 + 0.4 * ((x + 2 * y) as f32 / 9.0).sin())
            })
        };
        Frame {
            color: Some(ColorPlanes {
                r: channel(0.9),
                g: channel(0.7),
                b: channel(0.5),
            }),
            depth: Some(Plane::filled(width, height, 3.0)),
            normal_length: Some(Plane::filled(width, height, 1.0)),
            ..Frame::of_normals(normal, Mask::new(covered))
        }
    }

    /// Runs a plan on a frame that nobody else reads.
    fn alone(
        runner: &Runner,
        plan: &Plan,
        frame: &mut Frame,
        inputs: PlanInputs,
    ) -> Result<Outcome> {
        runner.execute_watched(plan, RunFrame::Own(frame), inputs, Watch::default(), None)
    }

    /// Runs a plan both ways; the frame that is left, and the outcome.
    fn assert_sparing(plan: &Plan, inputs: PlanInputs) -> (Frame, Outcome) {
        let (runner, mut frame) = (Runner::default(), bumps());
        let whole = runner.execute(plan, &frame, inputs).unwrap();
        let made = alone(&runner, plan, &mut frame, inputs);
        let made = made.unwrap();
        let chosen = |o: &Outcome| (o.gain, o.white_level, o.tone_levels, o.line_levels);
        assert_eq!(chosen(&made), chosen(&whole));
        let drawn = [Product::Strokes, Product::Contours, Product::Interior];
        let picture = Some(Product::Picture).filter(|_| plan.drawing.is_none());
        for product in picture.into_iter().chain(drawn) {
            assert_eq!(made.planes(product), whole.planes(product), "{product:?}");
        }
        assert!(made.shape.gradient.is_none() && whole.shape.gradient.is_some());
        assert!(made.shape.conductance.is_none() && frame.normal_length.is_none());
        (frame, made)
    }

    #[test]
    fn an_enhanced_picture_leaves_no_shape_behind() {
        let (available, shape) = (Available::in_frame(&bumps()), ShapeParams::default());
        let plan = Plan::new(Goal::Enhance, available, shape, ScalingParams::default());
        let (frame, made) = assert_sparing(&plan.unwrap(), PlanInputs::default());
        assert_ne!(made.color, frame.color);
        assert!(frame.normal.z.samples().is_empty() && frame.depth.is_none());
    }

    /// Where new light has strength, it is that of the whole frame, bit for bit: its albedo is estimated from all of it.
    #[test]
    fn masked_light_is_made_where_it_shows() {
        let light = Illumination {
            directional: vec![DirectionalLight::white([135.0, 40.0])],
            ..Illumination::default()
        };
        let mut frame = bumps();
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let is_in = |x: usize, y: usize| (4..24).contains(&x) && (8..30).contains(&y);
        let strength = |x, y| 0.5 * f32::from(is_in(x, y));
        frame.strength = Some(Plane::from_fn(width, height, strength));
        let params = RelightParams {
            albedo: AlbedoSource::Estimate,
            method: Method::Both,
            ..RelightParams::default()
        };
        let plan = Plan::new(
            Goal::Relight(params),
            Available::in_frame(&frame).lit_by(&light),
            ShapeParams::default(),
            ScalingParams::default(),
        );
        let (plan, runner) = (plan.unwrap(), Runner::default());
        let inputs = PlanInputs::lit_by(&light);
        let whole = runner.execute(&plan, &frame, inputs).unwrap();
        assert!(changed_part(&plan, &frame).is_some());
        let own = frame.color.clone().unwrap().r;
        let made = alone(&runner, &plan, &mut frame, inputs);
        let made = made.unwrap();
        assert_eq!(
            (made.gain, made.takes_picture),
            (whole.gain, whole.takes_picture)
        );
        let [made, whole] = [made, whole].map(|outcome| outcome.color.unwrap().r);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let expected = if is_in(x, y) { &whole } else { &own };
            assert_eq!(made.at(x, y), expected.at(x, y), "{x}, {y}");
        }
        assert_ne!(made.at(10, 10), own.at(10, 10));
        frame.strength = Some(Plane::filled(width, height, 0.0));
        let idle = alone(&runner, &plan, &mut frame, inputs);
        assert_eq!(idle.unwrap().color.unwrap().r, own);
    }

    /// Where the effect has strength the picture and all that is chosen are those of the whole frame, bit for bit; the rest
    /// is the frame's own.
    #[test]
    fn a_masked_picture_is_made_where_it_changes() {
        let (available, shape) = (Available::in_frame(&bumps()), ShapeParams::default());
        let plan = Plan::new(Goal::Enhance, available, shape, ScalingParams::default()).unwrap();
        let runner = Runner::default();
        let mut frame = bumps();
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let is_in = |x: usize, y: usize| (4..24).contains(&x) && (8..30).contains(&y);
        let strength = |x, y| 0.5 * f32::from(is_in(x, y));
        frame.strength = Some(Plane::from_fn(width, height, strength));
        let whole = runner
            .execute(&plan, &frame, PlanInputs::default())
            .unwrap();
        assert!(changed_part(&plan, &frame).is_some());
        let part = |frame: &mut Frame| {
            let run = alone(&runner, &plan, frame, PlanInputs::default());
            run.unwrap()
        };
        let made = part(&mut frame);
        let chosen = |o: &Outcome| (o.gain, o.white_level);
        assert_eq!(chosen(&made), chosen(&whole));
        let [made, whole] = [made, whole].map(|outcome| outcome.color.unwrap().r);
        let own = &frame.color.as_ref().unwrap().r;
        let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let (inside, outside): (Vec<_>, Vec<_>) = pixels().partition(|&(x, y)| is_in(x, y));
        assert!(inside.iter().all(|&(x, y)| made.at(x, y) == whole.at(x, y)));
        assert!(inside.iter().any(|&(x, y)| made.at(x, y) != own.at(x, y)));
        assert!(outside.iter().all(|&(x, y)| made.at(x, y) == own.at(x, y)));
        // Nothing is made of an effect without strength, nor without a surface.
        let mut idle = bumps();
        idle.strength = Some(Plane::filled(width, height, 0.0));
        assert!(part(&mut idle).color.is_none());
        let mut empty = bumps();
        empty.mask = Mask::new(Plane::filled(width, height, false));
        assert!(part(&mut empty).color.is_none());
    }

    #[test]
    fn a_relit_picture_leaves_no_shape_behind() {
        let light = Illumination {
            directional: vec![DirectionalLight::white([135.0, 40.0])],
            ..Illumination::default()
        };
        let available = Available::in_frame(&bumps()).lit_by(&light);
        for method in [Method::Scale, Method::Warp, Method::Both] {
            for curvature_gain in [Adaptive::Auto, Adaptive::Fixed(2.0)] {
                let scaling = ScalingParams {
                    curvature_gain,
                    ..ScalingParams::default()
                };
                let params = RelightParams {
                    method,
                    ..RelightParams::default()
                };
                let shape = ShapeParams::default();
                let goal = Goal::Relight(params);
                let plan = Plan::new(goal, available, shape, scaling).unwrap();
                let (frame, _) = assert_sparing(&plan, PlanInputs::lit_by(&light));
                assert!(frame.normal.z.samples().is_empty() && frame.depth.is_none());
            }
        }
    }

    #[test]
    fn a_drawing_leaves_no_shape_behind() {
        let (available, shape) = (Available::in_frame(&bumps()), ShapeParams::default());
        for tone in [Tone::Enhanced, Tone::Shape(None)] {
            let (scaling, params) = (ScalingParams::default(), LineParams::default());
            let plan = Plan::new(Goal::Hatch(tone, params), available, shape, scaling).unwrap();
            let (_, made) = assert_sparing(&plan, PlanInputs::default());
            let hatching = made.drawing.unwrap().hatching;
            assert!(hatching.samples().iter().any(|&ink| ink > 0.5));
        }
    }

    /// One thread writes 40 of 90 rows before row 39 cancels the run: the remaining rows are not written.
    #[test]
    fn rows_end_where_a_run_is_cancelled() {
        let token = CancelToken::new();
        let memory = Memory::default().for_run(Some(&token));
        let mask = Mask::new(Plane::filled(30, 90, true));
        let made = AtomicUsize::new(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let [plane] = pool.unwrap().install(|| {
            map_covered(&mask, &memory, |_| {
                if made.fetch_add(1, Ordering::Relaxed) == 39 {
                    token.cancel();
                }
                |_| [1.0]
            })
        });
        assert_eq!(made.into_inner(), 40);
        assert_eq!(plane.samples().iter().sum::<f32>(), 40.0 * 30.0);
    }

    /// Diffusion without edges keeps the sum of a field of stripes; a cancelled one returns nothing.
    #[test]
    fn a_diffusion_ends_where_its_run_is_cancelled() {
        let (ones, mask) = (Plane::filled(50, 40, 1.0), Mask::full(50, 40));
        let stripes = Plane::from_fn(50, 40, |x, _| (x % 2) as f32);
        let sweeps = DiffusionSchedule::to_sigmas(&[4.0], 1e-3);
        let sum = |token: &CancelToken| {
            let field = Vector2Planes {
                x: stripes.clone(),
                y: stripes.clone(),
            };
            let memory = Memory::default().for_run(Some(token));
            let options = RunOptions::default();
            let medium = Medium::of_whole(&ones, &mask);
            let spread = diffusion(field, medium, &sweeps, &options, &memory).scales;
            spread[0].x.samples().iter().sum::<f32>()
        };
        let token = CancelToken::new();
        assert!((sum(&token) - 1000.0).abs() < 1.0);
        token.cancel();
        assert_eq!(sum(&token), 0.0);
    }
}
