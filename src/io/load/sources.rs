//! The file and layer of each role, and reading them.

use super::bundle::RoleBundle;
use super::opened::Opened;
use super::role_planes::RolePlanes;
use crate::error::{Error, Result};
use crate::frame::{
    DENOISING_REACH, NormalSpace, Plane, UNROUNDING_PHASE, UNROUNDING_REACH, Vector3Planes, Window,
    denoise, unround_wrapped,
};
use crate::io::colorspace::ColorSpace;
use crate::io::exr::{ChannelId, Part, SampleType};
use crate::io::inputs::{Inputs, NormalEncoding, Wrap};
use crate::io::judge::borders::Borders;
use crate::io::judge::map_codes::Mistake;
use crate::io::noise::noise_of;
use crate::io::photo::{CodeMeaning, StoredPhoto, is_inside, max_code};
use crate::io::picture::is_picture_name;
use crate::io::roles::names::{self, Hint};
use crate::io::roles::nearest;
use crate::io::roles::words::said;
use crate::io::roles::{self, Match, Role};
use crate::untrusted::Untrusted;
use std::ops::Range;
use std::path::Path;
use std::rc::Rc;

/// Source of the planes of one role.
#[derive(Clone)]
pub(crate) struct RoleSource {
    pub(crate) role: Role,
    pub(crate) file: Rc<Opened>,
    /// The layer of an EXR; a photo is one layer.
    layer: Option<Match>,
    /// Whether it is a tile, where it holds normals.
    wrap: Wrap,
    /// The encoding of its normals, where it is given.
    encoding: Option<NormalEncoding>,
    /// Whether it holds normals along the axes of the picture: of others noise cannot be told.
    is_along_axes: bool,
    /// Why it was chosen, where neither the table of names nor a flag names it, and the other layers that could be.
    pub(crate) chosen: Option<WhyChosen>,
}

/// Why a layer was chosen for its role.
#[derive(Clone)]
pub(crate) struct WhyChosen {
    pub(crate) why: String,
    /// Names of the other layers that could play the role, the best first.
    pub(crate) others: Vec<String>,
}

impl RoleSource {
    /// The layer that plays `role`: the one named, a layer of `main` or a file; else by its name.
    pub(crate) fn resolve(
        role: Role,
        named: Option<&str>,
        main: &Rc<Opened>,
    ) -> Result<Option<Self>> {
        let Some(name) = named else {
            return Ok(Self::by_role(role, main));
        };
        if let Some(source) = Self::layer(role, name, main) {
            return Ok(Some(source));
        }
        let path = Path::new(name);
        if let Some(bundle) = RoleBundle::of(path)? {
            let file = bundle.member(role).map(|file| main.open_companion(file));
            let file = file.ok_or_else(|| bundle.without(role))??;
            return Ok(Self::in_file(role, &file));
        }
        if !path.exists() && !is_inside(path) {
            if name == Inputs::NONE && role != Role::Normal {
                return Ok(None);
            }
            return Err(no_such_layer(role, name, main));
        }
        let file = main.open_companion(path)?;
        Self::in_file(role, &file)
            .map(Some)
            .ok_or_else(|| no_such_layer(role, name, &file))
    }

    pub(crate) fn by_role(role: Role, file: &Rc<Opened>) -> Option<Self> {
        if file.photo().is_some() {
            return (role == Role::Color).then(|| Self::of(role, file, None, None));
        }
        let (layer, chosen) = match roles::by_name(&file.layers, role) {
            Some(layer) => (layer, None),
            None => by_words_or_numbers(role, file)?,
        };
        Some(Self::of(role, file, Some(layer), chosen))
    }

    /// A layer of `file` for `role`; a photo has none.
    pub(crate) fn of(
        role: Role,
        file: &Rc<Opened>,
        layer: Option<Match>,
        chosen: Option<WhyChosen>,
    ) -> Self {
        Self {
            role,
            file: file.clone(),
            layer,
            wrap: Wrap::None,
            encoding: None,
            is_along_axes: false,
            chosen,
        }
    }

