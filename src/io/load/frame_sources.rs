//! The layers of a frame: their sources, and the planes read from them.

#[cfg(feature = "cli")]
use super::bundle::gathered;
use super::light_layers::LightSources;
use super::objects::refuse_numbers;
use super::opened::Opened;
use super::role_planes::RolePlanes;
use super::sources::{RoleSource, missing, read_all, read_rows};
use crate::error::{Error, Result};
use crate::frame::coverage::shares;
use crate::frame::{Plane, Vector3Planes, Window};
use crate::io::colorspace::ColorSpace;
use crate::io::inputs::{Inputs, Needs, StoredDepth};
use crate::io::judge::borders::Borders;
#[cfg(feature = "cli")]
use crate::io::motion::means_motion;
use crate::io::motion::{MotionLayers, motion_sources};
use crate::io::roles::Role;
use crate::untrusted::shown;
use std::rc::Rc;

/// Silhouettes use one map: an occlusion map named explicitly makes depth unnecessary.
pub(crate) fn only_occlusion(inputs: &Inputs) -> bool {
    let occlusion = inputs.occlusion.as_deref();
    occlusion.is_some_and(|name| name != Inputs::NONE) && inputs.depth.is_none()
}

/// The sources of all roles that this run reads.
pub(crate) struct FrameSources {
    /// Normals first, where there are any.
    pub(crate) roles: Vec<RoleSource>,
}

impl FrameSources {
    pub(crate) fn resolve(
        inputs: &Inputs,
        main: &Rc<Opened>,
        needs: Needs,
        with_light: bool,
    ) -> Result<Self> {
        let find = |role, name: &Option<String>| RoleSource::resolve(role, name.as_deref(), main);
        let map = match inputs.normal {
            None => RoleSource::normal_map(main).or_else(|| {
                let is_alone = needs.map && inputs.depth.is_none() && inputs.position.is_none();
                let is_map = is_alone && main.photo().is_some();
                is_map.then(|| RoleSource::of(Role::Normal, main, None, None))
            }),
            Some(_) => None,
        };
        let is_map = map.is_some();
        let are_heights = inputs.depth_kind == Some(StoredDepth::Height);
        let normal = match map {
            _ if are_heights => None,
            Some(map) => Some(map),
            None => find(Role::Normal, &inputs.normal)?,
        };
        let has_normals = normal.is_some();
        let mut roles = Vec::from_iter(normal.map(|normal| normal.described(inputs)));
        let depth = if only_occlusion(inputs) {
            None
        } else {
            find(Role::Depth, &inputs.depth)?
        };
        if depth.is_none() {
            roles.extend(find(Role::Occlusion, &inputs.occlusion)?);
        }
        roles.extend(depth);
        if inputs.camera.is_none() || roles.iter().all(|s| s.role != Role::Depth) {
            roles.extend(find(Role::Position, &inputs.position)?);
        }
        let shows_surface =
            |source: &RoleSource| matches!(source.role, Role::Depth | Role::Position);
        if !has_normals && !roles.iter().any(shows_surface) {
            return Err(missing_normals(main));
        }
        // A normal map is no picture.
        let color = match &inputs.color {
            None if is_map => None,
            color => find(Role::Color, color)?,
        };
        let color = color.filter(|color| inputs.color.is_some() || !color.is_layer_of(&roles[0]));
        // Nor are heights or depth the colours of what is lit, though they can be enhanced.
        let is_depth = |source: &RoleSource| source.role == Role::Depth && source.is_photo_of(main);
        let is_only_depth = inputs.color.is_none() && !needs.color && roles.iter().any(is_depth);
        let color = color.filter(|_| !is_only_depth);
        if needs.color && color.is_none() {
            return Err(match is_map {
                true => Error::MissingAov {
                    path: main.path().to_path_buf(),
                    found: "is a normal map, and there is no picture".into(),
                    remedy: "name it with --color FILE".into(),
                },
                false => missing(main, Role::Color, "--color LAYER or --color FILE"),
            });
        }
        // If depth does not show coverage, alpha does, so the picture is read for it. Light is compared with the
        // picture too.
        let depth = roles.iter().find(|s| s.role == Role::Depth);
        let implied = depth.and_then(|source| source.hint().0.depth);
        let uncovering = inputs
            .depth_kind
            .or(implied)
            .is_some_and(|d| !d.shows_coverage());
        let with_color = needs.color || needs.color_if_any || with_light || uncovering;
        if with_color || roles.iter().all(|s| s.role != Role::Depth) {
            roles.extend(color);
        }
        if needs.albedo {
            let albedo = find(Role::Albedo, &inputs.albedo)?;
            roles.extend(albedo.or_else(|| RoleSource::by_role(Role::DiffuseColor, main)));
        }
        if let Some(name) = &inputs.mask {
            refuse_numbers(name, main)?;
        }
        for (role, name) in inputs.only_named() {
            roles.extend(RoleSource::resolve(role, Some(name), main)?);
        }
        if needs.motion {
            roles.extend(motion_sources(inputs.motion.as_deref(), main)?);
        }
        // The bare channels Z and A may be depth and the coverage of the picture: of depth it is not read.
        let data = roles.iter_mut().filter(|source| !source.role.is_color());
        data.for_each(RoleSource::leave_alpha);
        Ok(Self { roles })
    }

