//! Runs whose shape nobody looks at. A picture takes the memory of slopes and edges. Shape and tone of large drawings
//! are computed in bands, and only what strokes need is kept.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::run::{Run, Runner};
use crate::engine::cpu::runner::taken_by;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::{Outcome, Shape};
use crate::engine::tiles::{Strips, rows_of};
use crate::engine::watch::Watch;
use crate::error::Result;
use crate::frame::halves::StowedColors;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes, Vector3Planes, luminance};
use crate::light::enhancement::Subject;
use crate::light::radiance_scaling::cpu as light;
use crate::light::radiance_scaling::stage::scaler;
use crate::light::white_level::choose_picture_white;
use crate::line::canvas::Canvas;
use crate::params::Adaptive;
use crate::plan::Plan;
use crate::plan::stages::{DRAWING, PICTURE, SHAPE};
use crate::product::Product;
use crate::shape::auto_levels::stage::choose_gain;

/// Number of pixels above which memory counts more than what the frame still holds.
const LARGE: usize = 1 << 22;

/// Output rows of a band: many compared with the margin above and below, some 14 at the default scale.
const BAND_ROWS: usize = 256;

/// A run whose first stage is done.
pub(crate) struct Begun {
    pub(crate) outcome: Outcome,
    pub(crate) undiffused: Option<Vector2Planes>,
}

impl Runner {
    /// [`Runner::execute_watched`], bit for bit. A picture leaves out edges and slopes, and consumes normals, depth and
    /// albedo of a large frame. The outcome of a drawing is that and the automatic choices, without the shape; a large
    /// frame drawn in its own light takes half the memory: its picture is consumed.
    ///
    /// # Errors
    /// As [`Runner::execute_watched`].
    pub(crate) fn execute_sparingly(
        &self,
        plan: &Plan,
        frame: &mut Frame,
        inputs: Inputs,
        watch: Watch,
    ) -> Result<Outcome> {
        if makes_picture_alone(plan) {
            return self.make_picture(plan, frame, inputs, watch, LARGE);
        }
        if plan.drawing.is_none() {
            return self.execute_watched(plan, frame, inputs, watch, None);
        }
        inputs.check(plan, frame)?;
        if is_larger(frame, LARGE) && goes_in_bands(plan) {
            return self.draw_in_bands(plan, frame, inputs, watch, BAND_ROWS);
        }
        let memory = &self.memory.for_run(watch.token());
        let mut run = Run {
            memory,
            watch,
            ..Run::new(self, plan, frame, inputs)
        };
        run.go_through(SHAPE.into_iter().chain(PICTURE))?;
        run.draw()
    }

    /// The picture; without edges and slopes, once no curvature is computed from them. Normals and depth of a large frame
    /// make room for what is made of them, once no other stage reads them; to be relit it takes half floats for pictures
    /// that nothing reads meanwhile, if these hold them.
    fn make_picture(
        &self,
        plan: &Plan,
        frame: &mut Frame,
        inputs: Inputs,
        watch: Watch,
        large: usize,
    ) -> Result<Outcome> {
        inputs.check(plan, frame)?;
        let memory = &self.memory.for_run(watch.token());
        let is_large = is_larger(frame, large);
        // Nothing but relighting makes a picture there.
        let relights = plan
            .relighting
            .as_ref()
            .filter(|lit| is_large && !lit.traced);
        // Until the shape is found nothing reads pictures, and relighting may read the albedo alone. Slopes take the planes
        // of the picture.
        let albedo = relights.and_then(|_| stow(&mut frame.albedo, drop));
        let color = relights.filter(|lit| !lit.albedo.is_of_picture());
        let color = color.and_then(|_| stow(&mut frame.color, |plane| memory.recycle([plane])));
        let later = SHAPE[1..].iter().chain(&PICTURE);
        let readers = later.filter(|stage| plan.has(stage) && stage.reads_normals);
        let readers: Vec<_> = readers.collect();
        let are_read_last = is_large && readers.is_empty() && plan.has(SHAPE[0]);
        let normals = are_read_last.then(|| take_normals(frame));
        let Begun {
            outcome,
            undiffused,
        } = self.after_edges(plan, frame, normals, inputs, watch)?;
        if is_large && !readers.iter().any(|stage| (stage.reads_depth)(plan)) {
            memory.recycle(frame.depth.take());
        }
        let mut run = Run {
            memory,
            watch,
            outcome,
            undiffused,
            ..Run::new(self, plan, frame, inputs)
        };
        run.go_through(SHAPE[1..].iter().copied())?;
        let shape = &mut run.outcome.shape;
        let is_made = shape.trace.is_some() && !plan.wants(Product::Hessian);
        if plan.relighting.is_none() || is_made {
            let edges = [
                shape.silhouette.take(),
                shape.crease.take(),
                shape.conductance.take(),
            ];
            let slopes = shape.gradient.take();
            let slopes = slopes.into_iter().flat_map(|slopes| [slopes.x, slopes.y]);
            memory.recycle(edges.into_iter().flatten().chain(slopes));
        } else {
            // The gain alone took it.
            memory.recycle(shape.trace.take());
        }
        let outcome = run.outcome;
        let normals = relights.map(|_| take_normals(frame));
        if let Some(albedo) = albedo {
            frame.albedo = Some(taken_out(albedo, frame, memory));
        }
        let mut run = Run {
            memory,
            watch,
            outcome,
            normals,
            stowed: color.as_ref(),
            ..Run::new(self, plan, frame, inputs)
        };
        run.go_through(PICTURE)?;
        let outcome = run.outcome;
        if let Some(color) = color {
            if let Some(ColorPlanes { r, g, b }) = frame.albedo.take() {
                memory.recycle([r, g, b]);
            }
            frame.color = Some(taken_out(color, frame, memory));
        }
        Ok(outcome)
    }

