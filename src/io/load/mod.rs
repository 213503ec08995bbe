//! From files to a frame: reads the inputs a run needs, and converts everything to view space once.

pub(super) mod art_map;
pub(super) mod bundle;
pub(super) mod cryptomatte;
pub(super) mod depth_sense;
pub(crate) mod environment;
#[cfg(feature = "cli")]
pub(super) mod footprint;
pub(super) mod frame_sources;
pub(crate) mod from_depth;
pub(super) mod gloss;
#[cfg(feature = "cli")]
pub(super) mod in_strips;
pub(super) mod light_layers;
pub(super) mod notes;
pub(super) mod objects;
pub(super) mod opened;
pub(super) mod recombination;
pub(super) mod role_planes;
pub(super) mod sources;
pub(super) mod specular;
pub(super) mod surroundings;
pub(super) mod survey;
pub(super) mod view;

use crate::error::Result;
use crate::frame::coverage::{self, Covered};
use crate::frame::depth::{depth_of_positions, depth_rounding};
use crate::frame::normals;
use crate::frame::{
    DepthKind, Frame, Mask, Plane, Source, Vector3Planes, Window, lift_out_of_fog, strength_of,
};
use crate::io::colorspace::{Chromaticities, ColorSpace, luminance_weights};
use crate::io::exr::ExrFile;
use crate::io::finding::{Finding, Notes};
use crate::io::inputs::{
    Conventions, Inputs, KnownCamera, Needs, NormalEncoding, StoredDepth, Wrap,
};
use crate::io::judge::borders::Borders;
use crate::io::judge::depth::{Sense, depth_beside_positions, depth_finding, judge_depth};
use crate::io::judge::surface::SurfaceSamples;
use crate::io::motion::MotionLayers;
use crate::io::photo::{PhotoMetadata, StoredPhoto};
use crate::io::roles::Role;
use bundle::gathered;
use depth_sense::judge_sense;
use frame_sources::{FrameSources, ReadPlanes, only_occlusion};
use gloss::LitPicture;
use light_layers::{LightSources, has_light_passes};
use opened::{Holding, Opened};
use role_planes::RolePlanes;
use sources::RoleSource;
use std::ops::Range;
use std::rc::Rc;
use std::time::Duration;
use view::{FoundView, turn_to_view};

/// A frame with all conclusions about its inputs.
pub struct Loaded {
    /// The frame, in view space.
    pub frame: Frame,
    /// The candidates for motion since the previous frame, if it was needed.
    pub motion: Option<MotionLayers>,
    /// Factor by which the frame was enlarged relative to its files.
    pub enlarged: f64,
    /// Conclusions about the inputs.
    pub findings: Vec<Finding>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// Bits per sample of a photo; `None` for an EXR.
    pub photo_bits: Option<u8>,
    /// Whether the picture was stored as half floats.
    pub color_is_half: bool,
    /// Whether the camera's position in the world is known, so that world-space positions can be used.
    pub camera_is_placed: bool,
    /// Whether the camera was recovered from layers instead of given.
    pub camera_is_recovered: bool,
    /// Median distance of the surface, where its depth has been looked at.
    pub distance: Option<f32>,
    /// Whether pixels that show several surfaces were looked for, and there are none.
    pub is_sharp: bool,
    /// How long it took to make normals, where the files hold none.
    pub normals_made: Option<Duration>,
    /// Conventions by which the layers were read.
    pub conventions: Conventions,
    /// Primaries and white of the picture, where inputs or file name them; Rec. 709 otherwise.
    pub chromaticities: Option<Chromaticities>,
    pub(crate) main: Rc<Opened>,
}

#[cfg(feature = "view")]
impl AsRef<Frame> for Loaded {
    fn as_ref(&self) -> &Frame {
        &self.frame
    }
}

#[cfg(feature = "view")]
impl Loaded {
    /// It with its frame [reduced](Frame::reduced) to every `step`th pixel, and without motion.
    pub(crate) fn reduced(&self, step: usize) -> Self {
        Self {
            frame: self.frame.reduced(step),
            motion: None,
            findings: self.findings.clone(),
            warnings: self.warnings.clone(),
            main: self.main.clone(),
            ..*self
        }
    }
}