    /// The normals of a photo that is a normal map itself.
    pub(crate) fn normal_map(main: &Rc<Opened>) -> Option<Self> {
        let chosen = WhyChosen {
            why: "its pixels hold vectors of unit length".into(),
            others: Vec::new(),
        };
        main.is_normal_map()
            .then(|| Self::of(Role::Normal, main, None, Some(chosen)))
    }

    /// The layer of `file` that plays `role`, or else the first that could.
    pub(crate) fn in_file(role: Role, file: &Rc<Opened>) -> Option<Self> {
        Self::by_role(role, file).or_else(|| Self::only_layer(role, file))
    }

    /// A file named for a role serves it under any layer name.
    fn only_layer(role: Role, file: &Rc<Opened>) -> Option<Self> {
        let could = || file.layers.iter().find_map(|layer| layer.matched(role));
        let layer = match file.photo() {
            Some(_) => None,
            None => Some(could()?),
        };
        Some(Self::of(role, file, layer, None))
    }

    /// The layer of `main` with this name, for `role`.
    pub(crate) fn layer(role: Role, name: &str, main: &Rc<Opened>) -> Option<Self> {
        let found = main.named(name, role)?;
        Some(Self::of(role, main, Some(found), None))
    }

    /// Its channels; none of a photo.
    pub(crate) fn found(&self) -> Option<&Match> {
        self.layer.as_ref()
    }

    /// Full names of its channels, for messages.
    pub(crate) fn channel_names(&self) -> String {
        let Some((part, layer)) = self.part() else {
            return self.label().into();
        };
        let names = layer.channels.iter();
        let names = names.map(|&channel| part.channels[channel].name.as_str());
        names.collect::<Vec<_>>().join(" ")
    }

    /// The part that its layer is in, and the layer; none of a photo.
    fn part(&self) -> Option<(&Part, &Match)> {
        let (file, layer) = self.file.exr().zip(self.layer.as_ref())?;
        Some((&file.parts[layer.part], layer))
    }

    /// The same of normals that `inputs` describe.
    pub(crate) fn described(self, inputs: &Inputs) -> Self {
        let space = inputs.normal_space.unwrap_or(NormalSpace::View);
        Self {
            wrap: inputs.wrap,
            encoding: inputs.normal_encoding,
            is_along_axes: inputs.camera.is_none() && space == NormalSpace::View,
            ..self
        }
    }

    /// The noise of slopes that is removed from normals in codes; 0 for none, or where it cannot be told from their mistake.
    pub(crate) fn noise(&self) -> f32 {
        let is_exchanged = || self.mistake() == Some(Mistake::Exchanged);
        match self.file.photo() {
            Some(photo) if self.is_along_axes && !self.is_pair() && !is_exchanged() => {
                *self.file.judged.noise.get_or_init(|| noise_of(photo))
            }
            _ => 0.0,
        }
    }

    /// The encoding of its normals as far as it is known without their numbers, and why.
    pub(crate) fn encoding(&self) -> Option<(NormalEncoding, &'static str)> {
        let given = self.encoding.map(|encoding| (encoding, "as given"));
        let pair = self.layer.as_ref();
        if let Some(layer) = pair.filter(|layer| layer.channels.len() == 2) {
            let is_octahedral = layer.layer.to_ascii_lowercase().contains("oct");
            let found = match is_octahedral {
                true => (NormalEncoding::Oct, "by its name, of two channels"),
                false => (NormalEncoding::Xy, "it has x and y alone"),
            };
            let given = given.filter(|(encoding, _)| encoding.is_pair());
            return given.or(Some(found));
        }
        given.or_else(|| {
            let pair = self.file.map_codes()?.pair?;
            Some((pair.encoding, pair.why))
        })
    }

