//! Drawings of pictures whose planes are larger than a device takes: strip by strip, with what is chosen from all of
//! the picture, and what the CPU finds on all of it.

use super::choose::Search;
use super::draw::{graphite, plane_of, put_edges};
use super::enhance::luminance_weights;
use super::hatching::Strokes;
use super::kernels::WHITE;
use super::light::Light;
use super::recorder::add_timings;
use super::runner::{Runner, SCALES};
use super::strips::Strips;
use crate::backend::cpu::{Drawing, DrawingInputs, Outcome, TextureCoordinates, contour_pieces};
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, Vector2Planes};
use crate::line::contours::round_stroke::RoundStroke;
use crate::params::{Adaptive, LineParams};
use crate::plan::Plan;
use std::ops::Range;

/// What is drawn in every strip, of the whole picture.
struct Drawn<'a> {
    /// With paper white as it was chosen.
    params: LineParams,
    white_point: f32,
    tone: &'a ColorPlanes,
    directions: &'a [Vector2Planes],
    strokes: &'a Strokes,
    /// Where the texture lies, where it moves.
    coordinates: Option<&'a TextureCoordinates>,
    /// The pieces of its contours, where they are wanted.
    pieces: Option<&'a [RoundStroke]>,
}

impl Runner {
    /// Draws a frame in strips.
    pub(super) fn draw_strips(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        light: Option<&Light>,
        inputs: DrawingInputs,
        strips: &Strips,
    ) -> Result<Outcome> {
        let is_made = light.is_some() || SCALES.iter().any(|&stage| plan.has(stage));
        let mut outcome = match is_made {
            true => self.run_strips(plan, frame, light, strips)?,
            false => Outcome::default(),
        };
        let edges = strips.run(frame, |strip, _| self.edges_of(plan, strip))?;
        outcome.shape = edges.shape;
        add_timings(&mut outcome.timings, &edges.timings);
        let made = outcome.color.take();
        let tone = made.as_ref().or(frame.color.as_ref());
        let tone = tone.expect("a drawing is planned with its tone");
        // Neighbours tell how a texture came to lie; beyond that every pixel is drawn by itself.
        let strips = strips.reaching(1);
        let white_point = self.paper_white(plan, frame, params, tone, &strips)?;
        let directions = self.directions(plan, frame, params, &mut outcome);
        let lines = self.contour_lines(plan, frame, params, &mut outcome);
        let pieces = lines.as_deref().map(contour_pieces);
        let strokes = self.strokes(plan, params, inputs, &mut outcome);
        let coordinates = self.coordinates(frame, inputs, &mut outcome);
        let mut drawn = Drawn {
            params: *params,
            white_point,
            tone,
            directions: &directions,
            strokes: &strokes,
            coordinates: coordinates.as_ref(),
            pieces: pieces.as_deref(),
        };
        drawn.params.tone.white_point = Adaptive::Fixed(white_point);
        let drawing = strips.run(frame, |strip, rows| {
            self.draw_strip(plan, strip, rows, &drawn)
        })?;
        add_timings(&mut outcome.timings, &drawing.timings);
        let drawing = drawing.drawing.map(|drawing| Drawing {
            contour_lines: lines.unwrap_or_default(),
            coordinates,
            ..drawing
        });
        let directions = directions.into_iter();
        self.host
            .take_back_planes(directions.flat_map(|Vector2Planes { x, y }| [x, y]));
        outcome.drawing = drawing;
        outcome.color = made;
        Ok(outcome)
    }

    /// The edges of a strip.
    fn edges_of(&self, plan: &Plan, strip: &Frame) -> Result<Outcome> {
        let mut run = self.start(plan, strip);
        let edges = run.edges(plan, strip);
        let wanted = std::iter::once(&edges.conductance).chain(&edges.weights);
        let (read, timings) = run.finish(&wanted.collect::<Vec<_>>())?;
        let mut outcome = Outcome {
            timings,
            ..Outcome::default()
        };
        put_edges(&mut outcome.shape, read, strip);
        let buffers = [edges.conductance, edges.gradient].into_iter();
        self.buffers.take_back(buffers.chain(edges.weights));
        Ok(outcome)
    }

    /// The luminance of paper white for the whole of a tone.
    fn paper_white(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        tone: &ColorPlanes,
        strips: &Strips,
    ) -> Result<f32> {
        if let Adaptive::Fixed(white) = params.tone.white_point {
            return Ok(white);
        }
        let search = [Search::White(luminance_weights(frame))];
        let found = self.search(plan, frame, Some(tone), &search, strips)?;
        Ok(found[WHITE as usize])
    }

    /// Draws a strip: these rows of the picture.
    fn draw_strip(
        &self,
        plan: &Plan,
        strip: &Frame,
        rows: &Range<usize>,
        drawn: &Drawn,
    ) -> Result<Outcome> {
        let params = &drawn.params;
        let picture = self.upload().rows(drawn.tone, rows);
        let mut run = self.start(plan, strip);
        let paper = run.choose_paper_white(&params.tone, strip, &picture);
        let densities = run.densities(&params.tone, strip, &picture, &paper);
        let fields = drawn.directions.iter();
        let fields: Vec<_> = fields.map(|field| run.hold_field(field, rows)).collect();
        let sheets = run.sheets(drawn.coordinates, rows);
        let ink = run.hatched(
            &params.strokes,
            strip,
            &densities,
            &fields,
            drawn.strokes,
            &sheets,
        );
        let contours = drawn.pieces.map(|pieces| {
            let [top, end] = [rows.start, rows.end].map(|row| row as f32);
            let reaching = pieces.iter().copied().filter(|piece| {
                let [first, last] = piece.rows();
                first < end && last > top
            });
            let reaching: Vec<_> = reaching.collect();
            run.covered_by_lines(strip, rows.start, &reaching, graphite(params))
        });
        let wanted = std::iter::once(&ink).chain(&contours);
        let (read, timings) = run.finish(&wanted.collect::<Vec<_>>())?;
        let mut read = read.into_iter();
        let drawing = Drawing {
            hatching: plane_of(strip, read.next()),
            lines: Vec::new(),
            contours: contours.is_some().then(|| plane_of(strip, read.next())),
            contour_lines: Vec::new(),
            white_point: drawn.white_point,
            coordinates: None,
        };
        let buffers = contours.into_iter().chain([densities, ink]);
        self.buffers.take_back(buffers);
        self.buffers.take_back_copied(picture);
        Ok(Outcome {
            drawing: Some(drawing),
            timings,
            ..Outcome::default()
        })
    }
}
