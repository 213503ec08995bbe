//! From files to a frame: reads what a goal needs, and turns everything to view space once.

use super::colorspace::{Chromaticities, ColorSpace, luminance_weights};
use super::depth::{judge_depth, told_depth};
use super::depth_sense::{self, judge_sense};
use super::exr::ExrFile;
use super::finding::Finding;
use super::inputs::{Conventions, Inputs, KnownCamera, NormalEncoding, StoredDepth};
use super::light_layers::LightSources;
use super::normal_encoding::judge_encoding;
use super::photo::StoredPhoto;
use super::role_planes::RolePlanes;
use super::roles::Role;
use super::sources::{Holding, Opened, RoleSource, read_rows};
use super::surface::Surface;
use super::view::turn_to_view;
use crate::error::{Error, Result};
use crate::frame::coverage;
use crate::frame::depth::depth_of_positions;
use crate::frame::normals;
use crate::frame::{
    AWAY, ColorPlanes, DepthKind, Frame, Mask, Plane, Source, Vector2Planes, Vector3Planes, Window,
};
use std::ops::Range;
use std::rc::Rc;

/// What a run needs of a frame beyond its shape.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Needs {
    /// The picture.
    pub color: bool,
    /// The picture, where there is one.
    pub color_if_any: bool,
    /// The albedo, where there is one.
    pub albedo: bool,
    /// How view space falls onto the picture: only a foreshortened gradient asks. A camera that is
    /// needed for nothing else is then not looked for.
    pub projection: bool,
    /// Motion since the frame before, where there is any.
    pub motion: bool,
}

/// A frame with all that was concluded on the way.
pub struct Loaded {
    /// The frame, in view space.
    pub frame: Frame,
    /// How far, in pixels, the surface seen at each pixel has come since the frame before, x right, y up;
    /// [`AWAY`] where the file has no finite number.
    pub motion: Option<Vector2Planes>,
    /// What was concluded.
    pub findings: Vec<Finding>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Bits per sample of a photo; `None` for an EXR.
    pub photo_bits: Option<u8>,
    /// Whether the picture was stored as half floats.
    pub color_is_half: bool,
    /// Whether it is known where in the world the camera stands: positions of the world can be used.
    pub camera_is_placed: bool,
    /// Whether the camera was recovered from what it saw, and not told.
    pub camera_is_recovered: bool,
    /// How the layers were read.
    pub conventions: Conventions,
    /// Primaries and white of the picture, where somebody told them: Rec. 709 else.
    pub chromaticities: Option<Chromaticities>,
    pub(super) main: Rc<Opened>,
}

impl Loaded {
    /// The picture as an EXR file, where it is one.
    pub fn exr(&self) -> Option<&ExrFile> {
        match self.main.as_ref() {
            Opened::Exr { file, .. } => Some(file),
            Opened::Photo { .. } => None,
        }
    }

    /// The camera, to be given to the inputs of another frame.
    pub fn known_camera(&self) -> Option<KnownCamera> {
        let is_placed = self.camera_is_placed;
        let known = |camera| KnownCamera { camera, is_placed };
        self.frame.camera.map(known)
    }
}

/// Reads the frame that `inputs` describe: normals, what silhouettes need, and what else `needs` say.
///
/// # Errors
/// Any [`Error`] of reading; [`Error::MissingAov`] without normals or without a picture where one is
/// wanted; [`Error::SizeMismatch`] for inputs of unlike windows; [`Error::Undetermined`] where
/// neither names nor data tell the space of the normals.
pub fn load(inputs: &Inputs, needs: Needs) -> Result<Loaded> {
    InputFiles::open(inputs)?.load(inputs, needs)
}

/// The files of a frame, opened once for as many loads of its rows as there are.
pub struct InputFiles {
    main: Rc<Opened>,
}

/// How large a frame is, as far as headers tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// The pixels that it has.
    pub window: Window,
    /// Bytes that its photos take while they are held, decoded.
    pub photo_bytes: u64,
}

impl InputFiles {
    /// Opens the picture of `inputs`. Photos are let go of once they have been read.
    ///
    /// # Errors
    /// Any [`Error`] of reading a header.
    pub fn open(inputs: &Inputs) -> Result<Self> {
        Self::open_held(inputs, Holding::default())
    }