    /// Runs the first stage of shape, the only one that reads the lengths of the normals. Large frames lose them, unless
    /// rays meet the surface later. With `normals`, which the frame no longer has, it runs in their memory.
    pub(crate) fn after_edges(
        &self,
        plan: &Plan,
        frame: &mut Frame,
        normals: Option<Vector3Planes>,
        inputs: Inputs,
        watch: Watch,
    ) -> Result<Begun> {
        let memory = &self.memory.for_run(watch.token());
        let traces = plan.relighting.as_ref().is_some_and(|lit| lit.traced);
        let is_used_up = normals.is_some() || (is_larger(frame, LARGE) && !traces);
        let lengths = frame.normal_length.take_if(|_| is_used_up);
        let mut run = Run {
            memory,
            watch,
            normals,
            lengths,
            ..Run::new(self, plan, frame, inputs)
        };
        run.go_through([SHAPE[0]])?;
        Ok(Begun {
            outcome: run.outcome,
            undiffused: run.undiffused,
        })
    }

    fn draw_in_bands(
        &self,
        plan: &Plan,
        frame: &mut Frame,
        inputs: Inputs,
        watch: Watch,
        rows: usize,
    ) -> Result<Outcome> {
        // No light is new, and bands are cut of what shape takes alone.
        frame.albedo = None;
        let (color, alpha) = (frame.color.take(), frame.alpha.take());
        let made = self.shape_in_bands(plan, frame, watch, rows);
        (frame.color, frame.alpha) = (color, alpha);
        let mut run = Run {
            watch,
            outcome: made?,
            ..Run::new(self, plan, frame, Inputs::default())
        };
        choose_gain(&mut run);
        choose_picture_white(&mut run);
        let trace = run.outcome.shape.trace.take();
        let trace = trace.expect("the tone takes the trace");
        let (scaler, mut outcome) = (scaler(&run), run.outcome);
        let luminance = luminance_in_bands(&scaler, frame, &trace, rows, self);
        outcome.shape.trace = Some(trace).filter(|_| plan.shows_shape);
        frame.normal_length = None;
        watch.check()?;
        let memory = &self.memory.for_run(watch.token());
        let run = Run {
            memory,
            watch,
            outcome,
            canvas: Canvas {
                luminance: Some(luminance),
                ..Canvas::default()
            },
            ..Run::new(self, plan, frame, inputs)
        };
        run.draw()
    }

    /// Edges and the trace of a frame, band by band.
    fn shape_in_bands(
        &self,
        plan: &Plan,
        frame: &Frame,
        watch: Watch,
        rows: usize,
    ) -> Result<Outcome> {
        // The gain is chosen from the whole frame.
        let mut given = plan.clone();
        given.scaling.curvature_gain = Adaptive::Fixed(1.0);
        let strips = Strips::of_rows(rows, frame.mask.height(), plan.reach());
        let drawn = DRAWING.into_iter().filter(|stage| plan.has(stage));
        let mut kept = taken_by(drawn, plan);
        // For the gain, and for the light that is scaled.
        kept.extend([Product::Trace, Product::Conductance]);
        let find = |band: &Frame| {
            let mut made = self.find_shape(&given, band, watch)?;
            self.memory.recycle(made.shape.take_others(&kept));
            Ok(made)
        };
        let made = strips.run(frame, find, |planes| self.memory.recycle(planes))?;
        Ok(Outcome { gain: None, ..made })
    }
}