    /// The encoding of its normals, if it holds any and that is known.
    fn encoding_of_normals(&self) -> Option<NormalEncoding> {
        let encoding = || self.encoding().map(|(encoding, _)| encoding);
        (self.role == Role::Normal).then(encoding)?
    }

    /// Whether its normals have two components stored.
    fn is_pair(&self) -> bool {
        self.encoding_of_normals()
            .is_some_and(|encoding| encoding.is_pair())
    }

    /// Leaves its coverage unread.
    pub(crate) fn leave_alpha(&mut self) {
        if let Some(layer) = &mut self.layer {
            layer.alpha = None;
        }
    }

    /// Whether this is the same layer of the same file as `other`.
    pub(crate) fn is_layer_of(&self, other: &Self) -> bool {
        let place = |layer: &Match| (layer.part, layer.channels.clone());
        let places = [self, other].map(|source| source.layer.as_ref().map(place));
        Rc::ptr_eq(&self.file, &other.file) && places[0].is_some() && places[0] == places[1]
    }

    /// Whether it is a photo, this very file.
    pub(crate) fn is_photo_of(&self, file: &Rc<Opened>) -> bool {
        self.layer.is_none() && self.file.path() == file.path()
    }

    /// Name of this source in messages.
    pub(crate) fn label(&self) -> &str {
        match &self.layer {
            Some(layer) if layer.layer.is_empty() => "bare channels",
            Some(layer) => &layer.layer,
            None => "the whole picture",
        }
    }

    /// The flag that would choose this source; bare channels have no name to be chosen by.
    pub(crate) fn flag(&self) -> String {
        let role = self.role.name();
        let name = match &self.layer {
            Some(layer) if layer.layer.is_empty() => return format!("--{role} NAME|FILE"),
            Some(layer) => layer.layer.as_str().into(),
            None => self.file.path().to_string_lossy(),
        };
        format!("--{role} {}", Untrusted(&name).quoted())
    }

    /// The pixels meant to be shown of the file it is in.
    pub(crate) fn display(&self) -> Window {
        self.file.display()
    }

    /// Whether it is a layer of an EXR.
    pub(crate) fn is_exr(&self) -> bool {
        self.layer.is_some()
    }

    /// Hint from the name of its layer, or from the file's renderer, with its origin in words.
    pub(crate) fn hint(&self) -> (Hint, String) {
        if let Some((file, layer)) = self.file.exr().zip(self.layer.as_ref()) {
            let space = || said(&layer.layer, None).space;
            let space = (self.role == Role::Normal).then(space).flatten();
            return names::hint(&layer.layer, space, file);
        }
        // No other space can be meant where no camera could turn them.
        if self.is_along_axes && self.holds_codes() {
            let space = Some(NormalSpace::View);
            let hint = Hint { space, depth: None };
            return (hint, "view, as in any picture of integers".into());
        }
        match self.role {
            Role::Depth => names::hint_of_depth_file(self.file.path()),
            _ => (Hint::default(), String::new()),
        }
    }

    /// Rows of a photo's planes, of normals with x in the first one.
    fn planes_of(
        &self,
        photo: &StoredPhoto,
        rows: Range<usize>,
        meaning: CodeMeaning,
    ) -> Result<Vec<Plane>> {
        let mut planes = photo.planes(rows, meaning)?;
        if self.encoding_of_normals() == Some(NormalEncoding::Ag) {
            if planes.len() != 4 {
                return Err(Error::Unsupported {
                    path: self.file.path().to_path_buf(),
                    found: "has no alpha that could hold x of its normals".into(),
                    remedy: "give another --normal-encoding".into(),
                });
            }
            planes[0] = planes[3].clone();
        }
        if let Some(mistake) = self.mistake() {
            mistake.undo(&mut planes);
        }
        Ok(planes)
    }