    /// The window of the frame: that of the picture, if one is read, else that of the normals.
    ///
    /// # Errors
    /// [`Error::SizeMismatch`] if other windows cannot be adapted to it: those of photos, and of files made for other
    /// display windows. [`Error::Unsupported`] for normals that may have been made before the picture was rotated.
    pub(crate) fn common_window(&self, light: &LightSources) -> Result<Window> {
        let expected = self.get(Role::Color).unwrap_or(&self.roles[0]);
        let window = expected.window();
        if let Some(normal) = self.get(Role::Normal) {
            refuse_unlike_orientations(normal, expected)?;
        }
        for source in self.roles.iter().chain(&light.sources) {
            let overlaps = source.display() == expected.display()
                && source.window().common(&window).is_some()
                && [source, expected].iter().all(|source| source.is_exr());
            if source.window() != window && !overlaps {
                return Err(Error::SizeMismatch {
                    path: source.file.path().to_path_buf(),
                    found: format!("{} ({})", source.window(), source.label()),
                    expected: format!("{} has {window}", expected.label()),
                });
            }
        }
        Ok(window)
    }

    /// Reads the roles and the light layers, each file once. With `part`, only its rows are decoded.
    pub(crate) fn read(
        &self,
        light: &LightSources,
        window: Window,
        part: Option<Window>,
        colorspace: Option<ColorSpace>,
    ) -> Result<(ReadPlanes, Vec<RolePlanes>)> {
        let all: Vec<_> = self.roles.iter().chain(&light.sources).cloned().collect();
        let rows = part.map(|part| part.y0..part.y1);
        let mut read = read_rows(&all, rows, colorspace)?;
        for (source, read) in all.iter().zip(&mut read) {
            read.fit_to(source.role, window);
        }
        let light = read.split_off(self.roles.len());
        Ok((ReadPlanes::of(&self.roles, read), light))
    }

    /// Colour space of the picture by its `colorInteropID`.
    pub(crate) fn interop_space(&self) -> Option<ColorSpace> {
        ColorSpace::of_interop_id(self.get(Role::Color)?.interop_id()?)
    }

    /// The candidates for motion among the layers read.
    pub(crate) fn motion(
        &self,
        planes: &mut ReadPlanes,
        inputs: &Inputs,
        display: Window,
    ) -> Option<MotionLayers> {
        let sources = self.roles.iter().filter(|s| s.role == Role::Motion);
        let read = planes.motion().into_iter();
        MotionLayers::of(sources, read, inputs.motion.is_some(), display)
    }

    pub(crate) fn get(&self, role: Role) -> Option<&RoleSource> {
        self.roles.iter().find(|s| s.role == role)
    }
}

/// The error of a picture without anything that shows its surface.
pub(crate) fn missing_normals(main: &Opened) -> Error {
    let flags = "--normal LAYER or --normal FILE, or depth with --depth LAYER|FILE";
    missing(main, Role::Normal, flags)
}

