//! Drawing surfaces seen in specular pixels: stroke directions in the picture, and their apparent shape.

pub(crate) mod hit_points;
pub(crate) mod map_directions;
pub(crate) mod seen;
pub(crate) mod stage;
pub(crate) mod tangents;

use crate::frame::memory::Memory;
use crate::frame::{DepthKind, Frame, SightLines, SpecularScene, Vector2Planes};
use crate::line::direction_field::cpu::stroke_fields;
use crate::line::direction_field::patches::Patches;
use crate::line::specular::hit_points::hit_pixels;
use crate::line::specular::map_directions::{DirectionCache, directions};
use crate::line::specular::seen::{SeenPixel, seen_pixels};
use crate::line::specular::tangents::Tangents;
use crate::params::{LineParams, SpecularParams};
use crate::plan::Plan;
use crate::shape::edges::cpu as edges;
use crate::trace::Tracer;
use std::convert::Infallible;
use std::sync::Arc;

/// The surface that a frame's specular pixels show.
pub(crate) struct SeenThrough {
    /// The frame with the apparent shape of the surfaces seen in them.
    pub(crate) frame: Frame,
    /// The stroke directions on those surfaces, in the order wanted: unit, in the picture, x right, y up; 0 elsewhere
    /// and where unknown.
    pub(crate) directions: Vec<Vector2Planes>,
}

/// The part of `scene` that the specular pixels of `frame` show, with the directions of strokes there by `params`.
/// `None` where nothing can be traced.
pub(crate) fn seen_through(
    plan: &Plan,
    frame: &Frame,
    scene: &SpecularScene,
    specular: &SpecularParams,
    params: &LineParams,
    kept: &DirectionCache,
    memory: &Memory,
) -> Option<SeenThrough> {
    let camera = frame.camera?;
    let sight = SightLines::new(camera.projection);
    let tracer = Tracer::new(frame, scene, specular)?;
    let wanted = params.directions.wanted();
    let behind = scene.behind.as_ref().map(|behind| {
        let (edges, _) = edges::edges_and_gradient(plan, behind, memory);
        let (field, directions) = (&params.field, params.directions);
        let patches = Patches::new(behind, &edges.conductance, field.cell_px as usize);
        stroke_fields(
            plan,
            field,
            directions,
            behind,
            &patches,
            (None, None, None),
            memory,
        )
    });
    let tangents = Tangents {
        tracer: &tracer,
        camera,
        behind: behind.unwrap_or_default(),
        around: scene.surroundings.as_ref().map(|map| {
            let Ok(made) = kept.of(map, || Ok::<_, Infallible>(Arc::new(directions(map))));
            made
        }),
        families: [0, 1].into_iter().filter(|&f| wanted[f]).collect(),
        fallback: params.field.fallback,
    };
    let pixels = match &scene.hit_position {
        Some(points) => hit_pixels(frame, scene, points, &tangents, memory),
        None => seen_pixels(frame, &tracer, &tangents, memory),
    };
    let mut directions = vec![blank(frame); tangents.families.len()];
    for pixel in &pixels {
        for (plane, direction) in directions.iter_mut().zip(pixel.directions) {
            plane.x.row_mut(pixel.y)[pixel.x] = direction.x;
            plane.y.row_mut(pixel.y)[pixel.x] = direction.y;
        }
    }
    Some(SeenThrough {
        frame: as_it_appears(frame, &sight, &pixels),
        directions,
    })
}

fn blank(frame: &Frame) -> Vector2Planes {
    let [x, y] = [(); 2].map(|()| frame.normal.x.map(|_| 0.0));
    Vector2Planes { x, y }
}

/// The frame's shape, with the apparent one in its specular pixels; without the picture.
fn as_it_appears(frame: &Frame, sight: &SightLines, pixels: &[SeenPixel]) -> Frame {
    let mut normal = frame.normal.clone();
    let mut depth = frame.depth.clone();
    let mut lengths = frame.normal_length.clone();
    for pixel in pixels {
        let (x, y) = (pixel.x, pixel.y);
        normal.x.row_mut(y)[x] = pixel.normal.x;
        normal.y.row_mut(y)[x] = pixel.normal.y;
        normal.z.row_mut(y)[x] = pixel.normal.z;
        if let Some(depth) = &mut depth {
            let along = match frame.source.depth_kind {
                DepthKind::Ray => {
                    let at = frame.data_window.middle(x, y);
                    sight.line(at.x, at.y).1.length() as f32
                }
                DepthKind::Planar | DepthKind::Relative => 1.0,
            };
            depth.row_mut(y)[x] = pixel.depth * along;
        }
        if let Some(lengths) = &mut lengths {
            lengths.row_mut(y)[x] = 1.0;
        }
    }
    Frame {
        data_window: frame.data_window,
        display_window: frame.display_window,
        pixel_aspect: frame.pixel_aspect,
        normal_length: lengths,
        depth,
        occlusion: frame.occlusion.clone(),
        objects: frame.objects.clone(),
        alpha: frame.alpha.clone(),
        camera: frame.camera,
        source: frame.source.clone(),
        ..Frame::of_normals(normal, frame.mask.clone())
    }
}