    /// The mistake in the codes of its normals that is undone: none where a user says how they are stored.
    pub(crate) fn mistake(&self) -> Option<Mistake> {
        let is_judged = self.role == Role::Normal && self.encoding.is_none() && self.is_along_axes;
        is_judged.then(|| self.file.map_codes()?.mistake)?
    }

    /// The window of this source.
    pub(crate) fn window(&self) -> Window {
        let of_layer = self.part().map(|(part, _)| part.window);
        of_layer.unwrap_or_else(|| self.file.display())
    }

    /// Bits of the codes of a photo of integers.
    fn code_bits(&self) -> Option<u8> {
        let photo = self.file.photo().filter(|photo| !photo.header.is_float);
        photo.map(|photo| photo.header.bits)
    }

    /// Whether it is a photo whose samples are integers.
    pub(crate) fn holds_codes(&self) -> bool {
        self.code_bits().is_some()
    }

    /// The `colorInteropID` of its part.
    pub(crate) fn interop_id(&self) -> Option<&str> {
        self.part()?.0.color_interop_id.as_deref()
    }

    /// The channels whose stored values a lossy compression has altered.
    pub(crate) fn lossy_channels(&self) -> Vec<String> {
        let Some((part, layer)) = self.part() else {
            return Vec::new();
        };
        let lossy = layer.channels.iter().filter(|c| part.is_lossy(**c));
        lossy.map(|&c| part.channels[c].name.clone()).collect()
    }

    /// Whether all its channels are half floats.
    pub(crate) fn is_half(&self) -> bool {
        self.part().is_some_and(|(part, layer)| {
            let mut channels = layer.channels.iter().map(|&c| &part.channels[c]);
            channels.all(|channel| channel.sample_type == SampleType::Half)
        })
    }

    /// How its samples are stored, in words.
    pub(crate) fn precision(&self) -> String {
        match self.code_bits() {
            Some(bits) => format!(" ({bits} bits)"),
            None if self.is_half() => " (half floats)".into(),
            None => String::new(),
        }
    }

    /// Largest rounding error of its samples, of a quantity from -1 to 1: half a step between codes, or
    /// between half floats just below 1. 0 for floats.
    pub(crate) fn rounding(&self) -> f32 {
        match self.code_bits() {
            Some(bits) => 1.0 / max_code(bits) as f32,
            None if self.is_half() => f32::from(half::f16::EPSILON) / 4.0,
            None => 0.0,
        }
    }

    /// Its channels, its alpha last.
    fn channels(&self) -> impl Iterator<Item = ChannelId> {
        let alpha = |layer: &Match| {
            let part = layer.part;
            layer.alpha.map(|channel| ChannelId { part, channel })
        };
        let layers = self.layer.iter();
        layers.flat_map(move |layer| layer.ids().chain(alpha(layer)))
    }
}

/// The layer for `role` if the table of names knows none.
fn by_words_or_numbers(role: Role, file: &Opened) -> Option<(Match, Option<WhyChosen>)> {
    let mut by_words = roles::by_words(&file.layers, role).into_iter();
    if let Some(layer) = by_words.next() {
        let chosen = WhyChosen {
            why: "by the words of its name".into(),
            others: by_words.map(|other| other.layer).collect(),
        };
        return Some((layer, Some(chosen)));
    }
    let found = file.role_by_numbers(role)?;
    let chosen = WhyChosen {
        why: format!("by numbers: {}", found.why),
        others: found.others.clone(),
    };
    Some((found.found.clone(), Some(chosen)))
}

/// The error of a `file` without a layer for `role`; `flag` names one.
pub(crate) fn missing(file: &Opened, role: Role, flag: &str) -> Error {
    Error::MissingAov {
        path: file.path().to_path_buf(),
        found: format!(
            "has no {} layer (found {})",
            role.name(),
            file.found("a photo")
        ),
        remedy: match nearest::nearest(&file.layers, role) {
            Some(layer) => format!("did you mean {}? name one with {flag}", Untrusted(layer)),
            None => format!("name one with {flag}"),
        },
    }
}

