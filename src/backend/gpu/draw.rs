//! Drawings. Strokes, and what lines cover, are made on the device. The field of directions, which takes double
//! precision, and lines along edges, which are followed from pixel to pixel, are found on the CPU while the device
//! makes what they do not touch.

use super::fault::Fault;
use super::hatching::Texture;
use super::kernels::{GAIN, WHITE};
use super::light_layers::{TermWhites, levels_of};
use super::recorder::add_timings;
use super::relight::frame_lit;
use super::run::Run;
use super::runner::{Runner, SCALES, apart};
use crate::backend::cpu::{Drawing, DrawingInputs, Outcome, Shape, contour_lines, contour_pieces};
use crate::backend::device_times::{READ_BACK, RECORD, UPLOAD};
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use crate::line::contours::Contour;
use crate::params::{LineParams, Style};
use crate::plan::{Goal, Plan, Stage};
use std::time::Instant;

impl Runner {
    /// Runs `plan`, made by [`Plan::hatch`], on `frame`: its drawing, the tone that was drawn where it was made, and
    /// the edges.
    ///
    /// The directions of strokes and the lines along edges are found on the CPU.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost, has too little memory, or takes no picture so large whole.
    ///
    /// # Panics
    /// If the plan was made for other inputs, or [`Runner::can_run`] is false.
    pub fn draw(&self, plan: &Plan, frame: &Frame, inputs: DrawingInputs) -> Result<Outcome> {
        let params = plan.drawing.as_ref().expect("a drawing is planned");
        assert!(Self::can_run(plan), "every stage has a kernel");
        assert!(
            inputs.sequence.is_none(),
            "strokes lie still in the picture"
        );
        let done =
            self.guarded(|| Ok(self.draw_whole(plan, frame, params, inputs)?.expect("TODO")));
        done.map_err(Fault::into_error)
    }

    fn draw_whole(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        inputs: DrawingInputs,
    ) -> Result<Option<Outcome>> {
        let most_rows = self.most_rows(plan, frame, self.device().plane_bytes)?;
        if most_rows < frame.mask.height() as u64 {
            return Err(self.device().error(format_args!(
                "takes {most_rows} rows of this picture at a time, and a drawing takes all of it"
            )));
        }
        let mut outcome = Outcome::default();
        let light = (plan.goal == Goal::Relight)
            .then(|| {
                let illumination = inputs.illumination;
                let illumination = illumination.expect("new light is planned with its lights");
                self.light(plan, frame, illumination)
            })
            .transpose()?;
        if let Some(light) = &light {
            outcome.timings.extend(&light.timings);
            outcome.environment_gain = light.around.gain();
        }
        // Edges first: all that is left to the CPU asks for them.
        let start = Instant::now();
        let mut run = self.start(plan, frame);
        let edges = run.edges(plan, frame);
        let weights: Vec<_> = edges.weights.iter().collect();
        let of_edges = run.recorder.submit(&weights);
        let rows = 0..frame.mask.height();
        let copied = match &light {
            Some(light) => light.albedo(self.upload(), plan, frame, &rows),
            None => self.upload().picture(frame),
        };
        let is_copied = copied.is_some();
        outcome.timings.push((UPLOAD, start.elapsed()));

        // Strokes, while the CPU follows lines.
        let fields = run.stroke_fields(
            plan,
            &params.field,
            params.directions,
            frame,
            &edges.conductance,
        );
        let shape = run.shape_along(plan, edges);
        run.choose_gain(plan, &shape);
        let picture = match &light {
            Some(light) => run.relight(plan, frame, light, Some(&shape), copied),
            None => copied.expect("a drawing is planned with its tone"),
        };
        let mut term_whites = TermWhites::new();
        if plan.goal == Goal::Enhance {
            run.scale(plan, frame, &shape, &picture);
            term_whites = run.scale_layers(plan, frame, &shape, &picture);
        }
        let paper = run.choose_paper_white(&params.tone, frame, &picture);
        let densities = run.densities(&params.tone, frame, &picture, &paper);
        let ink = self.strokes(
            &mut run,
            (plan, params),
            frame,
            inputs,
            (&densities, &fields.directions),
            &mut outcome,
        );
        let of_strokes = run.recorder.submit(&[]);
        let (read, times) = of_edges.read()?;
        add_timings(&mut outcome.timings, &times.unwrap_or_default());
        put_edges(&mut outcome.shape, read, frame);
        let lines = self.contour_lines(plan, frame, params, &mut outcome);
        let contours = lines.as_ref().map(|lines| {
            let graphite = (params.strokes.style == Style::Pencil).then_some(params.strokes.seed);
            run.covered_by_lines(frame, &contour_pieces(lines), graphite)
        });

        let times = of_strokes.read()?.1;
        add_timings(&mut outcome.timings, &times.unwrap_or_default());
        let is_made = light.is_some() || SCALES.iter().any(|&stage| plan.has(stage));
        let chosen = run.chosen.clone();
        let mut wanted = vec![&fields.further, &chosen, &paper, &ink];
        wanted.extend(&contours);
        wanted.extend(picture.iter().filter(|_| is_made));
        wanted.extend(term_whites.iter().map(|(_, white)| white));
        let (read, mut times) = run.finish(&wanted)?;
        // Since the last submission the CPU has done more than record.
        times.retain(|(name, _)| *name != RECORD);
        add_timings(&mut outcome.timings, &times);
        let start = Instant::now();
        let mut read = read.into_iter();
        let further = read.next().expect("all that is wanted is read");
        if further[0].to_bits() > fields.room {
            return Ok(None);
        }
        put_drawing(&mut outcome, plan, frame, &mut read, lines);
        if is_made {
            outcome.color = Some(ColorPlanes {
                r: plane_of(frame, read.next()),
                g: plane_of(frame, read.next()),
                b: plane_of(frame, read.next()),
            });
        }
        if let (Some(color), true) = (&mut outcome.color, light.is_some()) {
            frame_lit(color, frame);
        }
        outcome.term_white_levels = levels_of(&term_whites, read);
        add_timings(&mut outcome.timings, &[(READ_BACK, start.elapsed())]);
        self.buffers.take_back(
            contours
                .into_iter()
                .chain([densities, ink])
                .chain(fields.into_buffers()),
        );
        self.buffers.take_back(shape.into_buffers());
        match is_copied {
            true => self.buffers.take_back_copied(picture),
            false => self.buffers.take_back(picture),
        }
        Ok(Some(outcome))
    }

