//! Frames without normals: those of the surface that their depth, heights or positions show.

use super::depth_sense::ABOVE_ONE;
use super::frame_sources::missing_normals;
use super::load::{FrameSource, Layers, SeenSurface};
use super::names::Hint;
use super::notes::Notes;
use super::roles::Role;
use super::sources::RoleSource;
use super::view::View;
use crate::error::Result;
use crate::frame::coverage::{self, Covered};
use crate::frame::depth::is_distance;
use crate::frame::from_depth::{Precision, normals_of_depth};
use crate::frame::{Camera, Mask, Plane, Projection, StoredDepth, likely_projection};
use glam::DAffine3;
use std::time::Instant;

/// The height of white over the longer side of a picture of heights, where it is not known.
const HIGH: f32 = 0.1;

impl FrameSource<'_> {
    /// The surface that depth shows, or positions in its place, where there are no normals.
    pub(super) fn surface_of_depth(
        &self,
        layers: &mut Layers,
        notes: &mut Notes,
    ) -> Result<SeenSurface> {
        let depth_is_half = self.depth_is_half(layers);
        let all = Mask::full(self.data_window.width(), self.data_window.height());
        let mut view = View::of_camera(self.inputs, &self.surface(&all, layers, None))?;
        let source = self.sources.get(Role::Depth);
        let precision = match source {
            _ if depth_is_half => Precision::Half,
            Some(source) if source.rounding() > 0.0 => Precision::Codes(source.rounding()),
            _ => layers
                .depth
                .as_ref()
                .map_or(Precision::Float, Precision::of),
        };
        let mut scale = 1.0;
        let (stored, why) = match (&mut layers.depth, view.camera) {
            (Some(height), _) if self.inputs.depth_kind == Some(StoredDepth::Height) => {
                view.camera = Some(self.camera_above());
                scale = self.height_scale(source, &mut notes.warnings);
                height.samples_mut().iter_mut().for_each(|h| *h *= scale);
                (StoredDepth::Height, format!("{scale} pixels high at 1"))
            }
            (Some(depth), _) => {
                let hint = source.map(RoleSource::hint).unwrap_or_default();
                self.inputs.depth_kind.map_or_else(
                    || judged(depth, hint, &mut notes.warnings),
                    |stored| (stored, "as given".into()),
                )
            }
            (None, Some(camera)) => {
                layers.depth = self.positions_for_depth(layers).map(|p| p.depth(&camera));
                (StoredDepth::Planar, "of positions".into())
            }
            (None, None) => return Err(missing_normals(self.main)),
        };
        let depth = layers
            .depth
            .as_mut()
            .ok_or_else(|| missing_normals(self.main))?;
        let projection = view.camera.map_or_else(
            || likely_projection(self.display_window, self.pixel_aspect),
            |camera| camera.projection,
        );
        let alpha = layers.alpha.as_ref().filter(|_| !stored.shows_coverage());
        let start = Instant::now();
        let mut normal = normals_of_depth(
            depth,
            stored,
            (projection, self.data_window),
            |x, y| alpha.is_none_or(|alpha| alpha.at(x, y) > 0.5),
            precision.times(scale),
        );
        let took = start.elapsed();
        let (from, bits) = match source {
            Some(source) if stored == StoredDepth::Height => ("heights", source.precision()),
            Some(source) => ("depth", source.precision()),
            None => ("positions", String::new()),
        };
        notes.on_no_normals(from, &bits, view.camera.is_some());
        notes.findings.append(&mut view.findings);
        notes.warnings.append(&mut view.warnings);
        let stored_depth = Some((depth, Some(stored)));
        let (alpha, covered) = (layers.alpha.as_ref(), layers.coverage.as_ref());
        let Covered { mask, lengths, .. } =
            coverage::cover(&mut normal, stored_depth, alpha, covered);
        notes.on_coverage(&mask);
        Ok(SeenSurface {
            normal,
            mask,
            lengths,
            sense: Some((stored, why)),
            depth_is_half,
            view,
            made: Some(took),
        })
    }

    /// The camera of heights: a unit is a pixel.
    fn camera_above(&self) -> Camera {
        let center = self.display_window.center();
        Camera {
            view_from_world: DAffine3::IDENTITY,
            projection: Projection::Orthographic {
                sx: 1.0,
                sy: self.pixel_aspect.into(),
                cx: center.x,
                cy: center.y,
            },
        }
    }

    /// Pixels that a height of 1 is high: as given, else a unit in floats, and a share of the picture in integers.
    fn height_scale(&self, source: Option<&RoleSource>, warnings: &mut Vec<String>) -> f32 {
        self.inputs.height_scale.unwrap_or_else(|| {
            let is_whole = source.and_then(RoleSource::photo).is_some_and(|photo| !photo.header.is_float);
            let window = self.display_window;
            let scale = match is_whole {
                true => HIGH * window.width().max(window.height()) as f32,
                false => 1.0,
            };
            warnings.push(format!(
                "how high heights are is not known: 1 is taken for {scale} pixels; give --height-scale PIXELS"
            ));
            scale
        })
    }
}

/// The quantity that a layer of depth holds, and why: what its name or the renderer implies, else distances where they
/// exceed 1. From 0 to 1 white is taken for near, as estimators of depth write it, which is a guess and said to be.
fn judged(
    depth: &Plane,
    (hint, by): (Hint, String),
    warnings: &mut Vec<String>,
) -> (StoredDepth, String) {
    if let Some(stored) = hint.depth {
        return (stored, by);
    }
    let mut distances = depth.samples().iter().filter(|d| is_distance(d.abs()));
    let is_unit = distances.all(|d| (0.0..=1.0 + ABOVE_ONE).contains(d));
    if !is_unit {
        return (StoredDepth::Planar, "its values exceed 1".into());
    }
    warnings.push(
        "depth runs from 0 to 1, and nothing says which is near: white is taken for near, and bumps would be hollows if it \
         is not; compare with --depth-kind white-far, or z for distances"
            .into(),
    );
    let kind = StoredDepth::NormalizedNearIsOne;
    (kind, "from 0 to 1, as estimators write it".into())
}