impl Loaded {
    /// The picture as an EXR file, if it is one.
    pub fn exr(&self) -> Option<&ExrFile> {
        self.main.exr()
    }

    /// Metadata that a picture made from a photo keeps; empty for an EXR.
    ///
    /// # Errors
    /// Those of reading the file.
    pub fn metadata(&self) -> Result<PhotoMetadata> {
        let photo = self.main.photo();
        photo.map_or_else(|| Ok(PhotoMetadata::default()), StoredPhoto::metadata)
    }

    /// The camera, to be given to the inputs of another frame.
    pub fn known_camera(&self) -> Option<KnownCamera> {
        let is_placed = self.camera_is_placed;
        let known = |camera| KnownCamera { camera, is_placed };
        self.frame.camera.map(known)
    }
}

/// Reads the frame described by `inputs`: normals, the inputs of silhouettes, and everything else in `needs`.
///
/// # Errors
/// Any [`crate::Error`] of reading; [`crate::Error::MissingAov`] without normals or without a picture where one is
/// wanted; [`crate::Error::SizeMismatch`] for inputs of unlike windows; [`crate::Error::Undetermined`] where
/// neither names nor data show the space of the normals.
pub fn load(inputs: &Inputs, needs: Needs) -> Result<Loaded> {
    let (inputs, note) = gathered(inputs)?;
    let main = Opened::open_picture(&inputs, Holding::default())?;
    let mut loaded = load_from(main, &inputs, needs)?;
    loaded.warnings.splice(..0, note);
    Ok(loaded)
}

