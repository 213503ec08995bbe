//! Data shared by all stages: planes, the mask, windows, the camera; and passes over it, in recycled memory.

#[cfg(feature = "cli")]
pub(crate) mod bend;
mod builder;
mod clutter;
mod conventions;
pub(crate) mod coverage;
pub(crate) mod depth;
#[cfg(feature = "cli")]
pub(crate) mod detail;
mod enlarged;
pub(crate) mod from_depth;
mod fur;
pub(crate) mod gap;
mod light_layers;
mod mask;
pub(crate) mod memory;
mod motion;
pub(crate) mod normals;
pub(crate) mod objects;
pub(crate) mod percentile;
mod plane;
mod ray;
mod reduced;
mod repair;
pub(crate) mod rows;
pub(crate) mod sampling;
mod sight;
mod slopes;
mod space;
mod specular;
mod steps;
mod strength;
mod surroundings;
mod window;

pub(crate) use builder::PIXEL_ASPECTS;
#[doc(inline)]
pub use builder::{FrameBuilder, Normals, Sample, Samples};
pub use conventions::{Flip, NormalEncoding, StoredDepth};
pub use light_layers::{Gloss, LightGroup, LightLayers, Lobe, LobeLayer, LobeLayers};
pub(crate) use mask::Extent;
pub use mask::Mask;
pub use motion::static_world_motion;
pub(crate) use objects::pieces;
pub use plane::CurvaturePlanes;
pub(crate) use plane::MOST_ROWS_PER_TASK;
pub use plane::{ColorPlanes, Plane, SymmetricPlanes, Vector2Planes, Vector3Planes};
pub(crate) use plane::{each_row_of, parallel_rows};
pub use ray::Ray;
#[cfg(feature = "cli")]
pub(crate) use repair::{CONFIDENCE_REACH, HOLE_REACH};
pub(crate) use repair::{
    DENOISING_REACH, UNROUNDING_PHASE, UNROUNDING_REACH, confidence, denoise, lift_out_of_fog,
    noise_left, unround, unround_wrapped,
};
#[cfg(feature = "gpu")]
pub(crate) use sight::MIN_SEEN;
pub use sight::SightLines;
pub(crate) use sight::{
    PixelLines, ToEye, direction_seen, facing, line_of, point_on, step_by_normals,
};
pub use space::OutOfRange;
pub(crate) use space::check_place;
pub use space::{Camera, DepthKind, NormalSpace, Projection};
pub use specular::SpecularScene;
pub(crate) use steps::{SURFACE_JUMP, step_between};
pub(crate) use strength::strength_of;
pub use surroundings::{Surroundings, map_direction};
pub use window::Window;

use std::collections::BTreeMap;

/// Mean n_z from which work is flat. Tablets and inscriptions have .86 to .98, busts and figures .76 at most.
const FLAT: f64 = 0.8;

/// Rows between those that tell whether work is flat.
const ROWS_APART: usize = 8;

/// The focal length where none is known, in longer sides of the picture.
const FOCAL_SIDES: f64 = 1.25;

/// The projection of a picture whose camera is not known: a perspective 44 degrees across, about its middle.
pub(crate) fn likely_projection(display_window: Window, pixel_aspect: f32) -> Projection {
    let focal = FOCAL_SIDES * display_window.width().max(display_window.height()) as f64;
    let center = display_window.center();
    Projection::Perspective {
        fx: focal,
        fy: focal * f64::from(pixel_aspect),
        cx: center.x,
        cy: center.y,
    }
}