/// Refuses normals whose orientation may differ from the picture's: those without the orientation tag of a photo that
/// has one, at its stored size; and those with a tag of their own, whose vectors would have to be rotated.
fn refuse_unlike_orientations(normal: &RoleSource, picture: &RoleSource) -> Result<()> {
    let orientation = |source: &RoleSource| source.file.photo()?.header.turned_from();
    let [width, height] = [normal.window().width(), normal.window().height()];
    let found = match (orientation(normal), orientation(picture)) {
        (Some((_, number)), _) => format!("has orientation {number}, and normals are not turned"),
        (None, Some((stored, number))) if stored == [width, height] => format!(
            "is {width}x{height} and has no orientation, but {} is stored as {}x{} with orientation {number}, upright {}x{}: \
             which way these normals go is not known",
            shown(picture.file.path()),
            stored[0],
            stored[1],
            picture.window().width(),
            picture.window().height(),
        ),
        _ => return Ok(()),
    };
    Err(Error::Unsupported {
        path: normal.file.path().to_path_buf(),
        found,
        remedy: "save both upright, their pixels turned and without orientation".into(),
    })
}

/// The planes as read, taken out role by role.
pub(crate) struct ReadPlanes {
    roles: Vec<(Role, RolePlanes)>,
    /// Warnings about replaced values.
    pub(crate) warnings: Vec<String>,
}

impl ReadPlanes {
    /// Reads all of the `sources`.
    pub(crate) fn read(sources: &[RoleSource]) -> Result<Self> {
        Ok(Self::of(sources, read_all(sources)?))
    }

    fn of(sources: &[RoleSource], read: Vec<RolePlanes>) -> Self {
        let roles = sources.iter().map(|source| source.role);
        Self {
            roles: roles.zip(read).collect(),
            warnings: Vec::new(),
        }
    }

    pub(crate) fn take(&mut self, role: Role) -> Option<RolePlanes> {
        let index = self.roles.iter().position(|(r, _)| *r == role)?;
        Some(self.roles.remove(index).1)
    }

    fn get(&self, role: Role) -> Option<&RolePlanes> {
        let (_, read) = self.roles.iter().find(|(own, _)| *own == role)?;
        Some(read)
    }

    pub(crate) fn vector(&mut self, role: Role) -> Option<Vector3Planes> {
        self.take(role).map(RolePlanes::into_vector)
    }

    /// Coverage stored with a role.
    pub(crate) fn alpha(&self, role: Role) -> Option<&Plane> {
        self.get(role)?.alpha.as_ref()
    }

    /// The same, taken out.
    pub(crate) fn take_alpha(&mut self, role: Role) -> Option<Plane> {
        let (_, read) = self.roles.iter_mut().find(|(own, _)| *own == role)?;
        read.alpha.take()
    }

    /// The borders of normals that were stored in coarse codes.
    pub(crate) fn borders(&self) -> Option<Borders> {
        self.get(Role::Normal)?.borders
    }

    pub(crate) fn scalar(&mut self, role: Role) -> Option<Plane> {
        self.take(role).map(RolePlanes::into_scalar)
    }

    /// All candidates for motion, in the order of their sources.
    pub(crate) fn motion(&mut self) -> Vec<Vec<Plane>> {
        let taken = std::iter::from_fn(|| self.take(Role::Motion));
        taken.map(|read| read.planes).collect()
    }

    /// A picture and its coverage, without samples that are not finite.
    pub(crate) fn color(&mut self, role: Role) -> (Option<RolePlanes>, Option<Plane>) {
        let Some(mut read) = self.take(role) else {
            return (None, None);
        };
        let replaced = read.sanitise();
        let alpha = read.alpha.take().map(shares);
        if replaced > 0 {
            self.warnings.push(format!(
                "{replaced} colour samples were not finite: NaN became 0, infinity 65504"
            ));
        }
        (Some(read), alpha)
    }
}

/// Names of the layers that may hold motion of the frame that `inputs` describe, without reading a pixel, and whether they
/// mean motion.
///
/// # Errors
/// Any [`crate::Error`] of reading a header.
#[cfg(feature = "cli")]
pub(crate) fn motion_layer_names(inputs: &Inputs) -> Result<(Vec<String>, bool)> {
    let (inputs, _) = gathered(inputs)?;
    let main = Opened::open_picture(&inputs, Default::default())?;
    let needs = Needs {
        motion: true,
        ..Needs::default()
    };
    let sources = FrameSources::resolve(&inputs, &main, needs, false)?;
    let roles = sources.roles.iter();
    let motion: Vec<_> = roles.filter(|s| s.role == Role::Motion).collect();
    let mean_motion = inputs.motion.is_some() || motion.iter().any(|source| means_motion(source));
    let mut names: Vec<_> = motion
        .iter()
        .map(|source| source.label().to_string())
        .collect();
    names.dedup();
    Ok((names, mean_motion))
}