    /// The same for rows to be read again and again: photos stay decoded.
    ///
    /// # Errors
    /// As [`InputFiles::open`].
    pub fn open_for_strips(inputs: &Inputs) -> Result<Self> {
        let holding = Holding {
            stay: true,
            ..Holding::default()
        };
        Self::open_held(inputs, holding)
    }

    /// The same, where no more than `most_bytes` of a photo are decoded at a time: of larger ones rows are read.
    ///
    /// # Errors
    /// As [`InputFiles::open`].
    pub fn open_within(inputs: &Inputs, most_bytes: u64) -> Result<Self> {
        let holding = Holding {
            most_bytes,
            ..Holding::default()
        };
        Self::open_held(inputs, holding)
    }

    fn open_held(inputs: &Inputs, holding: Holding) -> Result<Self> {
        let main = Opened::open_held(&inputs.picture, inputs.view.as_deref(), holding)?;
        Ok(Self { main })
    }

    /// How large the frame of `inputs` is.
    ///
    /// # Errors
    /// As [`load`], as far as headers tell.
    pub fn extent(&self, inputs: &Inputs, needs: Needs) -> Result<Extent> {
        let light = LightSources::resolve(inputs, &self.main)?;
        let sources = Sources::resolve(inputs, &self.main, needs, !light.is_empty())?;
        let mut photos: Vec<_> = sources.roles.iter().filter_map(RoleSource::photo).collect();
        photos.extend(light.sources().iter().filter_map(RoleSource::photo));
        photos.sort_by_key(|photo| std::ptr::from_ref(*photo));
        photos.dedup_by_key(|photo| std::ptr::from_ref(*photo));
        Ok(Extent {
            window: sources.common_window(&light)?,
            photo_bytes: photos.into_iter().map(StoredPhoto::bytes).sum(),
        })
    }

    /// Reads the frame, or the rows of it that `inputs` name.
    ///
    /// # Errors
    /// As [`load`].
    pub fn load(&self, inputs: &Inputs, needs: Needs) -> Result<Loaded> {
        load_from(self.main.clone(), inputs, needs)
    }

    /// Lets go of photos that are held.
    pub fn release(&self) {
        self.main.release();
    }
}