/// A surface seen from one viewpoint, with the picture made of it.
///
/// All planes have the size of the data window. Outside the mask their samples are undefined, except for colour and
/// alpha, which are the picture and are kept everywhere.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The pixels that the planes hold.
    pub data_window: Window,
    /// The pixels meant to be shown; the camera is centred on them.
    pub display_window: Window,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The pixels that show a surface.
    pub mask: Mask,
    /// View-space unit normals.
    pub normal: Vector3Planes,
    /// Length of the normals before normalisation: below 1 where a filter mixed different normals. `None` if nothing
    /// was filtered.
    pub normal_length: Option<Plane>,
    /// Confidence, 0..1, that a pixel shows a single surface: lower in defocus, motion blur, fur or fog. Engines weight
    /// by it what they choose a gain from; the command line blends results with the frame's own picture by it. `None` if
    /// it is 1 everywhere, or was not computed.
    pub confidence: Option<Plane>,
    /// Distance from the viewer, positive, in scene units; [`Source::depth_kind`] gives the direction it is measured
    /// in.
    pub depth: Option<Plane>,
    /// Alpha or ambient occlusion, 0..1, used in place of depth for silhouettes.
    pub occlusion: Option<Plane>,
    /// Importance: the share, 0..1, of the diffusion that each pixel gets.
    pub importance: Option<Plane>,
    /// Strength of the effect, 0..1. Engines weight by it what they choose a gain from; the command line blends results
    /// with the frame's own picture by it.
    pub strength: Option<Plane>,
    /// Numbers of objects, from 1, for lines between those that touch; 0 where a piece is too small for lines around it.
    pub objects: Option<Plane>,
    /// Stroke directions where curvature gives none, for objects with a direction of their own: x and y are the unit
    /// vector at twice its angle, z is 1 for upright on the surface; all 0 for the drawing's general direction.
    pub stroke_fallback: Option<Vector3Planes>,
    /// The picture, scene-linear.
    pub color: Option<ColorPlanes>,
    /// Albedo, scene-linear, from a layer or file if there is one.
    pub albedo: Option<ColorPlanes>,
    /// Coverage of the picture, 0..1; colour is premultiplied by it.
    pub alpha: Option<Plane>,
    /// The light layers that add up to the picture, if present and requested.
    pub light: LightLayers,
    /// The camera, if known.
    pub camera: Option<Camera>,
    /// Whether the picture is a tile: whether its left and right borders continue each other, and its top and bottom.
    /// Engines then look past the border on the opposite side.
    pub wraps: [bool; 2],
    /// Facts about the file that the frame was read from.
    pub source: Source,
}

/// Facts about the file that a frame was read from: data that outputs must preserve, and the precision of samples.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Source {
    /// Full names of all layers in the file, including those not read.
    pub layers: Vec<String>,
    /// Attributes of the file's first part, as text.
    pub attributes: BTreeMap<String, String>,
    /// Weights of linear red, green and blue in luminance, if the file names its primaries.
    pub luminance_weights: Option<[f32; 3]>,
    /// The kind of depth.
    pub depth_kind: DepthKind,
    /// Largest rounding error of a component of the normals as stored: 1/255 for 8 bits, 0 for 32-bit floats.
    pub normal_rounding: f32,
    /// Largest rounding errors of depth as stored: as a share of it, 2^-11 for half floats, and in its own unit, for codes.
    pub depth_rounding: [f32; 2],
    /// Whether the file holds the light of its picture in passes.
    pub(crate) light_passes: bool,
    /// Whether depth was given as heights over a plane.
    pub(crate) heights: bool,
}

impl Frame {
    /// Weights of linear red, green and blue in the picture's luminance: those of its primaries, or of Rec. 709.
    pub fn luminance_weights(&self) -> [f32; 3] {
        self.source
            .luminance_weights
            .unwrap_or(ColorPlanes::REC709_LUMINANCE)
    }

    /// The camera's projection, or else the likely one.
    pub(crate) fn likely_projection(&self) -> Projection {
        let assumed = || likely_projection(self.display_window, self.pixel_aspect);
        self.camera.map_or_else(assumed, |camera| camera.projection)
    }