fn no_such_layer(role: Role, name: &str, file: &Opened) -> Error {
    let meant = match file.alike(name) {
        Some(layer) => format!("did you mean {}? ", Untrusted(layer)),
        None => String::new(),
    };
    let (role, found) = (role.name(), file.found("no layers"));
    let is_picture = is_picture_name(Path::new(name));
    let name = Untrusted(name);
    let found = match is_picture {
        true => format!("{name} is no file, and no layer either (found {found})"),
        false => format!("no {role} called {name} (found {found})"),
    };
    Error::MissingAov {
        path: file.path().to_path_buf(),
        found,
        remedy: format!("{meant}give --{role} a layer with the right channels, or a file"),
    }
}

/// Reads the planes of all `sources`, each part of a file once, in the order given.
pub(crate) fn read_all(sources: &[RoleSource]) -> Result<Vec<RolePlanes>> {
    read_rows(sources, None, None)
}

/// [`read_all`] for these rows only, in window coordinates, clipped to each source; colours are in `colorspace`, if
/// known.
pub(crate) fn read_rows(
    sources: &[RoleSource],
    rows: Option<Range<i32>>,
    colorspace: Option<ColorSpace>,
) -> Result<Vec<RolePlanes>> {
    let rows = rows.unwrap_or(i32::MIN..i32::MAX);
    let mut planes: Vec<Option<RolePlanes>> = sources.iter().map(|_| None).collect();
    for first in 0..sources.len() {
        if planes[first].is_some() {
            continue;
        }
        let (file, stored) = (&sources[first].file, sources[first].window());
        let together =
            |source: &RoleSource| Rc::ptr_eq(&source.file, file) && source.window() == stored;
        let together: Vec<usize> = (first..sources.len())
            .filter(|&i| together(&sources[i]))
            .collect();
        let y0 = rows.start.clamp(stored.y0, stored.y1);
        let window = Window {
            y0,
            y1: rows.end.clamp(y0, stored.y1),
            ..stored
        };
        if let Some(photo) = file.photo() {
            for &i in &together {
                planes[i] = Some(photo_planes(photo, &sources[i], window, colorspace)?);
            }
            if !file.holding.stay {
                photo.release();
            }
        }
        if let Some(file) = file.exr() {
            let wanted: Vec<_> = together
                .iter()
                .flat_map(|&i| sources[i].channels())
                .collect();
            let row = |y: i32| (y - stored.y0) as usize;
            let rows = (window != stored).then(|| row(window.y0)..row(window.y1));
            let mut read = file.read_some(&wanted, rows)?.into_iter();
            for &i in &together {
                planes[i] = sources[i].layer.as_ref().map(|layer| {
                    let count = layer.channels.len() + usize::from(layer.alpha.is_some());
                    RolePlanes::of_layer(layer, read.by_ref().take(count).collect(), window)
                });
                if sources[i].role.is_color() && colorspace == Some(ColorSpace::Srgb) {
                    planes[i].iter_mut().for_each(RolePlanes::decode);
                }
            }
        }
    }
    Ok(planes.into_iter().flatten().collect())
}

