//! Reading the scene seen in mirrors and through lenses: the frame's own specular pixels, back faces, objects behind,
//! the surroundings, and, from renderers that write them, the hit points of bent sight lines.

use super::frame_sources::ReadPlanes;
use super::opened::Opened;
use super::role_planes::RolePlanes;
use super::sources::{RoleSource, missing, read_all};
use super::surroundings::read_surroundings;
use crate::error::{Error, Result, bad};
use crate::frame::coverage::{self, Covered};
use crate::frame::depth::{depth_of_positions, to_distances};
use crate::frame::from_depth::{Precision, normals_of_depth};
use crate::frame::normals::{decode, turn_to_view};
use crate::frame::{
    Camera, DepthKind, Frame, Mask, Plane, Source, SpecularScene, StoredDepth, Surroundings,
    Vector3Planes, Window,
};
use crate::io::judge::normal_encoding::judge_encoding;
use crate::io::load::Loaded;
use crate::io::roles::Role;
use crate::params::table::rows;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

rows! {
    /// The files and layers that mirrors and lenses show.
    #[derive(Debug, Clone, Default, PartialEq)]
    #[cfg_attr(feature = "cli", command(next_help_heading = "Mirrors and lenses"))]
    pub struct SpecularInputs {
        /// Pixels of mirrors or lenses, above one half: a layer of IN or a file; all covered pixels if not given.
        pub mask: Option<String> =
            [id = "specular_mask", long = "specular-mask", value_name = "NAME|FILE", hide_short_help = true];
        /// Back faces of a lens, normals and depth from the same camera: sight lines are refracted twice, by --ior.
        pub back: Option<PathBuf> = [long, value_name = "FILE", hide_short_help = true];
        /// The scene without its mirrors and lenses, from the same camera: depth, and normals and colour if any.
        pub behind: Option<PathBuf> = [long, value_name = "FILE", hide_short_help = true];
        /// The view in all directions around the mirror or lens, equirectangular: positions (or distances), and normals and
        /// colour if any.
        pub surroundings: Option<PathBuf> = [long, value_name = "FILE", hide_short_help = true];
        /// Viewpoint of surroundings without positions: a camera file with world_to_camera.
        pub surroundings_camera: Option<PathBuf> = [long, value_name = "FILE", hide_short_help = true];
        /// World-space points hit by mirrored or refracted sight lines, if the renderer writes them: a layer of IN or a
        /// file. No search is made then.
        pub hit_position: Option<String> = [long, value_name = "NAME|FILE", hide_short_help = true];
    }
}

impl SpecularInputs {
    /// Whether there is nothing to read.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Reads `inputs`, to go with the frame that was `loaded`. Surroundings `known` from an earlier frame are not read
/// again.
///
/// # Errors
/// Any [`Error`] of reading; [`Error::BadParameter`] for inputs that lack one another;
/// [`Error::Undetermined`] if the frame's camera or its position is unknown.
pub fn load_specular(
    inputs: &SpecularInputs,
    loaded: &Loaded,
    known: Option<Arc<Surroundings>>,
) -> Result<SpecularScene> {
    refuse_what_lacks(inputs)?;
    let frame = &loaded.frame;
    let path = loaded.main.path();
    let Some(camera) = frame.camera else {
        return Err(Error::Undetermined {
            path: path.into(),
            found: "has no camera, and mirrors and lenses bend sight lines".into(),
            remedy: "give --camera FILE".into(),
        });
    };
    if frame.depth.is_none() || frame.source.depth_kind == DepthKind::Relative {
        return Err(Error::MissingAov {
            path: path.into(),
            found: "has no depth that is a distance, and mirrors and lenses have to be somewhere"
                .into(),
            remedy: "name one with --depth or --position".into(),
        });
    }
    let world = || match loaded.camera_is_placed {
        true => Ok(camera),
        false => Err(Error::Undetermined {
            path: path.into(),
            found: "tells how its camera is turned, but not where in the world it stands".into(),
            remedy: "give --camera FILE, or a layer of positions with --position".into(),
        }),
    };
    let layer = |path: &Path| {
        SpecularFile {
            path,
            loaded,
            camera,
        }
        .read()
    };
    let surroundings = inputs.surroundings.as_ref().map(|path| {
        world()?;
        if let Some(known) = &known {
            return Ok(known.clone());
        }
        read_surroundings(path, inputs.surroundings_camera.as_deref()).map(Arc::new)
    });
    let hit_position = inputs.hit_position.as_ref().map(|name| {
        let position = named(Role::HitPosition, name, loaded)?.into_vector();
        Ok::<_, Error>(in_view(&position, &world()?))
    });
    Ok(SpecularScene {
        mask: inputs
            .mask
            .as_ref()
            .map(|name| specular_mask(name, loaded))
            .transpose()?,
        back: inputs.back.as_deref().map(layer).transpose()?,
        behind: inputs.behind.as_deref().map(layer).transpose()?,
        surroundings: surroundings.transpose()?,
        hit_position: hit_position.transpose()?,
    })
}

fn refuse_what_lacks(inputs: &SpecularInputs) -> Result<()> {
    let shows =
        inputs.behind.is_some() || inputs.surroundings.is_some() || inputs.hit_position.is_some();
    let around = "give --surroundings FILE, --behind FILE or --hit-position LAYER";
    if inputs.mask.is_some() && !shows {
        return Err(bad(
            "--specular-mask",
            "names mirrors, but nothing for them to show",
            around,
        ));
    }
    if inputs.back.is_some() && !shows {
        return Err(bad(
            "--back",
            "bends sight lines, but there is nothing for them to meet",
            around,
        ));
    }
    if inputs.surroundings_camera.is_some() && inputs.surroundings.is_none() {
        return Err(bad(
            "--surroundings-camera",
            "tells where a map was seen from, and there is none",
            "give --surroundings FILE",
        ));
    }
    Ok(())
}

/// The planes that the user named for a role, over the frame's own pixels.
fn named(role: Role, name: &str, loaded: &Loaded) -> Result<RolePlanes> {
    let source = RoleSource::resolve(role, Some(name), &loaded.main)?
        .expect("a source that is named is there or an error");
    let window = loaded.frame.data_window;
    if source.window() != window {
        return Err(Error::SizeMismatch {
            path: source.file.path().to_path_buf(),
            found: format!("{} ({})", source.window(), source.label()),
            expected: format!("the normals are {window}"),
        });
    }
    Ok(read_all(&[source])?.remove(0))
}

fn specular_mask(name: &str, loaded: &Loaded) -> Result<Mask> {
    let plane = named(Role::SpecularMask, name, loaded)?.into_scalar();
    Ok(Mask::new(plane.map(|share| share > 0.5)))
}

/// Converts world-space points to view space; missing ones, 0 or not finite, become NaN.
fn in_view(position: &Vector3Planes, camera: &Camera) -> Vector3Planes {
    let (width, height) = (position.x.width(), position.x.height());
    Vector3Planes::from_fn(width, height, |x, y| match position.at(x, y) {
        DVec3::ZERO => DVec3::NAN,
        world => camera.view_from_world.transform_point3(world),
    })
}

/// A file that the frame's camera saw too.
struct SpecularFile<'a> {
    path: &'a Path,
    loaded: &'a Loaded,
    camera: Camera,
}