    /// A frame with view-space unit normals only, within `mask`: square pixels, all of them shown.
    pub fn of_normals(normal: Vector3Planes, mask: Mask) -> Self {
        let window = Window::from_size(mask.width(), mask.height());
        Self {
            data_window: window,
            display_window: window,
            pixel_aspect: 1.0,
            mask,
            normal,
            normal_length: None,
            confidence: None,
            depth: None,
            occlusion: None,
            importance: None,
            strength: None,
            objects: None,
            stroke_fallback: None,
            color: None,
            albedo: None,
            alpha: None,
            light: LightLayers::default(),
            camera: None,
            wraps: [false; 2],
            source: Source::default(),
        }
    }

    /// The part of the frame inside `part`, with the same coordinates, camera and display window.
    ///
    /// # Panics
    /// If `part` reaches outside the data window.
    pub fn crop(&self, part: Window) -> Frame {
        let whole = self.data_window;
        assert!(whole.encloses(&part), "crop {part} reaches outside {whole}");
        // A part of a tile has borders of its own where it does not reach from one to the other.
        let spans = [
            part.width() == whole.width(),
            part.height() == whole.height(),
        ];
        Frame {
            wraps: [0, 1].map(|axis| self.wraps[axis] && spans[axis]),
            ..self.repeated(part)
        }
    }

    /// Whether it shows flat work: relief that faces the viewer.
    pub(crate) fn is_flat_work(&self) -> bool {
        let rows = (0..self.mask.height()).step_by(ROWS_APART);
        let of_row = |y| {
            self.mask
                .runs(y)
                .flat_map(move |run| &self.normal.z.row(y)[run])
        };
        let facing = rows.flat_map(of_row);
        let (count, sum) = facing.fold((0_u64, 0.0), |(count, sum), &z| {
            (count + 1, sum + f64::from(z))
        });
        sum >= FLAT * count as f64
    }

    /// Whether it is a photo or a map of a surface without gaps: no depth but heights, no passes of light, and no perspective
    /// that is known.
    pub(crate) fn is_map(&self) -> bool {
        let projection = self.camera.map(|camera| camera.projection);
        let is_near = matches!(projection, Some(Projection::Perspective { .. }));
        let is_alone = self.depth.is_none() && !is_near;
        !self.source.light_passes && (is_alone || self.source.heights)
    }

    /// Whether any of its borders continue each other.
    pub(crate) fn is_tile(&self) -> bool {
        self.wraps.contains(&true)
    }

    /// The frame repeated in all directions, inside `part`: no tile itself, with the same camera and display window.
    pub(crate) fn repeated(&self, part: Window) -> Frame {
        let whole = self.data_window;
        let mask = self.mask.repeated(whole, part);
        Frame {
            data_window: part,
            wraps: [false; 2],
            ..self.with_planes(mask, |plane| plane.repeated(whole, part))
        }
    }

    /// The frame with this mask, and `plane` applied to every plane.
    fn with_planes(&self, mask: Mask, plane: impl Fn(&Plane) -> Plane + Copy) -> Frame {
        let colors = |c: &ColorPlanes| c.mapped(plane);
        let vectors = |v: &Vector3Planes| v.mapped(plane);
        Frame {
            mask,
            normal: vectors(&self.normal),
            normal_length: self.normal_length.as_ref().map(plane),
            confidence: self.confidence.as_ref().map(plane),
            depth: self.depth.as_ref().map(plane),
            occlusion: self.occlusion.as_ref().map(plane),
            importance: self.importance.as_ref().map(plane),
            strength: self.strength.as_ref().map(plane),
            objects: self.objects.as_ref().map(plane),
            stroke_fallback: self.stroke_fallback.as_ref().map(vectors),
            color: self.color.as_ref().map(colors),
            albedo: self.albedo.as_ref().map(colors),
            alpha: self.alpha.as_ref().map(plane),
            light: self.light.map(plane),
            source: self.source.clone(),
            ..*self
        }
    }
}

/// The luminance of a colour.
#[inline(always)]
pub(crate) fn luminance(rgb: [f32; 3], weights: [f32; 3]) -> f32 {
    rgb[0] * weights[0] + rgb[1] * weights[1] + rgb[2] * weights[2]
}