/// Reads the frame, or the rows of it named by `inputs`, from its opened picture.
pub(crate) fn load_from(main: Rc<Opened>, inputs: &Inputs, needs: Needs) -> Result<Loaded> {
    let light = LightSources::resolve(inputs, &main)?;
    let sources = FrameSources::resolve(inputs, &main, needs, !light.is_empty())?;
    let whole = sources.common_window(&light)?;
    let part = inputs.rows.as_ref().map(|rows| rows_of(whole, rows));
    let data_window = part.unwrap_or(whole);
    let colorspace = inputs.colorspace.or_else(|| sources.interop_space());
    let (mut planes, light_planes) = sources.read(&light, data_window, part, colorspace)?;
    let mut notes = Notes::about(&sources, &main);
    // A photo shows all of itself, whichever rows are read.
    let (display_window, pixel_aspect) = main.shown(whole);
    let source = SourceRegion {
        inputs,
        main: &main,
        objects: objects::file_of(inputs, &main, whole)?,
        sources: &sources,
        data_window,
        display_window,
        pixel_aspect,
    };

    let stored_borders = planes.borders();
    let given_flip = inputs.normal_flip.unwrap_or_default();
    let own_alpha = planes.take_alpha(Role::Normal);
    let mut stored_normal = planes.vector(Role::Normal);
    let (mut borders, mut encoding) = (Borders::default(), NormalEncoding::Signed);
    if let Some(normal) = &mut stored_normal {
        borders = stored_borders.unwrap_or_else(|| Borders::of(normal));
        // Some rows of a picture do not tell its borders.
        let is_whole = inputs.rows.is_none();
        if is_whole && (inputs.wrap != Wrap::None || main.is_normal_map()) {
            notes.findings.extend(borders.finding());
        }
        let noise = sources.roles[0].noise();
        if is_whole && noise > 0.0 {
            notes.warnings.push(format!(
                "normals: noise of {noise:.3} in their slopes was removed: what is finer than it is lost"
            ));
        }
        let alphas = [own_alpha.as_ref(), planes.alpha(Role::Color)];
        encoding = notes.encoding(inputs, &sources, normal, alphas)?;
        normals::decode(normal, encoding, given_flip);
    }
    drop(own_alpha);
    let are_filtered = stored_normal.is_some() && encoding == NormalEncoding::Signed;
    let mut layers = FrameLayers::of(&mut planes);
    notes.warnings.append(&mut planes.warnings);
    let strength = source.strength(planes.scalar(Role::Mask))?;
    if let Some(strength) = &strength {
        notes.on_strength(strength, inputs.rows.is_some());
    }
    let strength = layers.take_strength(strength, needs);
    let ViewSurface {
        normal,
        mask,
        lengths,
        sense,
        depth_is_half,
        view,
        made,
    } = match stored_normal {
        Some(normal) => source.seen_surface(normal, &mut layers, needs, &mut notes)?,
        None => source.surface_of_depth(&mut layers, &mut notes)?,
    };

    let is_whole = inputs.rows.is_none();
    // Codes were mended where they are noisy, and their texture is not judged again.
    if is_whole && made.is_none() && !sources.roles[0].holds_codes() {
        notes.on_noise(&normal, &mask);
    }
    let numbered = || objects::numbered(&source.objects, &mask, data_window);
    let objects = needs
        .objects
        .then(numbered)
        .and_then(|found| notes.objects(found));
    // Pictures take the memory of positions, which nothing reads from here on.
    layers.position = None;
    let color = layers.color.map(RolePlanes::into_color);
    let albedo = layers.albedo.map(RolePlanes::into_color);
    let picture = LitPicture {
        color: color.as_ref(),
        albedo: albedo.as_ref(),
        alpha: layers.alpha.as_ref(),
    };
    let light = light.assemble(light_planes, picture, &mask, (inputs, &main), &mut notes);
    let chromaticities = source.chromaticities(colorspace);
    // Silhouettes follow depth where there is any.
    let alpha = layers.alpha.as_ref().filter(|_| layers.depth.is_none());
    let occlusion = planes
        .scalar(Role::Occlusion)
        .or_else(|| coverage::varying(alpha));
    let mut frame = Frame {
        data_window,
        display_window,
        pixel_aspect,
        normal_length: are_filtered.then_some(lengths),
        depth: layers.depth,
        occlusion,
        importance: planes.scalar(Role::Importance),
        strength,
        objects,
        stroke_fallback: objects::fallbacks(&inputs.object_angles, &source.objects, data_window)?,
        color,
        albedo,
        alpha: layers.alpha,
        light,
        camera: view.camera,
        wraps: borders.wrapped(inputs.wrap),
        source: source.source(chromaticities, depth_is_half),
        ..Frame::of_normals(normal, mask)
    };
    let stored = settle_depth_kind(&mut frame, sense, depth_is_half, &mut notes);
    frame.source.heights = stored == StoredDepth::Height;
    frame.confidence = needs.confidence(&frame);
    let looks_for_blends = needs.confidence || needs.confidence_if_any;
    if let Some(lengths) = &mut frame.normal_length {
        lift_out_of_fog(lengths, &frame.mask);
    }
    notes.on_steps(&frame);
    Ok(Loaded {
        motion: sources.motion(&mut planes, inputs, display_window),
        enlarged: 1.0,
        findings: notes.findings,
        warnings: notes.warnings,
        photo_bits: main.photo().map(|photo| photo.header.bits),
        color_is_half: sources.get(Role::Color).is_some_and(RoleSource::is_half),
        camera_is_placed: view.is_placed,
        camera_is_recovered: view.is_recovered,
        distance: None,
        is_sharp: looks_for_blends && frame.confidence.is_none(),
        normals_made: made,
        conventions: Conventions {
            normal_space: view.normals.space,
            normal_encoding: encoding,
            normal_flip: given_flip.and(view.normals.flip),
            depth_kind: frame.depth.is_some().then_some(stored),
        },
        chromaticities,
        frame,
        main,
    })
}

/// Settles the kind of depth, from prior knowledge or else from the frame; returns how it was stored.
fn settle_depth_kind(
    frame: &mut Frame,
    sense: Sense,
    is_half: bool,
    notes: &mut Notes,
) -> StoredDepth {
    let judged = sense.or_else(|| judge_depth(frame, is_half));
    let stored = judged
        .as_ref()
        .map_or(StoredDepth::Planar, |(stored, _)| *stored);
    frame.source.depth_kind = stored.kind_of(is_half);
    let finding = judged.filter(|_| frame.depth.is_some()).map(depth_finding);
    notes.findings.extend(finding);
    stored
}

