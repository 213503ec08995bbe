//! Frames without normals: those of the surface that their depth, heights or positions show.

use super::depth_sense::ABOVE_ONE;
use super::frame_sources::missing_normals;
use super::sources::RoleSource;
use super::view::FoundView;
use crate::error::{Result, bad};
use crate::frame::coverage::{self, Covered};
use crate::frame::depth::{depth_of_positions, is_distance};
use crate::frame::from_depth::{Precision, normals_of_depth};
use crate::frame::{
    Camera, Mask, Plane, Projection, StoredDepth, Vector3Planes, Window, likely_projection,
};
use crate::io::finding::Notes;
use crate::io::load::{FrameLayers, SourceRegion, ViewSurface};
use crate::io::roles::Role;
use glam::DAffine3;
use std::time::Instant;

/// The height of white over the longer side of a picture of heights, where it is not known.
const HIGH: f32 = 0.1;

impl SourceRegion<'_> {
    /// The surface that depth shows, or positions in its place, where there are no normals.
    pub(crate) fn surface_of_depth(
        &self,
        layers: &mut FrameLayers,
        notes: &mut Notes,
    ) -> Result<ViewSurface> {
        let depth_is_half = self.depth_is_half(layers);
        let all = Mask::full(self.data_window.width(), self.data_window.height());
        let mut view = FoundView::of_camera(self.inputs, &self.surface(&all, layers, None), notes)?;
        let source = self.sources.get(Role::Depth);
        let known = match (&layers.depth, view.camera) {
            (Some(_), _) => {
                let (hint, by) = source.map(RoleSource::hint).unwrap_or_default();
                let given = self.inputs.depth_kind.map(|kind| (kind, "as given".into()));
                given.or_else(|| Some((hint.depth?, by)))
            }
            (None, Some(camera)) => {
                layers.depth = self
                    .positions_for_depth(layers)
                    .map(|p| depth_of_positions(p, &camera));
                Some((StoredDepth::Planar, "of positions".into()))
            }
            (None, None) => None,
        };
        let Some(depth) = layers.depth.as_mut() else {
            return Err(missing_normals(self.main));
        };
        let alone = DepthAlone {
            depth: &mut *depth,
            known,
            is_half: depth_is_half,
            is_layer: source.is_some_and(|source| source.file.exr().is_some()),
            rounding: source.map_or(0.0, RoleSource::rounding),
            height_scale: self.inputs.height_scale,
            height_unit_px: self.inputs.height_unit_px,
            camera: view.camera,
            data_window: self.data_window,
            display_window: self.display_window,
            pixel_aspect: self.pixel_aspect,
        };
        let start = Instant::now();
        let shown = alone.surface(layers.alpha.as_ref(), &mut notes.warnings)?;
        let took = start.elapsed();
        view.camera = shown.camera;
        let (from, bits) = match source {
            Some(source) if shown.stored == StoredDepth::Height => ("heights", source.precision()),
            Some(source) => ("depth", source.precision()),
            None => ("positions", String::new()),
        };
        let bits = match shown.precision {
            Precision::Codes(_) if bits.is_empty() => " (whole numbers)".into(),
            Precision::Half if bits.is_empty() => " (as coarse as half floats)".into(),
            _ => bits,
        };
        let open = match shown.stored {
            StoredDepth::NormalizedNearIsOne | StoredDepth::WhiteFar | StoredDepth::Relative => {
                " (shape up to a projective change: signs and creases hold, slopes do not)"
            }
            _ => "",
        };
        notes.warnings.push(format!(
            "normals from {from}{bits}{open}: no layer holds any; --normal names one"
        ));
        let mut normal = shown.normal;
        let stored_depth = Some((depth, Some(shown.stored)));
        let (alpha, covered) = (layers.alpha.as_ref(), layers.coverage.as_ref());
        let Covered { mask, lengths, .. } =
            coverage::cover(&mut normal, stored_depth, alpha, covered);
        notes.on_coverage(&mask);
        Ok(ViewSurface {
            normal,
            mask,
            lengths,
            sense: Some((shown.stored, shown.why)),
            depth_is_half,
            view,
            made: Some(took),
        })
    }
}