fn load_from(main: Rc<Opened>, inputs: &Inputs, needs: Needs) -> Result<Loaded> {
    let light = LightSources::resolve(inputs, &main)?;
    let sources = Sources::resolve(inputs, &main, needs, !light.is_empty())?;
    let whole = sources.common_window(&light)?;
    let part = inputs.rows.as_ref().map(|rows| rows_of(whole, rows));
    let data_window = part.unwrap_or(whole);
    // A photo shows all of itself, whichever rows are read.
    let (display_window, pixel_aspect) = shown(&main, whole);
    let told = inputs.colorspace.or_else(|| sources.interop_space());
    let (mut planes, light_planes) = sources.read(&light, data_window, part, told)?;
    let mut notes = Notes::about(&sources);

    let mut normal = planes
        .vector(Role::Normal)
        .expect("normals are always resolved");
    let encoding = notes.encoding(inputs, &sources, &normal);
    let told_flip = inputs.normal_flip.unwrap_or_default();
    normals::decode(&mut normal, encoding, told_flip);
    let (color, alpha) = planes.color(Role::Color, &mut notes);
    let albedos = [Role::Albedo, Role::DiffuseColor];
    let albedo = albedos
        .into_iter()
        .find_map(|role| planes.color(role, &mut notes).0);
    let mut depth = planes.scalar(Role::Depth);
    let position = planes.vector(Role::Position);
    let told_mask = planes.scalar(Role::Mask);
    // What is known of depth before it is compared with the frame.
    let known = match (inputs.depth_kind, &depth) {
        (Some(stored), _) => Some((stored, "as told".into())),
        (None, Some(raw)) => {
            let layers = depth_sense::Layers {
                inputs,
                raw,
                normal: &normal,
                surface: Surface {
                    mask: &Mask::full(raw.width(), raw.height()),
                    position: position.as_ref(),
                    depth: None,
                    attributes: main.attributes(),
                    data_window,
                    display_window,
                    pixel_aspect,
                },
                alpha: alpha.as_ref(),
                mask: told_mask.as_ref(),
            };
            let source = sources.get(Role::Depth);
            judge_sense(&layers, source.map(RoleSource::hint).unwrap_or_default())?
        }
        (None, None) => None,
    };
    let stored = known.as_ref().map(|(stored, _)| *stored);
    let (mut mask, lengths) = coverage::cover(
        &mut normal,
        depth.as_mut().map(|depth| (depth, stored)),
        alpha.as_ref(),
        told_mask.as_ref(),
    );
    notes.on_coverage(&mask);

    let surface = Surface {
        mask: &mask,
        position: position.as_ref(),
        depth: depth.as_ref(),
        attributes: main.attributes(),
        data_window,
        display_window,
        pixel_aspect,
    };
    // Positions stand in for depth where nothing else was asked to; that takes the camera.
    let from_positions = position
        .as_ref()
        .filter(|_| depth.is_none() && !only_occlusion(inputs));
    let projection = needs.projection || from_positions.is_some();
    let hint = sources.roles[0].hint();
    let view = turn_to_view(inputs, &surface, projection, &hint, &mut normal)?;
    let camera = view.camera;
    notes.findings.extend(view.findings);
    let depth_role = match &depth {
        Some(_) => Role::Depth,
        None => Role::Position,
    };
    let depth_is_half = sources.get(depth_role).is_some_and(RoleSource::is_half);
    if let (Some(position), Some(camera)) = (from_positions, &camera) {
        let mut made = depth_of_positions(position, camera);
        coverage::narrow_to(&mut mask, &mut made);
        depth = Some(made);
    }

    let read = light.assemble(light_planes, color.as_ref(), &mask);
    notes.findings.extend(read.findings);
    notes.warnings.extend(read.warnings);

    let chromaticities = match (inputs.colorspace, main.as_ref()) {
        (Some(space), _) => Some(space.chromaticities()),
        (None, Opened::Exr { file, .. }) => file
            .chromaticities
            .or_else(|| told.map(ColorSpace::chromaticities)),
        (None, Opened::Photo { .. }) => None,
    };
    let mut frame = Frame {
        data_window,
        display_window,
        pixel_aspect,
        mask,
        normal,
        normal_length: (encoding == NormalEncoding::Signed).then_some(lengths),
        depth,
        occlusion: planes
            .scalar(Role::Occlusion)
            .or_else(|| coverage::varying(alpha.as_ref())),
        importance: planes.scalar(Role::Importance),
        color,
        albedo,
        alpha,
        light: read.layers,
        camera,
        source: Source {
            normal_rounding: sources.get(Role::Normal).map_or(0.0, RoleSource::rounding),
            luminance_weights: chromaticities.and_then(luminance_weights),
            ..origin(&main)
        },
    };
    let motion = planes.motion();
    let (stored, finding) = match known {
        Some((stored, why)) => (stored, told_depth(stored, why)),
        None => judge_depth(&frame, depth_is_half),
    };
    frame.source.depth_kind = match stored {
        // One over a half float is as coarse as a half float.
        StoredDepth::Inverse if depth_is_half => DepthKind::Relative,
        stored => stored.kind(),
    };
    notes
        .findings
        .extend(finding.filter(|_| frame.depth.is_some()));
    let conventions = Conventions {
        normal_space: view.normals.space,
        normal_encoding: encoding,
        normal_flip: told_flip.and(view.normals.flip),
        depth_kind: frame.depth.is_some().then_some(stored),
    };
    Ok(Loaded {
        frame,
        motion,
        findings: notes.findings,
        warnings: notes.warnings,
        photo_bits: photo_bits(&main),
        color_is_half: sources.get(Role::Color).is_some_and(RoleSource::is_half),
        camera_is_placed: view.is_placed,
        camera_is_recovered: view.is_recovered,
        conventions,
        chromaticities,
        main,
    })
}

/// The rows `rows` of a window, as far as it has them.
fn rows_of(window: Window, rows: &Range<usize>) -> Window {
    let row = |y: usize| window.y0 + y.min(window.height()) as i32;
    Window {
        y0: row(rows.start),
        y1: row(rows.end),
        ..window
    }
}