/// A photo is treated as colour only if colour or light is wanted: then it is linear and multiplied by its alpha, like
/// a frame's picture. As data its values are used as stored.
fn photo_planes(
    photo: &StoredPhoto,
    source: &RoleSource,
    window: Window,
    colorspace: Option<ColorSpace>,
) -> Result<RolePlanes> {
    let role = source.role;
    let is_linear = colorspace.is_some_and(|space| space != ColorSpace::Srgb);
    let meaning = match role.is_color() && !is_linear {
        true => CodeMeaning::Linear,
        false => CodeMeaning::Stored,
    };
    let is_coarse = photo.header.bits == 8 && photo.header.may_hold_coded_vectors();
    if role == Role::Normal && (is_coarse || source.noise() > 0.0) {
        return mended_vectors(photo, window, source);
    }
    let planes = source.planes_of(photo, window.y0 as usize..window.y1 as usize, meaning)?;
    if role == Role::Depth && is_colourful(&planes[..planes.len().min(3)]) {
        return Err(Error::Unsupported {
            path: source.file.path().to_path_buf(),
            found: "is in colours, and depth or height is one number".into(),
            remedy: "give the numbers themselves, as a grey picture, EXR, TIFF or NPY".into(),
        });
    }
    let mut read = RolePlanes::of_photo(photo, planes, window);
    if role.is_color() {
        let bits = source.file.bits_of_floats();
        if let Some(bits) = bits {
            let planes = read.planes.iter_mut().chain(&mut read.alpha);
            planes.for_each(|plane| *plane = plane.map(|v| v / max_code(bits) as f32));
        }
        read.premultiply();
        let is_encoded = colorspace.map_or(bits.is_some(), |space| space == ColorSpace::Srgb);
        if is_encoded && photo.header.is_float {
            read.decode();
        }
    }
    if source.is_pair() && source.holds_codes() {
        read.decode_pair();
    }
    Ok(read)
}

/// Whether the channels of a picture differ, and not by the errors of its coding.
fn is_colourful(channels: &[Plane]) -> bool {
    let [r, g, b] = channels else {
        return false;
    };
    let pixels = r.samples().iter().zip(g.samples()).zip(b.samples());
    let spread = pixels.map(|((r, g), b)| f64::from((r - g).abs() + (g - b).abs()));
    spread.sum::<f64>() > COLOURFUL * r.samples().len() as f64
}

/// The mean difference of green from red and blue in colours: in grey pictures JPEG leaves a few codes of 255.
const COLOURFUL: f64 = 0.05;

/// The vectors of a photo without the steps of coarse codes, and without noise.
fn mended_vectors(photo: &StoredPhoto, window: Window, source: &RoleSource) -> Result<RolePlanes> {
    let is_noisy = source.noise() > 0.0;
    let reach = UNROUNDING_REACH + usize::from(is_noisy) * DENOISING_REACH;
    let [first, last] = [window.y0, window.y1].map(|y| y as usize);
    let first = first.saturating_sub(reach) / UNROUNDING_PHASE * UNROUNDING_PHASE;
    let last = (last + reach).min(photo.header.height);
    let planes = source.planes_of(photo, first..last, CodeMeaning::Stored)?;
    let taken = Window {
        y0: first as i32,
        y1: last as i32,
        ..window
    };
    let mut read = RolePlanes::of_photo(photo, planes, taken);
    let mut vectors = Vector3Planes::of(read.planes);
    let borders = Borders::of(&vectors);
    let wraps = borders.wrapped(source.wrap);
    if photo.header.bits == 8 {
        if let Some(flat) = source.file.map_codes().and_then(|codes| codes.flat) {
            flatten(&mut vectors, flat);
        }
        let curves = [Mistake::Encoded, Mistake::Decoded].map(Some);
        if !curves.contains(&source.mistake()) {
            unround_wrapped(&mut vectors, photo.header.coding_error(), wraps);
        }
    }
    if is_noisy {
        denoise(&mut vectors, wraps);
    }
    read.borders = Some(borders);
    read.planes = vec![vectors.x, vectors.y, vectors.z];
    if source.is_pair() {
        read.decode_pair();
    }
    read.fit_to(Role::Normal, window);
    Ok(read)
}

/// Moves x and y of a flat surface, whose codes these are, to the middle between 127 and 128.
fn flatten(stored: &mut Vector3Planes, flat: [f32; 2]) {
    let vectors = stored.components_mut();
    let flats = vectors.filter(|[x, y, _]| [**x, **y] == flat);
    flats.for_each(|[x, y, _]| [*x, *y] = [0.5; 2]);
}
