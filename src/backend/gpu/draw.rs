//! Drawings. Strokes, and what lines cover, are made on the device. The field of directions, which takes double
//! precision, and lines along edges, which are followed from pixel to pixel, are found on the CPU while the device
//! makes what they do not touch.

use super::hatching::Texture;
use super::kernels::{GAIN, WHITE};
use super::recorder::add_timings as add;
use super::runner::{Runner, apart};
use crate::backend::cpu::{Drawing, DrawingInputs, Outcome, Shape, contour_lines, contour_pieces};
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
        self.watched(|| self.draw_whole(plan, frame, params, inputs))
    }

    fn draw_whole(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        inputs: DrawingInputs,
    ) -> Result<Outcome> {
        let (width, height) = (frame.mask.width() as u64, frame.mask.height() as u64);
        // The widest planes hold both weights of a pixel.
        let most_rows = self.device().plane_bytes / (8 * width.max(1));
        if most_rows < height {
            return Err(self.device().error(format_args!(
                "takes {most_rows} rows of this picture at a time, and a drawing takes all of it"
            )));
        }
        let mut outcome = Outcome::default();
        // Edges first: all that is left to the CPU asks for them.
        let start = Instant::now();
        let mut run = self.start(plan, frame);
        let edges = run.edges(plan, frame);
        let wanted = std::iter::once(&edges.conductance).chain(&edges.weights);
        let of_edges = run.recorder.submit(&wanted.collect::<Vec<_>>());
        let picture = self.upload().picture(frame);
        let picture = picture.expect("a drawing is planned with its tone");
        outcome.timings.push(("upload", start.elapsed()));

        // Tone, while the CPU finds directions.
        let shape = run.shape_along(plan, edges);
        if plan.goal == Goal::Enhance {
            run.choose_gain(plan, &shape);
            run.scale(plan, frame, &shape, &picture);
        }
        let paper = run.choose_paper_white(&params.tone, frame, &picture);
        let densities = run.densities(&params.tone, frame, &picture, &paper);
        let of_tone = run.recorder.submit(&[]);
        let (read, times) = of_edges.read()?;
        add(&mut outcome.timings, times);
        put_edges(&mut outcome.shape, read, frame);
        let directions = self.directions(plan, frame, params, &mut outcome);

        // Strokes, while the CPU follows lines.
        let start = Instant::now();
        let (kept, own);
        let map = match params.strokes.style {
            Style::Pictures => {
                let map = inputs.art_map.expect("strokes of pictures come with them");
                own = Texture::new(map, self.upload());
                (map, &own)
            }
            _ => {
                let (map, made) = self.host.drawn_art_map(plan, &params.strokes);
                let made = made.map(|time| ("tonal-art-map", time));
                outcome.timings.extend(made);
                own = self.texture.of(&map, self.upload());
                kept = map;
                (&*kept, &own)
            }
        };
        let ink = run.hatched(&params.strokes, frame, &densities, &directions, map);
        let of_strokes = run.recorder.submit(&[]);
        outcome.timings.push(("upload", start.elapsed()));
        self.host
            .take_back_planes(directions.into_iter().flat_map(|d| [d.x, d.y]));
        let lines = self.contour_lines(plan, frame, params, &mut outcome);
        let contours = lines.as_ref().map(|lines| {
            let graphite = (params.strokes.style == Style::Pencil).then_some(params.strokes.seed);
            run.covered_by_lines(frame, &contour_pieces(lines), graphite)
        });

        let start = Instant::now();
        let scaled = plan.has(Stage::RadianceScaling);
        let chosen = run.chosen.clone();
        let mut wanted = vec![&chosen, &paper, &ink];
        wanted.extend(&contours);
        wanted.extend(picture.iter().filter(|_| scaled));
        let (read, times) = run.finish(&wanted)?;
        for times in [of_tone.read()?.1, of_strokes.read()?.1, times] {
            add(&mut outcome.timings, times);
        }
        let mut read = read.into_iter();
        let mut next = || read.next().expect("all that is wanted is read");
        let (chosen, of_paper) = (next(), next());
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let plane = |samples| Plane::from_samples(width, height, samples);
        outcome.drawing = Some(Drawing {
            hatching: plane(next()),
            lines: Vec::new(),
            contours: contours.as_ref().map(|_| plane(next())),
            contour_lines: lines.unwrap_or_default(),
            white_point: of_paper[WHITE as usize],
            coordinates: None,
        });
        if scaled {
            let [r, g, b] = [plane(next()), plane(next()), plane(next())];
            outcome.color = Some(ColorPlanes { r, g, b });
            outcome.white_level = Some(chosen[WHITE as usize]);
        }
        if plan.has(Stage::Trace) {
            outcome.gain = Some(chosen[GAIN as usize]);
        }
        outcome
            .timings
            .push(("wait-and-read-back", start.elapsed()));
        self.buffers
            .take_back(contours.into_iter().chain([densities, ink]));
        self.buffers.take_back(shape.into_buffers());
        self.buffers.take_back_copied(picture);
        Ok(outcome)
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

/// Puts what was read of edges into the shape: conductance, and the weights where contours ask for them.
fn put_edges(shape: &mut Shape, read: Vec<Vec<f32>>, frame: &Frame) {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let plane = |samples| Plane::from_samples(width, height, samples);
    let mut read = read.into_iter();
    shape.conductance = read.next().map(plane);
    if let Some(weights) = read.next() {
        let [silhouette, crease] = apart::<2>(&weights).map(plane);
        (shape.silhouette, shape.crease) = (Some(silhouette), Some(crease));
    }
}
