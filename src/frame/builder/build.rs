//! Decodes, transforms and sanitises the samples given to a builder.

use super::FrameBuilder;
use super::light::{colors, colors_of};
use super::samples::{Name, Samples};
use crate::error::{Result, bad};
use crate::frame::coverage::{self, Covered, cover};
use crate::frame::depth::depth_rounding;
use crate::frame::{
    Camera, ColorPlanes, DepthKind, Frame, NormalEncoding, Plane, Source, Window, confidence,
    lift_out_of_fog, normals, unround,
};
use glam::DMat3;
use std::ops::RangeInclusive;

/// Range of the pixel aspect ratio, width over height.
pub(crate) const PIXEL_ASPECTS: RangeInclusive<f32> = 0.001..=1000.0;

/// Largest deviation of a camera's axes from unit length and right angles.
const AXES_ERROR: f64 = 1e-4;

impl FrameBuilder<'_> {
    /// Copies the samples into a frame: normals decoded, normalised and in view space, depth a distance that increases
    /// away from the viewer, both 0 where no surface was seen; colour without NaN or infinities.
    ///
    /// # Errors
    /// [`Error::BadParameter`](crate::Error::BadParameter), with the name of the argument, for samples that do not
    /// match the size or have the wrong number of channels, and for numbers outside their range; also without normals,
    /// for positions without a camera, and for two cameras that differ.
    pub fn build(self) -> Result<Frame> {
        let (data_window, display_window) = self.windows()?;
        let camera = self.known_camera(display_window)?;
        let Some(stored) = &self.normals else {
            let remedy = "give them with normals()";
            return Err(bad("normals", "are missing", remedy));
        };
        let mut normal = stored.samples.vectors("normals", self.size)?;
        if stored.samples.is_coarse() {
            // As stored they range from 0 to 1.
            unround(&mut normal, 0.5 * stored.samples.rounding);
        }
        normals::decode(&mut normal, stored.encoding, stored.flip);
        let (color, alpha) = self.picture()?;
        let mut depth = self.scalar("depth")?;
        let own_mask = self.scalar("mask")?;
        let Covered {
            mut mask, lengths, ..
        } = cover(
            &mut normal,
            depth.as_mut().map(|depth| (depth, self.stored_depth)),
            alpha.as_ref(),
            own_mask.as_ref(),
        );
        if let Some(camera) = &camera {
            normals::turn_to_view(&mut normal, stored.space, camera, data_window);
        }
        let position = self.layers.get("position");
        if let (None, Some(position)) = (&depth, position) {
            let Some(camera) = &camera else {
                let found = "is in world space, and there is no camera";
                let remedy = "give one with camera(), or depth instead";
                return Err(bad("position", found, remedy));
            };
            let mut made = position.depths(self.size, camera)?;
            coverage::narrow_to(&mut mask, &mut made);
            depth = Some(made);
        }
        let of_depth = self.layers.get("depth").or(position);
        let is_half = of_depth.is_some_and(Samples::is_half);
        // Silhouettes follow depth where there is any.
        let shown = alpha.as_ref().filter(|_| depth.is_none());
        let occlusion = self.scalar("occlusion")?;
        let occlusion = occlusion.or_else(|| coverage::varying(shown));
        let mut frame = Frame {
            display_window,
            data_window,
            pixel_aspect: self.pixel_aspect,
            normal_length: (stored.encoding == NormalEncoding::Signed).then_some(lengths),
            depth,
            occlusion,
            importance: self.scalar("importance")?,
            albedo: self.colors("albedo")?,
            light: self.light_layers()?,
            camera,
            color,
            alpha,
            source: Source {
                depth_kind: match self.stored_depth {
                    Some(stored) => stored.kind_of(is_half),
                    None if is_half => DepthKind::Relative,
                    None => DepthKind::Planar,
                },
                normal_rounding: stored.samples.rounding,
                depth_rounding: of_depth.map_or([0.0; 2], |samples| {
                    depth_rounding(is_half, samples.rounding)
                }),
                luminance_weights: self.checked_weights()?,
                ..Source::default()
            },
            ..Frame::of_normals(normal, mask)
        };
        frame.confidence = self.finds_confidence.then(|| confidence(&frame)).flatten();
        if let Some(lengths) = &mut frame.normal_length {
            lift_out_of_fog(lengths, &frame.mask);
        }
        Ok(frame)
    }

    /// Data window and display window.
    fn windows(&self) -> Result<(Window, Window)> {
        let [width, height] = self.size;
        let fits = |length: usize, from: i32| {
            length > 0 && length as i128 + i128::from(from) <= i128::from(i32::MAX)
        };
        let [x, y] = self.origin;
        if !(fits(width, x) && fits(height, y)) {
            let found = format!("of {width}x{height} pixels from ({x}, {y}) cannot be");
            let remedy = "give at least one pixel, and coordinates below 2^31";
            return Err(bad("a frame", found, remedy));
        }
        let data = Window::at(x, y, width, height);
        let display = self.display_window.unwrap_or(data);
        if display.width() == 0 || display.height() == 0 {
            let remedy = "give one that is at least a pixel wide and high";
            return Err(bad("display_window", format!("is {display}"), remedy));
        }
        if !PIXEL_ASPECTS.contains(&self.pixel_aspect) {
            let found = format!("is {:e}", self.pixel_aspect);
            return Err(bad("pixel_aspect", found, "give 0.001 to 1000"));
        }
        Ok((data, display))
    }

    /// The camera, from either argument that can give it.
    fn known_camera(&self, display: Window) -> Result<Option<Camera>> {
        let with_normals = self.normals.as_ref().and_then(|normals| normals.camera);
        if let (Some(own), Some(other)) = (self.camera, with_normals)
            && own != other
        {
            let found = "is another than that of the normals";
            return Err(bad("camera", found, "give one of them"));
        }
        let Some(camera) = self.camera.or(with_normals) else {
            return Ok(None);
        };
        camera
            .check(display)
            .map_err(|number| bad("camera", cannot(&number.found()), number.remedy()))?;
        let axes = camera.view_from_world.matrix3;
        let error = (axes.transpose() * axes - DMat3::IDENTITY).to_cols_array();
        let is_rigid = error.iter().all(|e| e.abs() <= AXES_ERROR);
        if !is_rigid {
            let found = cannot("its axes are not of unit length and square to each other");
            let remedy = "give a rotation and a translation without scale or shear";
            return Err(bad("camera", found, remedy));
        }
        Ok(Some(camera))
    }

    fn picture(&self) -> Result<(Option<ColorPlanes>, Option<Plane>)> {
        let own_alpha = self.scalar("alpha")?;
        let Some(samples) = self.layers.get("color") else {
            return Ok((None, own_alpha.map(coverage::shares)));
        };
        samples.refuse_integers("color")?;
        let mut planes = samples.planes("color", self.size, &[1, 3, 4])?;
        let with_color = (planes.len() == 4).then(|| planes.remove(3));
        let alpha = own_alpha.or(with_color).map(coverage::shares);
        Ok((Some(colors_of(planes)), alpha))
    }

    fn checked_weights(&self) -> Result<Option<[f32; 3]>> {
        let Some(weights) = self.luminance_weights else {
            return Ok(None);
        };
        let sum: f32 = weights.iter().sum();
        match weights.iter().all(|w| *w >= 0.0) && (sum - 1.0).abs() < 1e-3 {
            true => Ok(Some(weights)),
            false => {
                let found = format!("are {weights:?}");
                let remedy = "give three that are not negative and add up to 1";
                Err(bad("luminance_weights", found, remedy))
            }
        }
    }

    /// The only plane of a layer, if it is given.
    pub(super) fn scalar(&self, name: Name) -> Result<Option<Plane>> {
        let samples = self.layers.get(name);
        samples.map(|s| s.plane(name, self.size)).transpose()
    }

    /// A layer of linear colour, if it is given.
    fn colors(&self, name: Name) -> Result<Option<ColorPlanes>> {
        let samples = self.layers.get(name);
        samples.map(|s| colors(name, s, self.size)).transpose()
    }
}

fn cannot(why: &str) -> String {
    format!("cannot be used: {why}")
}