fn photo_bits(main: &Opened) -> Option<u8> {
    match main {
        Opened::Photo { photo, .. } => Some(photo.bits),
        Opened::Exr { .. } => None,
    }
}

/// Silhouettes come from one map: an occlusion map that was asked for spares the depth.
fn only_occlusion(inputs: &Inputs) -> bool {
    inputs.occlusion.is_some() && inputs.depth.is_none()
}

/// The sources of all roles that this run reads.
struct Sources {
    roles: Vec<RoleSource>,
}

impl Sources {
    fn resolve(inputs: &Inputs, main: &Rc<Opened>, needs: Needs, with_light: bool) -> Result<Self> {
        let find = |role, name: &Option<String>| RoleSource::resolve(role, name.as_deref(), main);
        let normal = find(Role::Normal, &inputs.normal)?
            .ok_or_else(|| missing(main, Role::Normal, "--normal LAYER or --normal FILE"))?;
        let mut roles = vec![normal];
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
        let color = find(Role::Color, &inputs.color)?;
        if needs.color && color.is_none() {
            return Err(missing(main, Role::Color, "--color LAYER or --color FILE"));
        }
        // Without depth that does, alpha tells coverage, so the picture is read for it; and light is compared to it.
        let depth = roles.iter().find(|s| s.role == Role::Depth);
        let implied = depth.and_then(|source| source.hint().0.depth);
        let untelling = inputs
            .depth_kind
            .or(implied)
            .is_some_and(|d| !d.tells_coverage());
        let with_color = needs.color || needs.color_if_any || with_light || untelling;
        if with_color || roles.iter().all(|s| s.role != Role::Depth) {
            roles.extend(color);
        }
        if needs.albedo {
            let albedo = find(Role::Albedo, &inputs.albedo)?;
            let by_name = || RoleSource::resolve(Role::DiffuseColor, None, main);
            roles.extend(albedo.map_or_else(by_name, |albedo| Ok(Some(albedo)))?);
        }
        roles.extend(find(Role::Mask, &inputs.mask)?);
        if needs.motion {
            roles.extend(find(Role::Motion, &inputs.motion)?);
        }
        if inputs.importance.is_some() {
            roles.extend(find(Role::Importance, &inputs.importance)?);
        }
        Ok(Self { roles })
    }

