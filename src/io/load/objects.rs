//! Object selection by names or numbers: the coverage of the chosen objects in each pixel.

use super::cryptomatte::{self, Cryptomatte, coverage};
use super::opened::Opened;
use crate::error::{Error, Result};
use crate::frame::objects::Objects;
use crate::frame::{Mask, Plane, Vector3Planes, Window};
use crate::io::exr::{ChannelId, ExrFile};
use crate::io::inputs::Inputs;
use crate::io::roles::nearest;
use crate::io::roles::{Layer, Match, Role, by_name};
use crate::params::{Fallback, ObjectAngle};
use crate::untrusted::{Untrusted, listed, shown};
use glam::{Vec2, Vec3};
use serde::Serialize;
use std::path::Path;
use std::rc::Rc;
use wildmatch::WildMatch;

/// How many names a message lists.
const LISTED: usize = 8;

/// Ranks of passes that tell objects apart, the best first: Cryptomatte of objects, their index, other Cryptomatte, that of
/// materials, their index.
const INDEX_OF_OBJECTS: u8 = 1;
const INDEX_OF_MATERIALS: u8 = 4;

/// Most bytes of samples that are read for a survey.
const MOST_SURVEYED: usize = 256 << 20;

/// A layer of Cryptomatte.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectSurvey {
    /// Its name.
    pub layer: String,
    /// Names of its objects; where no manifest has them, `#` and the hashes of the largest ones.
    pub names: Vec<String>,
    /// Shares of the picture that those of these hashes cover, 0..1; empty where there are names.
    pub shares: Vec<f64>,
}

/// Where a picture has objects: their numbers in each layer of Cryptomatte, and those in passes that hold one for each pixel.
struct FoundObjects {
    hashed: Vec<Vec<u32>>,
    indices: Vec<(ChannelId, f32)>,
}

/// The layers of Cryptomatte, with the names of their objects; without a manifest, the numbers of the largest objects in
/// the form of `--object`, with their shares of the picture, or of as much of its middle as is read.
///
/// # Errors
/// As [`cryptomatte::layers`].
pub(crate) fn surveyed(file: &ExrFile) -> Result<Vec<ObjectSurvey>> {
    let layers = cryptomatte::layers(file)?.into_iter();
    let survey = layers.map(|layer| {
        let (names, shares) = match layer.manifest.is_empty() {
            true => largest(file, &layer)
                .into_iter()
                .map(|(number, share)| (format!("#{number:08x}"), share))
                .unzip(),
            false => (layer.manifest.into_keys().collect(), Vec::new()),
        };
        ObjectSurvey {
            layer: layer.layer,
            names,
            shares,
        }
    });
    Ok(survey.collect())
}

/// The numbers of the largest objects of a layer and their shares; none where its samples are damaged.
fn largest(file: &ExrFile, layer: &Cryptomatte) -> Vec<(u32, f64)> {
    let channels = layer.channels();
    let window = file.parts[channels[0].part].window;
    let row = size_of::<f32>() * channels.len() * window.width();
    let rows = (MOST_SURVEYED / row.max(1)).clamp(1, window.height().max(1));
    let first = (window.height().saturating_sub(rows)) / 2;
    let last = (first + rows).min(window.height());
    if layer.spoilt(file).is_some() {
        return Vec::new();
    }
    let planes = file.read_rows(&channels, first..last);
    let largest = planes.map(|planes| cryptomatte::largest(&planes, LISTED));
    largest.unwrap_or_default()
}

/// Refuses a layer for a mask that holds the numbers of objects.
///
/// # Errors
/// [`Error::Unsupported`] for a layer of Cryptomatte or an index pass.
pub(crate) fn refuse_numbers(name: &str, main: &Opened) -> Result<()> {
    let Some(file) = main.exr() else {
        return Ok(());
    };
    let is_hashed = cryptomatte::layers(file)?
        .iter()
        .any(|layer| layer.holds(name));
    let indices = [Role::ObjectIndex, Role::MaterialIndex];
    let mut indices = indices
        .iter()
        .filter_map(|&role| by_name(&main.layers, role));
    let is_index = indices.any(|index| index.layer == name);
    match is_hashed || is_index {
        true => Err(Error::Unsupported {
            path: file.path.clone(),
            found: format!(
                "{} holds numbers of objects, and no coverage",
                Untrusted(name)
            ),
            remedy: "choose objects by name with --object NAME".into(),
        }),
        false => Ok(()),
    }
}

