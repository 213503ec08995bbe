//! Drawings. Edges, directions, strokes, and what lines cover, are made on the device; lines, which follow edges from
//! pixel to pixel, are found on the CPU while the device makes the strokes.

use crate::engine::cpu::gpu_support::contour_pieces;
use crate::engine::device_times::{READ_BACK, RECORD, UPLOAD};
use crate::engine::gpu::constants::{GAIN, WHITE};
use crate::engine::gpu::made::{Shape, TermWhites};
use crate::engine::gpu::run::Run;
use crate::engine::gpu::runner::Runner;
use crate::engine::gpu::surface::Picture;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::add_timings;
use crate::engine::outcome::{Drawing, Outcome};
use crate::error::Result;
use crate::frame::{Frame, Plane};
use crate::light::enhancement::Subject;
use crate::light::layers::gpu::levels_of;
use crate::light::relight::gpu::frame_lit;
use crate::light::relight::gpu_lights::Light;
use crate::line::contours::Contour;
use crate::line::contours::gpu::PendingReadback;
use crate::line::contours::gpu_coverage::Medium;
use crate::line::contours::stage::scaled;
use crate::line::hatching::gpu::{Strokes, Texture};
use crate::line::interior::stage::INTERIOR;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::params::{ContourParams, LineParams, Style};
use crate::plan::Plan;
use crate::plan::resolve::running;
use crate::product::Product;
use crate::shape::edges::stage::EDGES;
use std::time::Instant;

impl Runner {
    /// Draws a frame whose planes the device takes; `None` where surfaces fall apart into more patches than there is room
    /// for.
    pub(crate) fn draw_whole(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        light: Option<&Light>,
        inputs: Inputs,
    ) -> Result<Option<Outcome>> {
        let mut outcome = Outcome::default();
        // Edges first: lines along them are left to the CPU.
        let start = Instant::now();
        let mut run = self.start(plan, frame);
        let edges = run.edges(plan, frame);
        let contours = scaled(plan, params);
        let lists = contours.map(|contours| run.edge_lists(plan, frame, &edges, &contours));
        let counts: Vec<_> = lists.iter().map(|lists| &lists.counts).collect();
        let of_edges = run.recorder.submit(&counts);
        let copied = match light {
            Some(light) => light.albedo(self.upload(), plan, frame, &(0..frame.mask.height())),
            None => self.upload().picture(frame),
        };
        let is_copied = copied.is_some();
        outcome.timings.push((UPLOAD, start.elapsed()));

        let (read, times) = of_edges.read()?;
        add_timings(&mut outcome.timings, &times.unwrap_or_default());
        let listed = lists.zip(edges.weights.as_ref()).zip(read.first());
        let listed = listed.map(|((lists, weights), counts)| run.dispatch(lists, counts, weights));

        // Strokes, while the CPU follows lines.
        let fields = run.stroke_fields(
            plan,
            &params.field,
            params.directions,
            frame,
            &edges.conductance,
        );
        run.light = light;
        let (shape, picture, term_whites) = tone_between(&mut run, edges, copied);
        let paper = run.choose_paper_white(&params.tone, frame, &picture);
        let densities = run.densities(&params.tone, frame, &picture, &paper);
        let of_strokes = (&densities, &fields.directions[..]);
        let (ink, coordinates) = self.hatch(&mut run, params, inputs, of_strokes, &mut outcome);
        let of_strokes = run.recorder.submit(&[]);
        let lines = listed
            .zip(contours)
            .map(|(edges, contours)| lines_along(edges, plan, frame, &contours, &mut outcome));
        let lines = lines.transpose()?;
        let start = Instant::now();
        let followed = lines.as_deref().unwrap_or_default();
        let interior = self.host.interior(plan, frame, params, None, followed);
        add_timings(&mut outcome.timings, &[(INTERIOR.name, start.elapsed())]);
        let contours = lines
            .as_ref()
            .map(|lines| run.covered_by_lines(frame, 0, &contour_pieces(lines), medium(params)));

        let times = of_strokes.read()?.1;
        add_timings(&mut outcome.timings, &times.unwrap_or_default());
        let is_made = plan.makes_picture();
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
        put_drawing(&mut outcome, plan, frame, &mut read, lines, coordinates);
        outcome.put_interior(interior);
        if is_made {
            let mut planes = read.by_ref().map(|samples| plane_of(frame, Some(samples)));
            outcome.put(Product::Picture, &mut planes);
        }
        if let (Some(color), true) = (&mut outcome.color, light.is_some()) {
            frame_lit(color, frame);
        }
        outcome.term_white_levels = levels_of(&term_whites, read);
        add_timings(&mut outcome.timings, &[(READ_BACK, start.elapsed())]);
        let rest = contours.into_iter().chain([densities, ink]);
        let rest = rest.chain(fields.into_buffers());
        self.buffers.recycle(rest.chain(shape.into_buffers()));
        self.buffers.recycle_either(picture, is_copied);
        Ok(Some(outcome))
    }