impl SpecularFile<'_> {
    fn read(&self) -> Result<Frame> {
        let file = self.loaded.main.open_companion(self.path)?;
        let find = |role| RoleSource::by_role(role, &file);
        let position = || find(Role::Position).filter(|_| self.loaded.camera_is_placed);
        let place = find(Role::Depth).or_else(position);
        let place = place.ok_or_else(|| missing(&file, Role::Depth, "another file"))?;
        let sources = [Some(place), find(Role::Normal), find(Role::Color)];
        let sources: Vec<_> = sources.into_iter().flatten().collect();
        let data_window = self.common_window(&file, &sources)?;
        let mut planes = ReadPlanes::read(&sources)?;
        let positions = planes.vector(Role::Position);
        let depth = planes
            .scalar(Role::Depth)
            .map(|depth| self.distances(depth));
        let depth = depth.or_else(|| Some(depth_of_positions(&positions?, &self.camera)));
        let mut depth = depth.expect("a source of either is there");
        let normal = planes.vector(Role::Normal);
        let (color, alpha) = planes.color(Role::Color);
        let kind = self.loaded.frame.source.depth_kind;
        let (mask, normal) = match normal {
            Some(normal) => self.with_normals(normal, &mut depth, data_window),
            None => self.without_normals(&mut depth, data_window),
        };
        let (display_window, pixel_aspect) = file.shown(data_window);
        Ok(Frame {
            data_window,
            display_window,
            pixel_aspect,
            depth: Some(depth),
            color: color.map(RolePlanes::into_color),
            alpha,
            camera: Some(self.camera),
            source: Source {
                depth_kind: kind,
                ..Source::default()
            },
            ..Frame::of_normals(normal, mask)
        })
    }

    /// Depth read as that of the frame is.
    fn distances(&self, mut depth: Plane) -> Plane {
        if let Some(stored) = self.loaded.conventions.depth_kind {
            to_distances(&mut depth, stored);
        }
        depth
    }

    /// The window of all sources, in a picture of the frame's own size.
    fn common_window(&self, file: &Rc<Opened>, sources: &[RoleSource]) -> Result<Window> {
        let window = sources[0].window();
        let (display, _) = file.shown(window);
        let wanted = self.loaded.frame.display_window;
        let mismatch = |found: String, expected: String| Error::SizeMismatch {
            path: self.path.to_path_buf(),
            found,
            expected,
        };
        if display != wanted {
            return Err(mismatch(
                display.to_string(),
                format!("the picture is {wanted}"),
            ));
        }
        match sources.iter().find(|source| source.window() != window) {
            Some(other) => Err(mismatch(
                format!("{} ({})", other.window(), other.label()),
                format!("its depth is {window}"),
            )),
            None => Ok(window),
        }
    }

    /// Mask and unit normals in view space, read like those of the frame; depth becomes 0 outside the mask.
    fn with_normals(
        &self,
        mut normal: Vector3Planes,
        depth: &mut Plane,
        window: Window,
    ) -> (Mask, Vector3Planes) {
        let conventions = self.loaded.conventions;
        let encoding = judge_encoding(&normal);
        decode(&mut normal, encoding, conventions.normal_flip);
        let Covered { mask, .. } = coverage::cover(&mut normal, Some((depth, None)), None, None);
        let space = conventions.normal_space;
        turn_to_view(&mut normal, space, &self.camera, window);
        (mask, normal)
    }

    /// The same from depth alone.
    fn without_normals(&self, depth: &mut Plane, window: Window) -> (Mask, Vector3Planes) {
        // Depth has been turned to distances.
        let stored = match self.loaded.frame.source.depth_kind {
            DepthKind::Planar => StoredDepth::Planar,
            DepthKind::Ray => StoredDepth::Ray,
            DepthKind::Relative => StoredDepth::Relative,
        };
        let seen = (self.camera.projection, window);
        let normal = normals_of_depth(depth, stored, seen, |_, _| true, Precision::Float);
        let mut mask = coverage::of_normals(&normal, None, None, None);
        coverage::narrow_to(&mut mask, depth);
        (mask, normal)
    }
}