/// The file named to tell the objects of `main` apart, if one is.
///
/// # Errors
/// Any [`Error`] of opening it; [`Error::MissingAov`] for a file that tells none apart.
pub(crate) fn named(inputs: &Inputs, main: &Opened) -> Result<Option<Rc<Opened>>> {
    let Some(path) = &inputs.cryptomatte else {
        return Ok(None);
    };
    let named = main.open_companion(path)?;
    let hashed = named.exr().map(cryptomatte::layers).transpose()?;
    match index_pass(&named.layers).is_some() || hashed.is_some_and(|hashed| !hashed.is_empty()) {
        true => Ok(Some(named)),
        false => Err(untold(path)),
    }
}

/// The file that tells the objects of `main` apart, whose frame has this window: itself, or the one that is named.
///
/// # Errors
/// As [`named`]; [`Error::SizeMismatch`] for a file of other pixels.
pub(crate) fn file_of(inputs: &Inputs, main: &Rc<Opened>, whole: Window) -> Result<Rc<Opened>> {
    let Some(named) = named(inputs, main)? else {
        return Ok(main.clone());
    };
    let (display, _) = main.shown(whole);
    let Some(file) = named.exr() else {
        return Ok(named);
    };
    let mut stored = file.parts.iter().map(|part| part.window);
    match file.display_window == display || stored.all(|stored| stored == whole) {
        true => Ok(named),
        false => Err(Error::SizeMismatch {
            path: file.path.clone(),
            found: format!("{} (--cryptomatte)", file.display_window),
            expected: format!("{} has {display}", shown(main.path())),
        }),
    }
}

/// The pass that holds a number for each pixel: of its object, or else of its material.
fn index_pass(layers: &[Layer]) -> Option<Match> {
    let mut roles = [Role::ObjectIndex, Role::MaterialIndex].into_iter();
    roles.find_map(|role| by_name(layers, role))
}

/// How much of each pixel of `window` the objects cover that are chosen, 0..1.
///
/// # Errors
/// Any [`Error`] of reading; [`Error::MissingAov`] for a picture that tells no objects apart, or has none of this name.
pub(crate) fn covered(chosen: &[String], of: &Opened, window: Window) -> Result<Plane> {
    let names = chosen.iter().map(String::as_str);
    let (unwanted, wanted): (Vec<&str>, Vec<&str>) = names.partition(|name| name.starts_with('!'));
    let unwanted: Vec<&str> = unwanted.iter().map(|name| &name[1..]).collect();
    let (Some(file), layers) = (of.exr(), &of.layers) else {
        return Err(untold(of.path()));
    };
    let mut hashed = cryptomatte::layers(file)?;
    hashed.retain(|layer| !layer.channels().into_iter().any(|id| of.is_apart(id)));
    let find = |names: &[&str]| {
        let mut found = FoundObjects {
            hashed: vec![Vec::new(); hashed.len()],
            indices: Vec::new(),
        };
        let mut names = names.iter();
        let all = names.try_for_each(|name| found.add(name, file, layers, &hashed));
        all.map(|()| found)
    };
    let (found, left_out) = (find(&wanted)?, find(&unwanted)?);
    let sum = |found: &FoundObjects, excluded| summed(found, excluded, file, &hashed, window);
    let mut covered = match wanted.is_empty() {
        true => Plane::filled(window.width(), window.height(), 1.0),
        false => sum(&found, Some(&left_out))?,
    };
    if !unwanted.is_empty() {
        let without = sum(&left_out, None)?;
        // Of objects by material and by name it is not known how they overlap: as little is left out as may be.
        covered.each_with(&without, |share, without| *share = share.min(1.0 - without));
    }
    Ok(covered)
}

/// The objects in each pixel of `mask`, by the first pass in which they differ; with its name. `None` where nothing tells them
/// apart.
///
/// # Errors
/// Any [`Error`] of reading.
pub(crate) fn numbered(
    of: &Opened,
    mask: &Mask,
    window: Window,
) -> Result<Option<(String, Objects)>> {
    let Some(file) = of.exr() else {
        return Ok(None);
    };
    for (rank, name, channel) in passes(of, file)? {
        let (planes, own) = read(file, &[channel], window)?;
        let mut numbers = planes[0].moved(own, window, 0.0);
        if let INDEX_OF_OBJECTS | INDEX_OF_MATERIALS = rank {
            // Lossy compression alters them a little.
            numbers = numbers.map(f32::round);
        }
        let found = Objects::of(&numbers, mask);
        if found != Objects::Alike {
            return Ok(Some((name, found)));
        }
    }
    Ok(None)
}