/// The layers that go into a frame beside its normals.
pub(crate) struct FrameLayers {
    pub(crate) color: Option<RolePlanes>,
    pub(crate) alpha: Option<Plane>,
    pub(crate) albedo: Option<RolePlanes>,
    pub(crate) depth: Option<Plane>,
    pub(crate) position: Option<Vector3Planes>,
    pub(crate) coverage: Option<Plane>,
}

impl FrameLayers {
    fn of(planes: &mut ReadPlanes) -> Self {
        let (color, alpha) = planes.color(Role::Color);
        let mut albedos = [Role::Albedo, Role::DiffuseColor].into_iter();
        Self {
            color,
            alpha,
            albedo: albedos.find_map(|role| planes.color(role).0),
            depth: planes.scalar(Role::Depth),
            position: planes.vector(Role::Position),
            coverage: planes.scalar(Role::Coverage),
        }
    }

    /// The strength mask, if it was requested; otherwise it counts as coverage.
    fn take_strength(&mut self, strength: Option<Plane>, needs: Needs) -> Option<Plane> {
        let strength = strength?;
        if needs.strength {
            return Some(strength);
        }
        self.coverage = Some(match self.coverage.take() {
            Some(mut covered) => {
                covered.each_with(&strength, |share, other| *share = share.min(other));
                covered
            }
            None => strength,
        });
        None
    }
}

/// Source of a frame, and the pixels to read.
pub(crate) struct SourceRegion<'a> {
    pub(crate) inputs: &'a Inputs,
    pub(crate) main: &'a Opened,
    /// The file that tells its objects apart.
    pub(crate) objects: Rc<Opened>,
    pub(crate) sources: &'a FrameSources,
    pub(crate) data_window: Window,
    pub(crate) display_window: Window,
    pub(crate) pixel_aspect: f32,
}

/// The surface of a frame in view space, and how its layers were read.
pub(crate) struct ViewSurface {
    pub(crate) normal: Vector3Planes,
    pub(crate) mask: Mask,
    /// The lengths that the normals had.
    pub(crate) lengths: Plane,
    pub(crate) sense: Sense,
    pub(crate) depth_is_half: bool,
    pub(crate) view: FoundView,
    /// How long normals took to make, of depth.
    pub(crate) made: Option<Duration>,
}