    /// How much of the paper strokes cover, by the texture that the style asks for.
    fn strokes(
        &self,
        run: &mut Run,
        (plan, params): (&Plan, &LineParams),
        frame: &Frame,
        inputs: DrawingInputs,
        (densities, directions): (&wgpu::Buffer, &[[wgpu::Buffer; 2]]),
        outcome: &mut Outcome,
    ) -> wgpu::Buffer {
        let strokes = &params.strokes;
        let made = (strokes.style != Style::Pictures).then(|| {
            let (map, time) = self.host.drawn_art_map(plan, strokes);
            let time = time.map(|time| ("tonal-art-map", time));
            outcome.timings.extend(time);
            map
        });
        let start = Instant::now();
        let (map, texture) = match &made {
            Some(map) => (&**map, self.texture.of(map, self.upload())),
            None => {
                let map = inputs.art_map.expect("strokes of pictures come with them");
                (map, Texture::new(map, self.upload()))
            }
        };
        let ink = run.hatched(strokes, frame, densities, directions, (map, &texture));
        add_timings(&mut outcome.timings, &[(UPLOAD, start.elapsed())]);
        ink
    }

    /// The lines along the edges that were read, where they are wanted.
    fn contour_lines(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        outcome: &mut Outcome,
    ) -> Option<Vec<Contour>> {
        let start = Instant::now();
        let scale = params.strokes.factor(plan.resolution_factor as f32);
        let params = params.contours?.scaled(scale);
        let shape = &outcome.shape;
        let weights = [&shape.silhouette, &shape.crease].map(|weights| {
            let weights = weights.as_ref();
            weights.expect("contours are planned with their weights")
        });
        let lines = contour_lines(plan, frame, weights, &params);
        outcome.timings.push(("contour-lines", start.elapsed()));
        Some(lines)
    }
}

/// A plane of what was read, which is there.
fn plane_of(frame: &Frame, read: Option<Vec<f32>>) -> Plane {
    let samples = read.expect("all that is wanted is read");
    Plane::from_samples(frame.mask.width(), frame.mask.height(), samples)
}

/// Puts what was read of edges into the shape: their weights, where contours ask for them.
fn put_edges(shape: &mut Shape, read: Vec<Vec<f32>>, frame: &Frame) {
    let mut read = read.into_iter();
    if let Some(weights) = read.next() {
        let weights = apart::<2>(&weights).map(|samples| plane_of(frame, Some(samples)));
        let [silhouette, crease] = weights;
        (shape.silhouette, shape.crease) = (Some(silhouette), Some(crease));
    }
}

/// Puts into the outcome what was read of a drawing: the numbers chosen for its tone and for its paper, strokes, and
/// contours where there are `lines`.
fn put_drawing(
    outcome: &mut Outcome,
    plan: &Plan,
    frame: &Frame,
    read: &mut impl Iterator<Item = Vec<f32>>,
    lines: Option<Vec<Contour>>,
) {
    let mut numbers = || read.next().expect("all that is wanted is read");
    let (chosen, of_paper) = (numbers(), numbers());
    outcome.drawing = Some(Drawing {
        hatching: plane_of(frame, read.next()),
        lines: Vec::new(),
        contours: lines.is_some().then(|| plane_of(frame, read.next())),
        contour_lines: lines.unwrap_or_default(),
        white_point: of_paper[WHITE as usize],
        coordinates: None,
    });
    if plan.has(Stage::Trace) || plan.has(Stage::Hessian) {
        outcome.gain = Some(chosen[GAIN as usize]);
    }
    if plan.has(Stage::RadianceScaling) {
        outcome.white_level = Some(chosen[WHITE as usize]);
    }
}