/// The passes that tell objects apart, by rank, with their names and the channels of numbers.
fn passes(of: &Opened, file: &ExrFile) -> Result<Vec<(u8, String, ChannelId)>> {
    let mut hashed = cryptomatte::layers(file)?;
    hashed.retain(|layer| layer.spoilt(file).is_none() && !of.is_apart(layer.channels()[0]));
    let hashed = hashed.into_iter().map(|layer| {
        let name = layer.layer.to_lowercase();
        let rank = match (name.contains("object"), name.contains("material")) {
            (true, _) => INDEX_OF_OBJECTS - 1,
            (false, false) => INDEX_OF_OBJECTS + 1,
            (false, true) => INDEX_OF_MATERIALS - 1,
        };
        // The channel of the largest share.
        let first = layer.channels()[0];
        (rank, layer.layer, first)
    });
    let index = |role, rank| {
        let found = by_name(&of.layers, role)?;
        let channel = found.ids().next()?;
        Some((rank, found.layer, channel))
    };
    let indices = [
        index(Role::ObjectIndex, INDEX_OF_OBJECTS),
        index(Role::MaterialIndex, INDEX_OF_MATERIALS),
    ];
    let mut passes: Vec<_> = hashed.chain(indices.into_iter().flatten()).collect();
    passes.sort_by_key(|(rank, ..)| *rank);
    Ok(passes)
}

/// Where strokes go on the objects that have a direction of their own, as [`crate::frame::Frame::stroke_fallback`] holds
/// it: where an object covers more than half of a pixel. Of several that do, the last one counts. `None` where there are
/// no `angles`.
///
/// # Errors
/// As [`covered`].
pub(crate) fn fallbacks(
    angles: &[ObjectAngle],
    of: &Opened,
    window: Window,
) -> Result<Option<Vector3Planes>> {
    if angles.is_empty() {
        return Ok(None);
    }
    let zero = Plane::filled(window.width(), window.height(), 0.0);
    let mut found = Vector3Planes::of(vec![zero; 3]);
    for ObjectAngle { name, fallback } in angles {
        let covered = covered(std::slice::from_ref(name), of, window)?;
        let own = match fallback {
            Fallback::Surface => Vec3::Z,
            Fallback::Angle(degrees) => {
                Vec2::from_angle((2.0 * (degrees % 180.0)).to_radians()).extend(0.0)
            }
        };
        for (components, &share) in found.components_mut().zip(covered.samples()) {
            if share > 0.5 {
                let pairs = components.into_iter().zip(own.to_array());
                pairs.for_each(|(component, own)| *component = own);
            }
        }
    }
    Ok(Some(found))
}

impl FoundObjects {
    /// Adds the objects of this name: with `*` and `?` for any letters, or a number of an object or a material.
    fn add(
        &mut self,
        name: &str,
        file: &ExrFile,
        layers: &[Layer],
        hashed: &[Cryptomatte],
    ) -> Result<()> {
        // The name of an object is no pattern and no number, whatever its letters.
        let is_exact = hashed.iter().any(|layer| layer.manifest.contains_key(name));
        let pattern = WildMatch::new(name);
        let is_called = |own: &str| match is_exact {
            true => own == name,
            false => pattern.matches(own),
        };
        let by_number = cryptomatte::number(name).filter(|_| !is_exact);
        // Objects missing from the manifest are found by the hash of their name.
        let is_plain = !name.contains(['*', '?', '#']);
        let mut is_there = false;
        for (numbers, layer) in self.hashed.iter_mut().zip(hashed) {
            let objects = layer.manifest.iter();
            let called = objects.filter(|(own, _)| is_called(own));
            let is_hashed = is_plain && layer.manifest.is_empty();
            let before = numbers.len();
            numbers.extend(called.map(|(_, number)| *number));
            numbers.extend(by_number);
            numbers.extend(is_hashed.then(|| cryptomatte::hashed(name)));
            is_there |= numbers.len() > before;
        }
        if let Ok(number) = name.parse::<u16>()
            && let Some(index) = index_pass(layers).filter(|_| !is_exact)
        {
            self.indices
                .extend(index.ids().map(|index| (index, f32::from(number))));
            is_there = true;
        }
        match is_there {
            true => Ok(()),
            false => Err(unknown(name, file, layers, hashed)),
        }
    }
}

