//! Drawings: the tone of a picture in strokes along the curvature, and lines along its edges.

use crate::engine::cpu::Run;
use crate::engine::cpu::frame_cache::FrameCache;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Drawing;
use crate::frame::{Frame, Plane};
use crate::line::contours::Contour;
use crate::line::contours::coverage::{DrawnLine, Overlap, coverage};
use crate::line::contours::cpu as contours;
use crate::line::direction_field::cpu::stroke_fields;
use crate::line::hatching::cpu as hatching;
use crate::line::paper::{grain, graphite};
use crate::line::specular::seen_through;
use crate::line::streamlines::cpu as lines;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::line::tone::{Densities, ToneOf};
use crate::params::{Adaptive, ContourParams, LineParams, Style};
use crate::plan::Stage;
use crate::shape::edges::cpu as edges;
use rayon::prelude::*;
use std::time::Instant;

/// The edges that a drawing follows: those of the frame, or of what is seen in its mirrors and lenses.
struct DrawnEdges<'a> {
    silhouette: Option<&'a Plane>,
    crease: Option<&'a Plane>,
}

const WITH_EDGES: &str = "a drawing is planned with its edges";

impl Run<'_> {
    /// Draws the picture made so far, or that of the frame.
    pub(crate) fn draw(&mut self, params: &LineParams, inputs: Inputs) {
        self.draw_tone(params, inputs, None);
    }

    /// The same from the `luminance` of a picture that is not kept: nor then are the weights of edges, once lines are drawn
    /// along them.
    pub(crate) fn draw_tone(
        &mut self,
        params: &LineParams,
        inputs: Inputs,
        luminance: Option<&Plane>,
    ) {
        let (plan, frame, memory) = (self.plan, self.frame, &self.runner.memory);
        let seen = plan.specular.and_then(|specular| {
            let scene = inputs
                .specular
                .expect("specular pixels are planned with what they show");
            let kept = &self.runner.map_directions;
            self.timed("specular-trace", || {
                seen_through(plan, frame, scene, &specular, params, kept, memory)
            })
        });
        // Lines stop at the edges of what is seen in a mirror, as they do at those of other things.
        let mut own = std::mem::take(&mut self.outcome.shape);
        let through = seen.as_ref().map(|seen| {
            self.timed("specular-edges", || {
                edges::edges_and_gradient(plan, &seen.frame, memory).0
            })
        });
        let drawn = seen.as_ref().map_or(frame, |seen| &seen.frame);
        let edges = match &through {
            Some(edges) => DrawnEdges {
                silhouette: edges.silhouette.as_ref(),
                crease: edges.crease.as_ref(),
            },
            None => DrawnEdges {
                silhouette: own.silhouette.as_ref(),
                crease: own.crease.as_ref(),
            },
        };
        let scale = params.strokes.factor(plan.resolution_factor as f32);
        let contours = params.contours.map(|contours| {
            let (covered, lines) = self.draw_contours(&edges, drawn, &contours.scaled(scale));
            let covered = match params.strokes.style {
                Style::Pencil => self.in_graphite(covered, params.strokes.seed),
                Style::Pen | Style::Pictures | Style::Lines => covered,
            };
            (covered, lines)
        });
        if luminance.is_some() {
            memory.recycle(own.silhouette.take().into_iter().chain(own.crease.take()));
        }
        let conductance = match &through {
            Some(edges) => &edges.conductance,
            None => own.conductance.as_ref().expect(WITH_EDGES),
        };
        let kept = |kept: &mut FrameCache| kept.field.take();
        let directions = self.kept_or(kept, "direction-field", || {
            let given = seen.as_ref().map(|seen| &seen.directions[..]);
            let (field, wanted) = (&params.field, params.directions);
            stroke_fields(plan, field, wanted, drawn, conductance, given, memory)
        });
        let made = self.outcome.color.take();
        let tone = match luminance {
            Some(luminance) => ToneOf::Luminance(luminance),
            None => {
                let color = made.as_ref().or(frame.color.as_ref());
                let color = color.expect("a drawing is planned with its tone");
                ToneOf::Picture(color, frame.luminance_weights())
            }
        };
        let white = match params.tone.white_point {
            Adaptive::Fixed(white) => white,
            Adaptive::Auto => self.timed("auto-white", || tone.white_level(&frame.mask)),
        };
        let coordinates = inputs.sequence.map(|sequence| {
            self.timed("texture-coordinates", || {
                TextureCoordinates::of(frame, sequence, memory)
            })
        });
        let densities = Densities::new(tone, frame, white, &params.tone);
        let strokes = &params.strokes;
        let factor = plan.resolution_factor as f32;
        let mut lines = Vec::new();
        let hatching = if plan.has(Stage::Streamlines) {
            self.timed("streamlines", || {
                lines = lines::lines(
                    &densities,
                    &directions,
                    conductance,
                    strokes,
                    factor,
                    drawn,
                    memory,
                );
                lines::inked(&lines, frame, memory)
            })
        } else {
            let made_map = (strokes.style != Style::Pictures).then(|| {
                let kept = &self.runner.art_map;
                kept.of(strokes, factor, |make| self.timed("tonal-art-map", make))
            });
            let map = made_map.as_deref().or(inputs.art_map);
            let map = map.expect("strokes of pictures come with them");
            let coordinates = coordinates.as_ref();
            self.timed("hatching", || {
                hatching::hatched(
                    &densities,
                    &directions,
                    coordinates,
                    map,
                    strokes,
                    frame,
                    memory,
                )
            })
        };
        match self.kept.as_deref_mut().filter(|_| seen.is_none()) {
            Some(kept) => kept.field.put(directions),
            None => memory.recycle(directions.into_iter().flat_map(|d| [d.x, d.y])),
        }
        let (contours, contour_lines) = contours.unzip();
        self.outcome.color = made;
        self.outcome.shape = own;
        self.outcome.drawing = Some(Drawing {
            hatching,
            lines,
            contours,
            contour_lines: contour_lines.unwrap_or_default(),
            white_point: white,
            coordinates,
        });
    }

    /// Lines as a pencil draws them on grained paper.
    fn in_graphite(&self, mut covered: Plane, seed: u64) -> Plane {
        let window = self.frame.data_window;
        let width = covered.width();
        let rows = covered.samples_mut().par_chunks_mut(width);
        rows.enumerate().for_each(|(y, row)| {
            let y = window.y0.wrapping_add(y as i32);
            for (x, coverage) in row.iter_mut().enumerate().filter(|(_, c)| **c > 0.0) {
                let x = window.x0.wrapping_add(x as i32);
                *coverage = graphite(*coverage, grain(x, y, seed));
            }
        });
        covered
    }

    fn draw_contours(
        &mut self,
        edges: &DrawnEdges,
        frame: &Frame,
        params: &ContourParams,
    ) -> (Plane, Vec<Contour>) {
        let (plan, memory) = (self.plan, &self.runner.memory);
        let kept = self.kept.as_deref();
        if let Some(drawn) = kept.and_then(|kept| kept.contours.get()) {
            return drawn.clone();
        }
        let start = Instant::now();
        let weights = contours::Weights {
            silhouette: edges.silhouette.expect(WITH_EDGES),
            crease: edges.crease.expect(WITH_EDGES),
        };
        let lines = contours::contours(&weights, frame, &plan.shape, params);
        let drawn: Vec<DrawnLine> = lines.iter().map(DrawnLine::from).collect();
        let covered = coverage(&drawn, Overlap::Joined, &frame.mask, memory);
        self.outcome.timings.push(("contours", start.elapsed()));
        let kept = self.kept.as_deref_mut();
        if let Some(kept) = kept.filter(|_| plan.specular.is_none()) {
            kept.contours.put((covered.clone(), lines.clone()));
        }
        (covered, lines)
    }
}