    /// Strokes of these densities along these directions, and where their texture lies.
    fn hatch(
        &self,
        run: &mut Run,
        params: &LineParams,
        inputs: Inputs,
        (densities, directions): (&wgpu::Buffer, &[[wgpu::Buffer; 2]]),
        outcome: &mut Outcome,
    ) -> (wgpu::Buffer, Option<TextureCoordinates>) {
        let (plan, frame) = (run.plan, run.frame);
        let strokes = self.strokes(plan, params, inputs, outcome);
        let coordinates = self.coordinates(frame, inputs, outcome);
        let start = Instant::now();
        let sheets = run.sheets(coordinates.as_ref(), &(0..frame.mask.height()));
        let style = &params.strokes;
        let ink = run.hatched(style, frame, densities, directions, &strokes, &sheets);
        add_timings(&mut outcome.timings, &[(UPLOAD, start.elapsed())]);
        (ink, coordinates)
    }

    /// The strokes that the style asks for, on the device.
    pub(crate) fn strokes(
        &self,
        plan: &Plan,
        params: &LineParams,
        inputs: Inputs,
        outcome: &mut Outcome,
    ) -> Strokes {
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
        add_timings(&mut outcome.timings, &[(UPLOAD, start.elapsed())]);
        Strokes::new(map, texture, strokes)
    }

    /// Where the texture of strokes lies, for a frame of a sequence.
    pub(crate) fn coordinates(
        &self,
        frame: &Frame,
        inputs: Inputs,
        outcome: &mut Outcome,
    ) -> Option<TextureCoordinates> {
        let sequence = inputs.sequence?;
        let start = Instant::now();
        let coordinates = self.host.texture_coordinates(frame, sequence);
        outcome
            .timings
            .push(("texture-coordinates", start.elapsed()));
        Some(coordinates)
    }
}

/// The tone between edges that are there, of a picture on the device: the shape and the picture that it takes, and the
/// white levels of the terms of light.
fn tone_between(
    run: &mut Run,
    edges: Shape,
    picture: Option<Picture>,
) -> (Shape, Picture, TermWhites) {
    (run.made.shape, run.made.picture) = (Some(edges), picture);
    let further = running(run.plan).filter(|stage| stage.name != EDGES.name);
    further.for_each(|stage| (stage.gpu)(run));
    let made = std::mem::take(&mut run.made);
    let there = "a drawing is planned with its tone";
    let (shape, picture) = (made.shape.expect(there), made.picture.expect(there));
    (shape, picture, made.term_whites)
}

/// The lines along edges.
fn lines_along(
    edges: PendingReadback,
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

/// The medium of contours.
pub(crate) fn medium(params: &LineParams) -> Medium {
    match params.strokes.style {
        Style::Pencil => Medium::Graphite(params.strokes.seed),
        _ => Medium::Ink,
    }
}

/// A plane of what was read, which is there.
pub(crate) fn plane_of(frame: &Frame, read: Option<Vec<f32>>) -> Plane {
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
    coordinates: Option<TextureCoordinates>,
) {
    let mut numbers = || read.next().expect("all that is wanted is read");
    let (chosen, of_paper) = (numbers(), numbers());
    outcome.drawing = Some(Drawing {
        hatching: plane_of(frame, read.next()),
        lines: Vec::new(),
        dots: Vec::new(),
        contours: lines.is_some().then(|| plane_of(frame, read.next())),
        contour_lines: lines.unwrap_or_default(),
        interior: None,
        interior_lines: Vec::new(),
        asked: None,
        white_point: of_paper[WHITE as usize],
        coordinates,
    });
    if plan.wants_curvature() {
        outcome.gain = Some(chosen[GAIN as usize]);
    }
    if plan.scaled() == Some(Subject::Picture) {
        outcome.white_level = Some(chosen[WHITE as usize]);
    }
}