/// The shares of all that was found, without what is `excluded`: summed within each layer, the largest over layers.
fn summed(
    found: &FoundObjects,
    excluded: Option<&FoundObjects>,
    file: &ExrFile,
    hashed: &[Cryptomatte],
    window: Window,
) -> Result<Plane> {
    let mut covered = Plane::filled(window.width(), window.height(), 0.0);
    let mut take = |plane: &Plane, own: Window| {
        let moved = plane.moved(own, window, 0.0);
        covered.each_with(&moved, |largest, share| *largest = share.max(*largest));
    };
    for (i, layer) in hashed.iter().enumerate() {
        let mut numbers = found.hashed[i].clone();
        if let Some(excluded) = excluded {
            numbers.retain(|number| !excluded.hashed[i].contains(number));
        }
        if numbers.is_empty() {
            continue;
        }
        if let Some(channel) = layer.spoilt(file) {
            return Err(Error::Unsupported {
                path: file.path.clone(),
                found: format!("{channel} has been altered by a lossy compression"),
                remedy: "render Cryptomatte with ZIP compression".into(),
            });
        }
        let (planes, own) = read(file, &layer.channels(), window)?;
        take(&coverage(&planes, &numbers), own);
    }
    for (channel, number) in &found.indices {
        let (planes, own) = read(file, &[*channel], window)?;
        let is_it = |stored: f32| f32::from((stored - number).abs() < 0.5);
        take(&planes[0].map(is_it), own);
    }
    Ok(covered)
}

/// Channels of a part that holds `stored`, as far as it has the rows of `window`, and the window that they hold.
fn read(file: &ExrFile, channels: &[ChannelId], window: Window) -> Result<(Vec<Plane>, Window)> {
    let stored = file.parts[channels[0].part].window;
    let y0 = window.y0.clamp(stored.y0, stored.y1);
    let y1 = window.y1.clamp(y0, stored.y1);
    let row = |y: i32| (y - stored.y0) as usize;
    let planes = file.read_rows(channels, row(y0)..row(y1))?;
    Ok((planes, Window { y0, y1, ..stored }))
}

fn untold(path: &Path) -> Error {
    Error::MissingAov {
        path: path.to_path_buf(),
        found: "has no Cryptomatte and no pass of object indices".into(),
        remedy: "render either of them, name a file that has them with --cryptomatte FILE, or a mask with --mask LAYER|FILE"
            .into(),
    }
}

fn unknown(name: &str, file: &ExrFile, layers: &[Layer], hashed: &[Cryptomatte]) -> Error {
    let all: Vec<&str> = hashed
        .iter()
        .flat_map(|layer| layer.manifest.keys().map(String::as_str))
        .collect();
    let has_index = index_pass(layers).is_some();
    if hashed.is_empty() && !has_index {
        return untold(&file.path);
    }
    let called = Untrusted(name);
    let found = match (all.is_empty(), has_index) {
        (false, _) => format!("no object called {called} (found {})", first_of(&all)),
        (true, true) => format!("no object called {called}: its passes hold numbers"),
        (true, false) => "has Cryptomatte, and no manifest that names its objects".into(),
    };
    let remedy = match (nearest::likest(&all, name), all.is_empty(), has_index) {
        (Some(meant), ..) => format!("did you mean {}? * stands for any letters", Untrusted(meant)),
        (None, false, _) => "give one of them; * stands for any letters".into(),
        (None, true, true) => "give the number of an object, as in --object 2".into(),
        (None, true, false) => {
            "give names in full, or hashes, as in --object '#05777012', or render it with its manifest".into()
        }
    };
    Error::MissingAov {
        path: file.path.clone(),
        found,
        remedy,
    }
}

/// The first of these names, and how many more there are.
fn first_of(names: &[&str]) -> String {
    let first = listed(&names[..names.len().min(LISTED)]);
    match names.len().saturating_sub(LISTED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}