    /// The window that the frame has: that of the picture, where one is read, else that of the normals.
    ///
    /// # Errors
    /// [`Error::SizeMismatch`] where other windows cannot be brought to it: those of photos, and of files made
    /// for other display windows.
    fn common_window(&self, light: &LightSources) -> Result<Window> {
        let expected = self.get(Role::Color).unwrap_or(&self.roles[0]);
        let window = expected.window();
        for source in self.roles.iter().chain(light.sources()) {
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

    /// Reads the roles and the light layers, each file once.
    /// Of a part of them only its rows are decoded.
    fn read(
        &self,
        light: &LightSources,
        window: Window,
        part: Option<Window>,
        told: Option<ColorSpace>,
    ) -> Result<(Planes, Vec<RolePlanes>)> {
        let all: Vec<_> = self.roles.iter().chain(light.sources()).cloned().collect();
        let rows = part.map(|part| part.y0..part.y1);
        let mut read = read_rows(&all, rows, told)?;
        for (source, read) in all.iter().zip(&mut read) {
            read.bring_to(source.role, window);
        }
        let light = read.split_off(self.roles.len());
        let roles = self.roles.iter().map(|s| s.role).zip(read).collect();
        Ok((Planes { roles }, light))
    }

    /// What the file says that the colours of its picture mean.
    fn interop_space(&self) -> Option<ColorSpace> {
        ColorSpace::of_interop_id(self.get(Role::Color)?.interop_id()?)
    }

    fn get(&self, role: Role) -> Option<&RoleSource> {
        self.roles.iter().find(|s| s.role == role)
    }
}

pub(super) fn missing(main: &Opened, role: Role, flag: &str) -> Error {
    let layers = main.layer_names();
    let found = if layers.is_empty() {
        "a photo".into()
    } else {
        layers.join(", ")
    };
    Error::MissingAov {
        path: main.path().to_path_buf(),
        found: format!("has no {} layer (found {found})", role.name()),
        remedy: format!("name one with {flag}"),
    }
}

/// The planes as read, taken out role by role.
struct Planes {
    roles: Vec<(Role, RolePlanes)>,
}

impl Planes {
    fn take(&mut self, role: Role) -> Option<RolePlanes> {
        let index = self.roles.iter().position(|(r, _)| *r == role)?;
        Some(self.roles.swap_remove(index).1)
    }

    fn vector(&mut self, role: Role) -> Option<Vector3Planes> {
        self.take(role).map(RolePlanes::into_vector)
    }

    fn scalar(&mut self, role: Role) -> Option<Plane> {
        self.take(role).map(RolePlanes::into_scalar)
    }

    /// From previous minus current, as files have it, to how far the surface has come.
    fn motion(&mut self) -> Option<Vector2Planes> {
        let planes = self.take(Role::Motion)?.planes;
        let come = |plane: &Plane| plane.map(|back| if back.is_finite() { -back } else { AWAY });
        // A file named for motion may hold a picture of one channel: no way along the other axis.
        let x = come(&planes[0]);
        let y = match planes.get(1) {
            Some(plane) => come(plane),
            None => x.map(|_| 0.0),
        };
        Some(Vector2Planes { x, y })
    }

    fn color(&mut self, role: Role, notes: &mut Notes) -> (Option<ColorPlanes>, Option<Plane>) {
        let Some(mut read) = self.take(role) else {
            return (None, None);
        };
        let replaced = read.sanitise();
        let alpha = read.alpha.take();
        if replaced > 0 {
            notes.warnings.push(format!(
                "{replaced} colour samples were not finite: NaN became 0, infinity 65504"
            ));
        }
        (Some(read.into_color()), alpha)
    }
}

pub(super) fn shown(main: &Opened, window: Window) -> (Window, f32) {
    match main {
        Opened::Exr { file, .. } => (file.display_window, file.pixel_aspect),
        Opened::Photo { .. } => (window, 1.0),
    }
}

fn origin(main: &Opened) -> Source {
    match main {
        Opened::Photo { .. } => Source::default(),
        Opened::Exr { file, .. } => Source {
            layers: main.layer_names(),
            attributes: file.attributes.clone(),
            ..Source::default()
        },
    }
}

/// Conclusions and warnings gathered while loading.
struct Notes {
    findings: Vec<Finding>,
    warnings: Vec<String>,
}

impl Notes {
    fn about(sources: &Sources) -> Self {
        let findings = sources
            .roles
            .iter()
            .map(|source| Finding {
                subject: source.role.name(),
                conclusion: source.label().into(),
                evidence: format!("from {}", source.file.path().display()),
                flag: source.flag(),
            })
            .collect();
        let data = [Role::Normal, Role::Depth, Role::Position];
        let warnings = data
            .into_iter()
            .filter_map(|role| sources.get(role))
            .filter(|source| !source.lossy_channels().is_empty())
            .map(|source| {
                format!(
                    "{} was stored with a lossy compression: expect noise in curvature",
                    source.lossy_channels().join(", ")
                )
            })
            .collect();
        Self { findings, warnings }
    }

    fn on_coverage(&mut self, mask: &Mask) {
        if mask.count() == 0 {
            self.warnings
                .push("no pixel shows a surface: nothing to do".into());
        }
    }

    fn encoding(
        &mut self,
        inputs: &Inputs,
        sources: &Sources,
        stored: &Vector3Planes,
    ) -> NormalEncoding {
        let integers = sources.get(Role::Normal).is_some_and(
            |source| matches!(source.file.as_ref(), Opened::Photo { photo, .. } if !photo.is_float),
        );
        let (encoding, evidence) = match inputs.normal_encoding {
            Some(encoding) => (encoding, "as told"),
            None if integers => (NormalEncoding::Unsigned, "stored as integers"),
            None => (judge_encoding(stored), "from lengths and signs"),
        };
        let (conclusion, name) = match encoding {
            NormalEncoding::Signed => ("signed, -1..1", "signed"),
            NormalEncoding::Unsigned => ("unsigned, 0..1", "unsigned"),
        };
        self.findings.push(Finding {
            subject: "normal encoding".into(),
            conclusion: conclusion.into(),
            evidence: evidence.into(),
            flag: format!("--normal-encoding {name}"),
        });
        encoding
    }
}