/// Depth in the place of normals, as it was stored.
pub(crate) struct DepthAlone<'a> {
    /// Its samples. Heights are scaled to pixels.
    pub(crate) depth: &'a mut Plane,
    /// What it holds, and how that is known.
    pub(crate) known: Option<(StoredDepth, String)>,
    pub(crate) is_half: bool,
    /// Whether it is a layer, as renderers write it.
    pub(crate) is_layer: bool,
    /// The distance of integers, the largest of which is 1; of no account for half floats, and 0 for floats.
    pub(crate) rounding: f32,
    /// Pixels that a height of 1 is high, where it is known.
    pub(crate) height_scale: Option<f32>,
    /// Pixels that a unit of heights in floats is high otherwise.
    pub(crate) height_unit_px: Option<f32>,
    pub(crate) camera: Option<Camera>,
    pub(crate) data_window: Window,
    pub(crate) display_window: Window,
    pub(crate) pixel_aspect: f32,
}

/// The surface that depth shows, and how depth was read.
pub(crate) struct ShownByDepth {
    /// Unit normals in view space, 0 where none are found.
    pub(crate) normal: Vector3Planes,
    pub(crate) stored: StoredDepth,
    /// Why it was read so.
    pub(crate) why: String,
    precision: Precision,
    /// The camera: as given, or that of heights.
    pub(crate) camera: Option<Camera>,
}

impl DepthAlone<'_> {
    /// The surface. What has to be guessed is warned of. Alpha tells where depth shows it that marks no coverage itself.
    pub(crate) fn surface(
        mut self,
        alpha: Option<&Plane>,
        warnings: &mut Vec<String>,
    ) -> Result<ShownByDepth> {
        let known = self.known.take();
        let mut precision = Precision::stored(self.is_half, self.rounding, self.depth);
        let (stored, mut why) =
            known.unwrap_or_else(|| judged(self.depth, self.is_layer, warnings));
        if stored == StoredDepth::Height {
            let scale = self.height_scale(warnings)?;
            let depth = &mut *self.depth;
            depth.each_row(|_, row| row.iter_mut().for_each(|h| *h *= scale));
            precision = precision.times(scale);
            self.camera = Some(self.camera_above());
            why = format!("{scale} pixels high at 1");
        }
        let projection = self.camera.map_or_else(
            || {
                warnings.push(
                    "the camera is not known: slopes are those of a view 44 degrees across; compare with --camera FILE"
                        .into(),
                );
                likely_projection(self.display_window, self.pixel_aspect)
            },
            |camera| camera.projection,
        );
        let alpha = alpha.filter(|_| !stored.shows_coverage());
        let normal = normals_of_depth(
            self.depth,
            stored,
            (projection, self.data_window),
            |x, y| alpha.is_none_or(|alpha| alpha.at(x, y) > 0.5),
            precision,
        );
        Ok(ShownByDepth {
            normal,
            stored,
            why,
            precision,
            camera: self.camera,
        })
    }

    /// The camera of heights: a unit is a pixel.
    fn camera_above(&self) -> Camera {
        let per_unit = [1.0, self.pixel_aspect.into()];
        Camera {
            view_from_world: DAffine3::IDENTITY,
            projection: Projection::new(true, per_unit, self.display_window.center()),
        }
    }

    /// Pixels that a height of 1 is high: as given, else a unit in floats, and a share of the picture in integers.
    fn height_scale(&self, warnings: &mut Vec<String>) -> Result<f32> {
        if let Some(scale) = self.height_scale {
            return match scale.is_finite() {
                true => Ok(scale),
                false => Err(bad("--height-scale", format!("is {scale}"), "give pixels")),
            };
        }
        let window = self.display_window;
        let are_integers = self.rounding > 0.0 && !self.is_half;
        if let Some(scale) = self.height_unit_px.filter(|_| !are_integers) {
            return Ok(scale);
        }
        let scale = match are_integers {
            true => HIGH * window.width().max(window.height()) as f32,
            false => 1.0,
        };
        warnings.push(format!(
            "how high heights are is not known: 1 is taken for {scale} pixels; give --height-scale PIXELS"
        ));
        Ok(scale)
    }
}

/// The quantity that depth of unknown kind holds, and why: distances where they exceed 1, as nearly all layers do. From 0
/// to 1 white is taken for near, as estimators of depth write it. What is a guess is said to be.
fn judged(depth: &Plane, is_layer: bool, warnings: &mut Vec<String>) -> (StoredDepth, String) {
    let mut distances = depth.samples().iter().filter(|d| is_distance(d.abs()));
    let is_unit = distances.all(|d| (0.0..=1.0 + ABOVE_ONE).contains(d));
    if !is_unit {
        if !is_layer {
            warnings.push(
                "depth exceeds 1, and nothing says whether it is distance: bumps would be hollows if it is disparity, 1/z; \
                 compare with --depth-kind inverse"
                    .into(),
            );
        }
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