impl SourceRegion<'_> {
    pub(crate) fn surface<'s>(
        &'s self,
        mask: &'s Mask,
        layers: &'s FrameLayers,
        depth: Option<&'s Plane>,
    ) -> SurfaceSamples<'s> {
        SurfaceSamples {
            mask,
            position: layers.position.as_ref(),
            depth,
            attributes: self.main.exr().map(|file| &file.attributes),
            data_window: self.data_window,
            display_window: self.display_window,
            pixel_aspect: self.pixel_aspect,
        }
    }

    /// Determines the camera and the space of the decoded normals, and turns these to view space; depth of positions
    /// takes the place of depth in `layers` where it is missing.
    fn seen_surface(
        &self,
        mut normal: Vector3Planes,
        layers: &mut FrameLayers,
        needs: Needs,
        notes: &mut Notes,
    ) -> Result<ViewSurface> {
        let sense = self.depth_sense(&normal, layers)?;
        let stored = sense.as_ref().map(|(stored, _)| *stored);
        let depth = layers.depth.as_mut().map(|depth| (depth, stored));
        let (alpha, covered) = (layers.alpha.as_ref(), layers.coverage.as_ref());
        let Covered {
            mut mask,
            lengths,
            filled,
        } = coverage::cover(&mut normal, depth, alpha, covered);
        notes.on_coverage(&mask);
        notes.on_filled(filled, &mask);
        let surface = self.surface(&mask, layers, layers.depth.as_ref());
        let projection = needs.projection || self.positions_for_depth(layers).is_some();
        let source = &self.sources.roles[0];
        let view = turn_to_view(
            self.inputs,
            &surface,
            projection,
            source,
            &mut normal,
            notes,
        )?;
        let depth_is_half = self.depth_is_half(layers);
        let beside = (
            layers.depth.as_ref(),
            layers.position.as_ref(),
            &view.camera,
        );
        let sense = sense.or_else(|| match beside {
            (Some(depth), Some(positions), Some(camera)) if !depth_is_half => {
                depth_beside_positions(depth, positions, &mask, camera)
            }
            _ => None,
        });
        let placed = self.positions_for_depth(layers).zip(view.camera.as_ref());
        if let Some((positions, camera)) = placed {
            let mut depth = depth_of_positions(positions, camera);
            coverage::narrow_to(&mut mask, &mut depth);
            layers.depth = Some(depth);
        }
        Ok(ViewSurface {
            normal,
            mask,
            lengths,
            sense,
            depth_is_half,
            view,
            made: None,
        })
    }

    /// Strength of the effect, 0..1: the share of the chosen objects times the mask.
    fn strength(&self, mask: Option<Plane>) -> Result<Option<Plane>> {
        let chosen = &self.inputs.objects;
        let objects = match chosen.is_empty() {
            true => None,
            false => Some(objects::covered(chosen, &self.objects, self.data_window)?),
        };
        Ok(strength_of(mask, objects))
    }

    /// Prior knowledge about depth, before it is compared with the frame.
    fn depth_sense(&self, normal: &Vector3Planes, layers: &FrameLayers) -> Result<Sense> {
        let raw = match (self.inputs.depth_kind, &layers.depth) {
            (Some(stored), _) => return Ok(Some((stored, "as given".into()))),
            (None, Some(raw)) => raw,
            (None, None) => return Ok(None),
        };
        let none = Mask::full(0, 0);
        let evidence = depth_sense::SenseLayers {
            inputs: self.inputs,
            raw,
            normal,
            surface: self.surface(&none, layers, None),
            alpha: layers.alpha.as_ref(),
            mask: layers.coverage.as_ref(),
        };
        let source = self.sources.get(Role::Depth);
        judge_sense(&evidence, source.map(RoleSource::hint).unwrap_or_default())
    }

    /// Positions, where they replace depth: no depth is given, and occlusion was not chosen instead.
    pub(crate) fn positions_for_depth<'s>(
        &self,
        layers: &'s FrameLayers,
    ) -> Option<&'s Vector3Planes> {
        let is_wanted = layers.depth.is_none() && !only_occlusion(self.inputs);
        layers.position.as_ref().filter(|_| is_wanted)
    }

    /// Whether depth, or the positions it is computed from, are half floats.
    pub(crate) fn depth_is_half(&self, layers: &FrameLayers) -> bool {
        let role = match &layers.depth {
            Some(_) => Role::Depth,
            None => Role::Position,
        };
        self.sources.get(role).is_some_and(RoleSource::is_half)
    }

    /// Provenance of the frame, except for the kind of its depth.
    fn source(&self, chromaticities: Option<Chromaticities>, depth_is_half: bool) -> Source {
        let rounding = |role| self.sources.get(role).map_or(0.0, RoleSource::rounding);
        let file = self.main.exr();
        Source {
            layers: self.main.layer_names(),
            attributes: file.map(|file| file.attributes.clone()).unwrap_or_default(),
            luminance_weights: chromaticities.and_then(luminance_weights),
            depth_kind: DepthKind::default(),
            normal_rounding: rounding(Role::Normal),
            depth_rounding: depth_rounding(depth_is_half, rounding(Role::Depth)),
            light_passes: has_light_passes(self.main),
            heights: false,
        }
    }

    fn chromaticities(&self, colorspace: Option<ColorSpace>) -> Option<Chromaticities> {
        let given = self.inputs.colorspace.map(ColorSpace::chromaticities);
        let of_file = |file: &ExrFile| {
            let named = || colorspace.map(ColorSpace::chromaticities);
            file.chromaticities.or_else(named)
        };
        given.or_else(|| self.main.exr().and_then(of_file))
    }
}

/// The rows `rows` of a window, clipped to it.
fn rows_of(window: Window, rows: &Range<usize>) -> Window {
    let row = |y: usize| window.y0 + y.min(window.height()) as i32;
    Window {
        y0: row(rows.start),
        y1: row(rows.end),
        ..window
    }
}
