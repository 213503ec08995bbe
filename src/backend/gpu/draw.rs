//! Drawings. Strokes, and what lines cover, are made on the device, and edges are found there. The field of directions,
//! which takes double precision, and lines, which follow edges from pixel to pixel, are found on the CPU while the device
//! makes what they do not touch.

use super::edge_lists::Coming;
use super::fault::Fault;
use super::hatching::Texture;
use super::kernels::{GAIN, WHITE};
use super::light_layers::{TermWhites, levels_of};
use super::recorder::add_timings;
use super::relight::frame_lit;
use super::run::Run;
use super::runner::{Runner, SCALES};
use crate::backend::cpu::{Drawing, DrawingInputs, Outcome, contour_pieces};
use crate::backend::device_times::{READ_BACK, RECORD, UPLOAD};
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use crate::line::contours::Contour;
use crate::params::{ContourParams, LineParams, Style};
use crate::plan::{Goal, Plan, Stage};
use std::time::Instant;

impl Runner {
    /// Runs `plan`, made by [`Plan::hatch`], on `frame`: its drawing, the tone that was drawn where it was made, and
    /// the conductance.
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
        let done = self.guarded(|| Ok(self.draw_whole(plan, frame, params, inputs)?));
        done.map_err(Fault::into_error)
    }

    fn draw_whole(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        inputs: DrawingInputs,
    ) -> Result<Outcome> {
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
        let contours = params
            .contours
            .map(|contours| contours.scaled(params.strokes.factor(plan.resolution_factor as f32)));
        let lists = contours.map(|contours| run.edge_lists(plan, frame, &edges, &contours));
        let counts = lists.iter().map(|lists| &lists.counts);
        let wanted = std::iter::once(&edges.conductance).chain(counts);
        let of_edges = run.recorder.submit(&wanted.collect::<Vec<_>>());
        let rows = 0..frame.mask.height();
        let copied = match &light {
            Some(light) => light.albedo(self.upload(), plan, frame, &rows),
            None => self.upload().picture(frame),
        };
        let is_copied = copied.is_some();
        outcome.timings.push((UPLOAD, start.elapsed()));

        // Tone, while the CPU finds directions.
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
        let of_tone = run.recorder.submit(&[]);
        let (read, times) = of_edges.read()?;
        add_timings(&mut outcome.timings, &times.unwrap_or_default());
        let mut read = read.into_iter();
        outcome.shape.conductance = Some(plane_of(frame, read.next()));
        let edges = lists.zip(shape.weights.as_ref()).zip(read.next());
        let edges = edges.map(|((lists, weights), counts)| run.hand_out(lists, &counts, weights));
        let directions = self.directions(plan, frame, params, &mut outcome);

        // Strokes, while the CPU follows lines.
        let ink = self.strokes(
            &mut run,
            (plan, params),
            frame,
            inputs,
            (&densities, &directions),
            &mut outcome,
        );
        let of_strokes = run.recorder.submit(&[]);
        let directions = directions.into_iter();
        self.host
            .take_back_planes(directions.flat_map(|Vector2Planes { x, y }| [x, y]));
        let lines = edges
            .zip(contours)
            .map(|(edges, contours)| contour_lines(edges, plan, frame, &contours, &mut outcome));
        let lines = lines.transpose()?;
        let contours = lines.as_ref().map(|lines| {
            let graphite = (params.strokes.style == Style::Pencil).then_some(params.strokes.seed);
            run.covered_by_lines(frame, &contour_pieces(lines), graphite)
        });

        for times in [of_tone.read()?.1, of_strokes.read()?.1] {
            add_timings(&mut outcome.timings, &times.unwrap_or_default());
        }
        let is_made = light.is_some() || SCALES.iter().any(|&stage| plan.has(stage));
        let chosen = run.chosen.clone();
        let mut wanted = vec![&chosen, &paper, &ink];
        wanted.extend(&contours);
        wanted.extend(picture.iter().filter(|_| is_made));
        wanted.extend(term_whites.iter().map(|(_, white)| white));
        let (read, mut times) = run.finish(&wanted)?;
        // Since the last submission the CPU has done more than record.
        times.retain(|(name, _)| *name != RECORD);
        add_timings(&mut outcome.timings, &times);
        let start = Instant::now();
        let mut read = read.into_iter();
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
        self.buffers
            .take_back(contours.into_iter().chain([densities, ink]));
        self.buffers.take_back(shape.into_buffers());
        match is_copied {
            true => self.buffers.take_back_copied(picture),
            false => self.buffers.take_back(picture),
        }
        Ok(outcome)
    }

    /// How much of the paper strokes cover, by the texture that the style asks for.
    fn strokes(
        &self,
        run: &mut Run,
        (plan, params): (&Plan, &LineParams),
        frame: &Frame,
        inputs: DrawingInputs,
        (densities, directions): (&wgpu::Buffer, &[Vector2Planes]),
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

    /// The directions of strokes, along the edges that were read.
    fn directions(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        outcome: &mut Outcome,
    ) -> Vec<Vector2Planes> {
        let start = Instant::now();
        let conductance = outcome.shape.conductance.as_ref();
        let conductance = conductance.expect("edges are read first");
        let directions = self.host.drawn_directions(plan, frame, params, conductance);
        outcome.timings.push(("direction-field", start.elapsed()));
        directions
    }
}

/// The lines along edges.
fn contour_lines(
    edges: Coming,
    plan: &Plan,
    frame: &Frame,
    params: &ContourParams,
    outcome: &mut Outcome,
) -> Result<Vec<Contour>> {
    let start = Instant::now();
    let lines = edges.lines(plan, frame, params)?;
    outcome.timings.push(("contour-lines", start.elapsed()));
    Ok(lines)
}

/// A plane of what was read, which is there.
fn plane_of(frame: &Frame, read: Option<Vec<f32>>) -> Plane {
    let samples = read.expect("all that is wanted is read");
    Plane::from_samples(frame.mask.width(), frame.mask.height(), samples)
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
