//! Drawings in strips, with choices and CPU results from the whole picture: for
//! pictures whose planes are larger than a device takes, and those in lines, which the CPU places when it has the tone.

use crate::engine::cpu::gpu_support::{contour_lines, contour_pieces, streamline_pieces};
use crate::engine::gpu::constants::WHITE;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::runner::Runner;
use crate::engine::gpu::surface::deinterleave;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::add_timings;
use crate::engine::outcome::{Drawing, Outcome, Shape};
use crate::engine::tiles::Strips;
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, Vector2Planes};
use crate::light::relight::gpu_lights::Light;
use crate::line::contours::Contour;
use crate::line::contours::coverage::Piece;
use crate::line::contours::gpu_coverage::Medium;
use crate::line::contours::stage::scaled;
use crate::line::gpu_drawing::{medium, plane_of};
use crate::line::hatching::gpu::Strokes;
use crate::line::interior::stage::INTERIOR;
use crate::line::streamlines::Streamline;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::params::{Adaptive, LineParams};
use crate::plan::Plan;
use crate::shape::auto_levels::gpu::Search;
use std::ops::Range;
use std::time::Instant;

/// Lines of the whole picture, drawn in every strip.
struct Drawn<'a> {
    /// With paper white as it was chosen.
    params: LineParams,
    white_point: f32,
    tone: &'a ColorPlanes,
    directions: &'a [Vector2Planes],
    ink: Ink,
    /// Where its texture lies, where that moves.
    coordinates: Option<TextureCoordinates>,
    contours: Option<Lines<Contour>>,
}

/// The inputs of strokes.
enum Ink {
    Texture(Strokes),
    Lines(Lines<Streamline>),
}

/// Lines, and the pieces that they are drawn in.
struct Lines<T> {
    lines: Vec<T>,
    pieces: Vec<Piece>,
}

impl<T> Lines<T> {
    /// The pieces that reach some rows.
    fn reaching(&self, rows: &Range<usize>) -> Vec<Piece> {
        let [top, end] = [rows.start, rows.end].map(|row| row as f32);
        let reaching = self.pieces.iter().filter(|(_, piece)| {
            let [first, last] = piece.rows();
            first < end && last > top
        });
        reaching.copied().collect()
    }
}

impl Runner {
    /// Draws a frame in strips.
    pub(crate) fn draw_strips(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        light: Option<&Light>,
        inputs: Inputs,
        strips: &Strips,
    ) -> Result<Outcome> {
        let is_made = plan.makes_picture();
        let mut outcome = match is_made {
            true => self.run_strips(plan, frame, light, strips)?,
            false => Outcome::default(),
        };
        let edges = strips.run(frame, |strip, _| self.edges_of(plan, strip), drop)?;
        outcome.shape = edges.shape;
        add_timings(&mut outcome.timings, &edges.timings);
        let made = outcome.color.take();
        let tone = made.as_ref().or(frame.color.as_ref());
        let tone = tone.expect("a drawing is planned with its tone");
        // Neighbours tell how a texture came to lie; beyond that every pixel is drawn by itself.
        let strips = strips.reaching(1);
        let white_point = self.paper_white(plan, frame, params, tone, &strips)?;
        let directions = self.directions(plan, frame, params, &mut outcome);
        let contours = self.contour_lines(plan, frame, params, &mut outcome);
        let start = Instant::now();
        let followed = contours.as_deref().unwrap_or_default();
        let silhouette = outcome.shape.silhouette.as_ref();
        let interior = self
            .host
            .interior(plan, frame, params, silhouette, followed);
        add_timings(&mut outcome.timings, &[(INTERIOR.name, start.elapsed())]);
        let mut params = *params;
        params.tone.white_point = Adaptive::Fixed(white_point);
        let ink = match params.strokes.style.is_laid() {
            true => {
                let tone = (tone, white_point);
                Ink::Lines(self.streamlines(plan, frame, &params, tone, &directions, &mut outcome))
            }
            false => Ink::Texture(self.strokes(plan, &params, inputs, &mut outcome)),
        };
        let drawn = Drawn {
            params,
            white_point,
            tone,
            directions: &directions,
            ink,
            coordinates: self.coordinates(frame, inputs, &mut outcome),
            contours: contours.map(|lines| Lines {
                pieces: contour_pieces(&lines),
                lines,
            }),
        };
        let draw = |strip: &Frame, rows: &Range<usize>| self.draw_strip(plan, strip, rows, &drawn);
        let strip_by_strip = strips.run(frame, draw, drop)?;
        add_timings(&mut outcome.timings, &strip_by_strip.timings);
        let lines = match drawn.ink {
            Ink::Lines(drawn) => drawn.lines,
            Ink::Texture(_) => Vec::new(),
        };
        let contours = drawn.contours.map(|contours| contours.lines);
        outcome.drawing = strip_by_strip.drawing.map(|drawing| Drawing {
            lines,
            contour_lines: contours.unwrap_or_default(),
            coordinates: drawn.coordinates,
            ..drawing
        });
        outcome.put_interior(interior);
        let directions = directions.into_iter();
        self.host
            .take_back_planes(directions.flat_map(|Vector2Planes { x, y }| [x, y]));
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
        self.buffers.recycle(buffers.chain(edges.weights));
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
        let params = scaled(plan, params)?;
        let shape = &outcome.shape;
        let weights = [&shape.silhouette, &shape.crease].map(|weights| {
            let weights = weights.as_ref();
            weights.expect("contours are planned with their weights")
        });
        let lines = contour_lines(plan, frame, weights, &params);
        outcome.timings.push(("contour-lines", start.elapsed()));
        Some(lines)
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
        let search = [Search::White(frame.luminance_weights())];
        let found = self.search(plan, frame, Some(tone), &search, strips)?;
        Ok(found[WHITE as usize])
    }