impl Run<'_> {
    /// The drawing of a shape, and the automatic choices, without the shape.
    fn draw(mut self) -> Result<Outcome> {
        self.go_through_once(DRAWING)?;
        Ok(Outcome {
            shape: Shape::default(),
            ..self.outcome
        })
    }
}

/// The normals of a frame, which is left with none.
fn take_normals(frame: &mut Frame) -> Vector3Planes {
    let none = Vector3Planes::of(vec![Plane::default()]);
    std::mem::replace(&mut frame.normal, none)
}

/// Puts a picture away that nothing reads for now; `reuse` gets its memory.
fn stow(picture: &mut Option<ColorPlanes>, reuse: impl Fn(Plane)) -> Option<StowedColors> {
    picture
        .take()
        .map(|picture| StowedColors::new(picture, reuse))
}

/// A picture of a frame that was put away.
fn taken_out(stowed: StowedColors, frame: &Frame, memory: &Memory) -> ColorPlanes {
    stowed.taken_out(|| memory.unwritten(&frame.mask))
}

/// Whether a frame has more than so many pixels.
fn is_larger(frame: &Frame, pixels: usize) -> bool {
    frame.mask.width() * frame.mask.height() > pixels
}

/// Whether a plan enhances a picture or relights the surface, and does nothing else.
fn makes_picture_alone(plan: &Plan) -> bool {
    let makes_one = plan.enhancement.is_some() || plan.relighting.is_some();
    makes_one && plan.drawing.is_none() && !plan.display
}

/// Whether a drawing needs nothing of the shape but edges, and nothing of the light but the picture's radiance.
fn goes_in_bands(plan: &Plan) -> bool {
    let scales_picture = plan.enhancement.is_some_and(|enhancement| {
        enhancement.subject == Subject::Picture
            && enhancement.magnitude > 0.0
            && enhancement.occlusion == 0.0
    });
    // Edges of cast shadows are found in the picture.
    let interior = plan.drawing.as_ref().and_then(|drawn| drawn.interior);
    scales_picture
        && interior.is_none_or(|lines| !lines.has_shadows())
        && plan.specular.is_none()
        && !plan.available.light.picture_is_occlusion
}

