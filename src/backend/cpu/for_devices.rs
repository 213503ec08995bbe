//! What other backends leave to the CPU: what follows lines from pixel to pixel, what is carried from frame to frame, and
//! what is chosen from, or found on, a frame that a device takes in strips.

use super::contours::{self, DrawnLine, FoundEdges, Piece};
use super::drawing::{self, Densities, ToneOf};
use super::memory::Memory;
use super::{Runner, SequenceInputs, TextureCoordinates, direction_field, light_layers, relight};
use crate::backend::light_terms::light_terms;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use crate::line::contours::Contour;
use crate::line::streamlines::Streamline;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{ContourParams, LineParams, ScalingParams, StrokeParams};
use crate::plan::Plan;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The albedo of a frame, estimated from its picture.
pub(in crate::backend) fn estimated_albedo(frame: &Frame) -> ColorPlanes {
    let weights = frame.luminance_weights();
    relight::estimated(frame, weights, &Memory::default())
}

/// The white levels of the terms that the light of a frame is scaled by.
pub(in crate::backend) fn term_white_levels(
    frame: &Frame,
    params: &ScalingParams,
) -> Vec<(&'static str, f32)> {
    let terms = light_terms(&frame.light.lobes, params);
    light_layers::white_levels(&terms, frame, params, &Memory::default())
}

/// The contours of a frame with these silhouette and crease weights, silhouettes first.
pub(in crate::backend) fn contour_lines(
    plan: &Plan,
    frame: &Frame,
    [silhouette, crease]: [&Plane; 2],
    params: &ContourParams,
) -> Vec<Contour> {
    let weights = contours::Weights { silhouette, crease };
    contours::contours(&weights, frame, &plan.shape, params)
}

/// The contours of a frame along edges that a device found, silhouettes first.
pub(in crate::backend) fn contours_along(
    plan: &Plan,
    frame: &Frame,
    edges: &FoundEdges,
    params: &ContourParams,
) -> Vec<Contour> {
    edges.contours(frame, &plan.shape, params)
}

/// The pieces that contours are drawn in: lines that meet are one.
pub(in crate::backend) fn contour_pieces(lines: &[Contour]) -> Vec<Piece> {
    let pieces = lines
        .par_iter()
        .flat_map_iter(|line| contours::strokes(&DrawnLine::from(line)));
    pieces.map(|piece| (0, piece)).collect()
}

/// The pieces that strokes are drawn in which are lines.
pub(in crate::backend) fn streamline_pieces(lines: &[Streamline]) -> Vec<Piece> {
    let pieces = lines
        .par_iter()
        .enumerate()
        .flat_map_iter(|(number, line)| {
            let pieces = contours::strokes(&DrawnLine::from(line)).into_iter();
            pieces.map(move |piece| (number as u32, piece))
        });
    pieces.collect()
}

impl Runner {
    /// The directions that strokes follow, one field for each family: see [`Runner::stroke_fields`].
    pub(in crate::backend) fn drawn_directions(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        conductance: &Plane,
    ) -> Vec<Vector2Planes> {
        let (field, wanted, memory) = (&params.field, params.directions, &self.memory);
        direction_field::stroke_fields(plan, field, wanted, frame, conductance, None, memory)
    }

    /// Where the texture of strokes lies on a frame of a sequence.
    pub(in crate::backend) fn texture_coordinates(
        &self,
        frame: &Frame,
        sequence: SequenceInputs,
    ) -> TextureCoordinates {
        TextureCoordinates::of(frame, sequence, &self.memory)
    }

    /// The texture of strokes, and how long it took to make where it was not kept.
    pub(in crate::backend) fn drawn_art_map(
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
    pub(in crate::backend) fn streamlines(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &LineParams,
        (tone, white): (&ColorPlanes, f32),
        directions: &[Vector2Planes],
        conductance: &Plane,
    ) -> Vec<Streamline> {
        let weights = frame.luminance_weights();
        let densities = Densities::new(ToneOf::Picture(tone, weights), frame, white, &params.tone);
        let factor = plan.resolution_factor as f32;
        let (strokes, memory) = (&params.strokes, &self.memory);
        drawing::lines(
            &densities,
            directions,
            conductance,
            strokes,
            factor,
            frame,
            memory,
        )
    }

    /// Takes planes that are no longer needed.
    pub(in crate::backend) fn take_back_planes(&self, planes: impl IntoIterator<Item = Plane>) {
        self.memory.take_back(planes);
    }
}