    /// The strokes of a tone, and its paper white, as lines between the edges that were read.
    fn streamlines(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        tone: (&ColorPlanes, f32),
        directions: &[Vector2Planes],
        outcome: &mut Outcome,
    ) -> Lines<Streamline> {
        let start = Instant::now();
        let conductance = outcome.shape.conductance.as_ref();
        let conductance = conductance.expect("edges are read first");
        let lines = self
            .host
            .streamlines(plan, frame, params, tone, directions, conductance);
        outcome.timings.push(("streamlines", start.elapsed()));
        Lines {
            pieces: streamline_pieces(&lines),
            lines,
        }
    }

    /// Draws a strip: these rows of the picture. What of a drawing is of the whole is left out.
    fn draw_strip(
        &self,
        plan: &Plan,
        strip: &Frame,
        rows: &Range<usize>,
        drawn: &Drawn,
    ) -> Result<Outcome> {
        let mut run = self.start(plan, strip);
        let ink = match &drawn.ink {
            Ink::Lines(lines) => {
                let pieces = lines.reaching(rows);
                run.covered_by_lines(strip, rows.start, &pieces, Medium::InkWithin)
            }
            Ink::Texture(strokes) => run.textured(strip, rows, drawn, strokes),
        };
        let contours = drawn.contours.as_ref().map(|contours| {
            let pieces = contours.reaching(rows);
            run.covered_by_lines(strip, rows.start, &pieces, medium(&drawn.params))
        });
        let wanted = std::iter::once(&ink).chain(&contours);
        let (read, timings) = run.finish(&wanted.collect::<Vec<_>>())?;
        let mut read = read.into_iter();
        let drawing = Drawing {
            hatching: plane_of(strip, read.next()),
            lines: Vec::new(),
            contours: contours.is_some().then(|| plane_of(strip, read.next())),
            contour_lines: Vec::new(),
            interior: None,
            interior_lines: Vec::new(),
            asked: None,
            dots: Vec::new(),
            white_point: drawn.white_point,
            coordinates: None,
        };
        self.buffers.recycle(contours.into_iter().chain([ink]));
        Ok(Outcome {
            drawing: Some(drawing),
            timings,
            ..Outcome::default()
        })
    }
}

/// Puts what was read of edges into the shape: conductance, and the weights where contours ask for them.
fn put_edges(shape: &mut Shape, read: Vec<Vec<f32>>, frame: &Frame) {
    let mut read = read.into_iter();
    shape.conductance = Some(plane_of(frame, read.next()));
    if let Some(weights) = read.next() {
        let weights = deinterleave::<2>(&weights).map(|samples| plane_of(frame, Some(samples)));
        let [silhouette, crease] = weights;
        (shape.silhouette, shape.crease) = (Some(silhouette), Some(crease));
    }
}

impl Run<'_> {
    /// How much of a strip strokes of a texture cover.
    fn textured(
        &mut self,
        strip: &Frame,
        rows: &Range<usize>,
        drawn: &Drawn,
        strokes: &Strokes,
    ) -> wgpu::Buffer {
        let (tone, params) = (&drawn.params.tone, &drawn.params.strokes);
        let color = [&drawn.tone.r, &drawn.tone.g, &drawn.tone.b];
        let picture = color.map(|plane| self.hold_rows(plane, rows));
        let paper = self.choose_paper_white(tone, strip, &picture);
        let densities = self.densities(tone, strip, &picture, &paper);
        let fields = drawn.directions.iter();
        let fields: Vec<_> = fields.map(|field| self.hold_field(field, rows)).collect();
        let sheets = self.sheets(drawn.coordinates.as_ref(), rows);
        let ink = self.hatched(params, strip, &densities, &fields, strokes, &sheets);
        self.buffers.recycle([densities]);
        ink
    }
}
