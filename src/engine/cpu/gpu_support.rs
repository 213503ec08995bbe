//! Work that other backends leave to the CPU: following lines from pixel to pixel, state carried from frame to frame, and
//! choices from the whole of a frame that a device processes in strips.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::run::Runner;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use crate::light::layers::cpu as light_layers;
use crate::light::layers::terms::light_terms;
use crate::line::contours::Contour;
use crate::line::contours::coverage::{DrawnLine, Piece, covered};
use crate::line::contours::cpu as contours;
use crate::line::contours::found::FoundEdges;
use crate::line::contours::medium::in_medium;
use crate::line::direction_field::cpu as direction_field;
use crate::line::interior::{InteriorLayer, cpu};
use crate::line::streamlines::Streamline;
use crate::line::streamlines::cpu::{Family, lines};
use crate::line::texture_coordinates::cpu::{SequenceInputs, TextureCoordinates};
use crate::line::tonal_art_map::TonalArtMap;
use crate::line::tone::{Densities, PictureDensities, ToneOf};
use crate::params::{ContourParams, LineParams, ScalingParams, StrokeParams};
use crate::plan::Plan;
use crate::shape::edges::cpu::edges_with_weights;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The albedo of a frame, estimated from its picture.
pub(crate) fn estimated_albedo(frame: &Frame) -> ColorPlanes {
    let weights = frame.luminance_weights();
    crate::light::relight::albedo::estimated(frame, weights, &Memory::default())
}

/// The white levels of the terms that the light of a frame is scaled by.
pub(crate) fn term_white_levels(frame: &Frame, params: &ScalingParams) -> Vec<(&'static str, f32)> {
    let terms = light_terms(&frame.light.lobes, params);
    light_layers::white_levels(&terms, frame, params, &Memory::default())
}

/// The contours of a frame with these silhouette and crease weights, silhouettes first.
pub(crate) fn contour_lines(
    plan: &Plan,
    frame: &Frame,
    [silhouette, crease]: [&Plane; 2],
    params: &ContourParams,
) -> Vec<Contour> {
    let weights = contours::Weights { silhouette, crease };
    contours::contours(&weights, frame, &plan.shape, params)
}

/// The contours of a frame along edges that a device found, silhouettes first.
pub(crate) fn contours_along(
    plan: &Plan,
    frame: &Frame,
    edges: &FoundEdges,
    params: &ContourParams,
) -> Vec<Contour> {
    edges.contours(frame, &plan.shape, params)
}

/// The pieces that contours are drawn in: lines that meet are one.
pub(crate) fn contour_pieces(lines: &[Contour]) -> Vec<Piece> {
    let pieces = lines
        .par_iter()
        .flat_map_iter(|line| crate::line::contours::coverage::strokes(&DrawnLine::from(line)));
    pieces.map(|piece| (0, piece)).collect()
}

/// The pieces that strokes are drawn in which are lines.
pub(crate) fn streamline_pieces(lines: &[Streamline]) -> Vec<Piece> {
    let pieces = lines
        .par_iter()
        .enumerate()
        .flat_map_iter(|(number, line)| {
            let pieces =
                crate::line::contours::coverage::strokes(&DrawnLine::from(line)).into_iter();
            pieces.map(move |piece| (number as u32, piece))
        });
    pieces.collect()
}

impl Runner {
    /// The directions that strokes follow, one field for each family: see [`Runner::stroke_fields`].
    pub(crate) fn drawn_directions(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        conductance: &Plane,
    ) -> Vec<Vector2Planes> {
        let (field, wanted, memory) = (&params.field, params.directions, &self.memory);
        direction_field::stroke_fields(plan, field, wanted, frame, conductance, None, memory)
    }

    /// The lines inside the surfaces of a frame beside these contours, and what they cover, where they are asked for. Its
    /// silhouette weight is made where it is not given.
    pub(crate) fn interior(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        silhouette: Option<&Plane>,
        contours: &[Contour],
    ) -> Option<InteriorLayer> {
        let interior = params.interior?;
        let made = silhouette.is_none().then(|| {
            let edges = edges_with_weights(plan, frame, true, &self.memory).0;
            edges.silhouette.expect("weights are asked for")
        });
        let silhouette = silhouette.or(made.as_ref()).expect("one of both is there");
        let fades = plan.available.in_sequence;
        let (options, memory) = (&self.options, &self.memory);
        let (lines, levels) = cpu::interior(
            frame, silhouette, contours, &interior, fades, options, memory,
        );
        let covered = covered(&lines, &frame.mask, &self.memory);
        Some(InteriorLayer {
            covered: in_medium(covered, frame, &params.strokes),
            lines,
            levels,
        })
    }

    /// Where the texture of strokes lies on a frame of a sequence.
    pub(crate) fn texture_coordinates(
        &self,
        frame: &Frame,
        sequence: SequenceInputs,
    ) -> TextureCoordinates {
        TextureCoordinates::of(frame, sequence, &self.memory)
    }

    /// The texture of strokes, and how long it took to make where it was not kept.
    pub(crate) fn drawn_art_map(
        &self,
        plan: &Plan,
        params: &StrokeParams,
    ) -> (Arc<TonalArtMap>, Option<Duration>) {
        let mut made = None;
        let map = self
            .art_map
            .of(params, plan.resolution_factor as f32, |make| {
                let start = Instant::now();
                let map = make();
                made = Some(start.elapsed());
                map
            });
        (map, made)
    }

    /// The strokes of a tone as lines along fields of directions, where luminance `white` is paper white.
    pub(crate) fn streamlines(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        (tone, white): (&ColorPlanes, f32),
        directions: &[Vector2Planes],
        conductance: &Plane,
    ) -> Vec<Streamline> {
        let weights = frame.luminance_weights();
        let tone = ToneOf::Picture(tone, weights);
        let densities = PictureDensities::new(tone, frame, white, &params.tone);
        let densities = Densities::OfPicture(densities);
        let factor = plan.resolution_factor as f32;
        let (strokes, memory) = (&params.strokes, &self.memory);
        lines(
            &densities,
            &Family::all(directions, &[]),
            conductance,
            strokes,
            factor,
            frame,
            memory,
        )
        .0
    }

    /// Takes planes that are no longer needed.
    pub(crate) fn take_back_planes(&self, planes: impl IntoIterator<Item = Plane>) {
        self.memory.recycle(planes);
    }
}