/// The luminance of the frame's scaled picture; consumes the picture.
fn luminance_in_bands(
    scaler: &light::Scaler,
    frame: &mut Frame,
    trace: &Plane,
    rows: usize,
    runner: &Runner,
) -> Plane {
    let (whole, mask) = (frame.data_window, &frame.mask);
    let color = frame.color.take().expect("the tone takes the picture");
    let ColorPlanes { mut r, g, b } = color;
    for (band, _) in Strips::of_rows(rows, whole.height(), 0).each() {
        let part = rows_of(whole, &band);
        let [old_r, old_g, old_b] = [&r, &g, &b].map(|plane| plane.crop(whole, part));
        let old = ColorPlanes {
            r: old_r,
            g: old_g,
            b: old_b,
        };
        let mask = mask.crop(whole, part);
        let trace = trace.crop(whole, part);
        let scaled = scaler.scale(&old, &trace, &mask, &runner.memory);
        let samples = band.start * whole.width()..band.end * whole.width();
        let colors = scaled.r.samples().iter().zip(scaled.g.samples());
        let colors = colors.zip(scaled.b.samples());
        for (to, ((&r, &g), &b)) in r.samples_mut()[samples].iter_mut().zip(colors) {
            *to = luminance([r, g, b], scaler.weights);
        }
        runner.memory.recycle([scaled.r, scaled.g, scaled.b]);
    }
    r
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes};
    use crate::light::lights::{DirectionalLight, Illumination};
    use crate::params::{InteriorParams, LineParams, Method, RelightParams};
    use crate::params::{ScalingParams, ShapeParams};
    use crate::plan::{Available, Goal, LightKinds, ToneFrom};
    use half::f16;

    /// Bumps of 20 pixels with a hole, under varying light.
    fn bumps(width: usize, height: usize) -> Frame {
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
            ..Frame::of_normals(normal, Mask::new(covered))
        }
    }

    #[test]
    fn an_enhanced_picture_is_the_same_without_slopes() {
        let mut frame = bumps(90, 60);
        let (available, shape) = (Available::in_frame(&frame), ShapeParams::default());
        let plan = Plan::new(Goal::Enhance, available, shape, ScalingParams::default()).unwrap();
        let (runner, inputs) = (Runner::default(), Inputs::default());
        let whole = runner.execute(&plan, &frame, inputs).unwrap();
        for large in [usize::MAX, 0] {
            let made = runner.make_picture(&plan, &mut frame, inputs, Watch::default(), large);
            let made = made.unwrap();
            assert_eq!(made.color, whole.color);
            assert_ne!(made.color, frame.color);
            assert_eq!(frame.normal.z.samples().is_empty(), large == 0);
        }
        let made = runner.make_picture(&plan, &mut bumps(90, 60), inputs, Watch::default(), 0);
        let made = made.unwrap();
        let has_slopes = |outcome: &Outcome| outcome.shape.gradient.is_some();
        assert_eq!([&made, &whole].map(has_slopes), [false, true]);
    }

    #[test]
    fn a_relit_picture_is_the_same_without_slopes() {
        let light = Illumination {
            directional: vec![DirectionalLight::white([135.0, 40.0])],
            ..Illumination::default()
        };
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let lit = Frame {
            depth: Some(Plane::filled(90, 60, 3.0)),
            ..bumps(90, 60)
        };
        // Half floats hold its picture and albedo, but for one channel.
        let mut with_albedo = lit.clone();
        let color = with_albedo.color.as_mut().unwrap();
        for plane in [&mut color.r, &mut color.g] {
            let samples = plane.samples_mut().iter_mut();
            samples.for_each(|v| *v = f16::from_f32(*v).to_f32());
        }
        with_albedo.albedo = with_albedo.color.clone();
        // Scaling takes the trace that the gain was chosen from, warping the Hessian.
        let cases = [
            (Method::Scale, &lit, false),
            (Method::Warp, &lit, true),
            (Method::Warp, &with_albedo, true),
        ];
        for (method, frame, has_slopes) in cases {
            let params = RelightParams {
                method,
                ..RelightParams::default()
            };
            let (available, kinds) = (Available::in_frame(frame), LightKinds::in_light(&light));
            let plan = Plan::relight(available, shape, scaling, params, kinds).unwrap();
            let (runner, inputs) = (Runner::default(), Inputs::lit_by(&light));
            let whole = runner.execute(&plan, frame, inputs).unwrap();
            assert!(whole.shape.gradient.is_some());
            for large in [usize::MAX, 0] {
                let mut used = frame.clone();
                let made = runner.make_picture(&plan, &mut used, inputs, Watch::default(), large);
                let made = made.unwrap();
                assert_eq!(made.color, whole.color);
                assert_eq!(made.shape.gradient.is_some(), has_slopes, "{method:?}");
                assert_eq!(used.depth.is_none(), large == 0);
                assert_eq!(used.normal.z.samples().is_empty(), large == 0);
                assert_eq!(used.color, frame.color);
                assert_eq!(used.albedo.is_some(), frame.albedo.is_some() && large > 0);
            }
        }
    }

    #[test]
    fn bands_draw_what_the_whole_draws_bit_for_bit() {
        for tone in [ToneFrom::Enhanced, ToneFrom::Shape(None)] {
            assert_bands_draw_the_whole(tone);
        }
    }

    /// Such a drawing takes its picture to the end.
    #[test]
    fn edges_of_shadows_are_not_found_in_bands() {
        let frame = bumps(30, 20);
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let available = Available::in_frame(&frame);
        for (shadow_share, in_bands) in [(0.0, true), (0.5, false)] {
            let interior = InteriorParams {
                shadow_share,
                ..InteriorParams::default()
            };
            let params = LineParams {
                interior: Some(interior),
                ..LineParams::default()
            };
            let plan = Plan::hatch(available, shape, scaling, ToneFrom::Enhanced, params);
            assert_eq!(goes_in_bands(&plan.unwrap()), in_bands);
        }
    }

    fn assert_bands_draw_the_whole(tone: ToneFrom) {
        let frame = bumps(90, 150);
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let available = Available::in_frame(&frame);
        let plan = Plan::hatch(available, shape, scaling, tone, LineParams::default()).unwrap();
        assert!(goes_in_bands(&plan));
        let runner = Runner::default();
        let inputs = Inputs::default();
        let whole = runner.execute(&plan, &frame, inputs).unwrap();
        for rows in [37, 64] {
            let mut used = frame.clone();
            let watch = Watch::default();
            let made = runner.draw_in_bands(&plan, &mut used, inputs, watch, rows);
            let made = made.unwrap();
            let chosen = |o: &Outcome| (o.gain, o.white_level);
            assert_eq!(chosen(&made), chosen(&whole));
            let [made, whole] = [&made, &whole].map(|o| o.drawing.as_ref().unwrap());
            assert!(whole.hatching.samples().iter().any(|&ink| ink > 0.5));
            assert_eq!(made.hatching, whole.hatching, "{rows}");
            assert_eq!(made.contours, whole.contours, "{rows}");
            assert_eq!(made.interior, whole.interior, "{rows}");
            assert_eq!(made.white_point, whole.white_point);
        }
    }
}
