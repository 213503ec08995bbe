//! Cryptomatte: how much of a pixel each named object covers ([CM], specification 1.2).
//!
//! A layer called `X` keeps its samples in channels `X00.R`, `X00.G`, `X00.B`, `X00.A`, `X01.R` and so on: pairs of an
//! object's number and its share of the pixel, 0..1, the largest share first. The number is the hash of the object's
//! name as the bits of a float; the manifest, in the header or in a file beside the picture, says which name has which.

use crate::error::{Error, Result};
use crate::frame::Plane;
use crate::io::exr::{ChannelId, ExrFile, SampleType};
use crate::io::open::read_text;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Prefix of the attributes of Cryptomatte.
const PREFIX: &str = "cryptomatte/";

/// Most bytes of the manifests in files of their own.
const MOST_OF_MANIFESTS: u64 = 32 << 20;

/// Most names in the manifests of a file; those of large scenes have 50,000.
const MOST_NAMES: usize = 500_000;

/// Most ranks of a layer; renderers write 6 to 16.
const MOST_RANKS: usize = 256;

/// Most layers of Cryptomatte in a file: three to a view layer are usual.
const MOST_LAYERS: usize = 256;

/// One layer of Cryptomatte: by object, by material, by asset.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cryptomatte {
    /// Its name, as `ViewLayer.CryptoObject`.
    pub(crate) layer: String,
    /// Names of objects with their numbers.
    pub(crate) manifest: BTreeMap<String, u32>,
    /// The channels of numbers and of shares, rank by rank.
    ranks: Vec<[ChannelId; 2]>,
}

/// What a file declares of a layer, by the last parts of the attributes' names.
type Declared<'f> = BTreeMap<String, Cow<'f, str>>;

/// All layers of Cryptomatte that a file has channels of: those that it declares, and those that look so where what it
/// declared was lost, as the names of objects are then.
///
/// # Errors
/// [`Error::Unsupported`] for more layers, ranks or names than any scene has.
pub(crate) fn layers(file: &ExrFile) -> Result<Vec<Cryptomatte>> {
    let mut declared: BTreeMap<String, Declared> = BTreeMap::new();
    for (name, text) in file.strings(PREFIX) {
        if let Some((id, what)) = name.split_once('/') {
            let own = declared.entry(id.to_owned()).or_default();
            own.entry(what.to_owned()).or_insert(text);
        }
    }
    let declared = declared.values();
    let mut named: Vec<(&str, &Declared)> = declared
        .filter_map(|declared| Some((declared.get("name")?.as_ref(), declared)))
        .collect();
    let mut lost: BTreeSet<&str> = looking_so(file).collect();
    for (layer, _) in &named {
        lost.remove(layer);
    }
    let nothing = Declared::new();
    named.extend(lost.into_iter().map(|layer| (layer, &nothing)));
    let excess = |found: String| Error::Unsupported {
        path: file.path.clone(),
        found,
        remedy: "remove its attributes that begin with cryptomatte/".into(),
    };
    if named.len() > MOST_LAYERS {
        let found = format!("declares {} layers of Cryptomatte", named.len());
        return Err(excess(found));
    }
    let (mut names, mut left) = (0, MOST_OF_MANIFESTS);
    let mut layers = Vec::new();
    for (layer, declared) in named {
        let ranks = ranks(file, layer);
        if ranks.is_empty() {
            continue;
        }
        if ranks.len() > MOST_RANKS {
            let found = format!("has {} ranks in a layer of Cryptomatte", ranks.len());
            return Err(excess(found));
        }
        let text = manifest_text(declared, &file.path, &mut left).unwrap_or_default();
        // A name and its number have four quotes.
        names += text.bytes().filter(|&byte| byte == b'"').count() / 4;
        if names > MOST_NAMES {
            let found = format!("names more than {MOST_NAMES} objects of Cryptomatte");
            return Err(excess(found));
        }
        layers.push(Cryptomatte {
            layer: layer.into(),
            manifest: manifest(&text).unwrap_or_default(),
            ranks,
        });
    }
    Ok(layers)
}

/// The manifest of a layer, from the header or the file that it names; `None` where there is none, or it cannot be read.
/// Of the bytes of such files as many are `left`.
fn manifest_text<'f>(
    declared: &'f Declared,
    picture: &Path,
    left: &mut u64,
) -> Option<Cow<'f, str>> {
    match (declared.get("manifest"), declared.get("manif_file")) {
        (Some(text), _) => Some(Cow::Borrowed(text)),
        (None, Some(name)) => {
            let path = picture
                .parent()?
                .join(Path::new(name.as_ref()).file_name()?);
            let text = read_text(&path, *left).ok()?;
            *left -= text.len() as u64;
            Some(Cow::Owned(text))
        }
        (None, None) => None,
    }
}

/// Names and numbers of objects; `None` where they cannot be read.
fn manifest(text: &str) -> Option<BTreeMap<String, u32>> {
    let numbers: BTreeMap<String, String> = serde_json::from_str(text).ok()?;
    let numbers = numbers.into_iter();
    let numbers = numbers.filter_map(|(name, number)| Some((name, parsed(&number)?)));
    Some(numbers.collect())
}

/// The number of an object of this name: its MurmurHash3 (32 bits, seed 0), with one bit flipped if the float of these
/// bits would be NaN, infinite or denormal ([CM], specification 1.2).
pub(crate) fn hashed(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    match (hash >> 23) & 0xff {
        0 | 0xff => hash ^ (1 << 23),
        _ => hash,
    }
}

/// MurmurHash3_x86_32 by Austin Appleby, which is in the public domain, with seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let scrambled = |block: u32| {
        let block = block.wrapping_mul(0xcc9e_2d51).rotate_left(15);
        block.wrapping_mul(0x1b87_3593)
    };
    let mut blocks = bytes.chunks_exact(4);
    let mut hash = 0u32;
    for block in &mut blocks {
        let block = u32::from_le_bytes([block[0], block[1], block[2], block[3]]);
        hash = (hash ^ scrambled(block)).rotate_left(13);
        hash = hash.wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    let rest = blocks.remainder().iter().rev();
    let rest = rest.fold(0, |rest, &byte| rest << 8 | u32::from(byte));
    hash ^= scrambled(rest) ^ bytes.len() as u32;
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}

/// The number that a user gives for an object: `#05777012`, `0x05777012`, or the eight digits of manifests alone.
pub(crate) fn number(given: &str) -> Option<u32> {
    let marks = ["#", "0x", "0X"].into_iter();
    let marked = marks.filter_map(|mark| given.strip_prefix(mark)).next();
    parsed(marked.or_else(|| (given.len() == 8).then_some(given))?)
}

fn parsed(hex: &str) -> Option<u32> {
    u32::from_str_radix(hex, 16).ok()
}

/// The channels of `layer`, rank by rank; those of a part that lacks one of a pair are left out.
fn ranks(file: &ExrFile, layer: &str) -> Vec<[ChannelId; 2]> {
    let mut found: BTreeMap<(u32, usize), ChannelId> = BTreeMap::new();
    for id in file.channel_ids() {
        let name = &file.parts[id.part].channels[id.channel].name;
        if let Some(place) = place(name, layer) {
            found.entry(place).or_insert(id);
        }
    }
    let pairs = found
        .iter()
        .filter(|((_, component), _)| component % 2 == 0);
    let pairs = pairs.filter_map(|(&(level, component), &number)| {
        let share = *found.get(&(level, component + 1))?;
        (share.part == number.part).then_some([number, share])
    });
    pairs.collect()
}

/// What all layers of channels have before their numbers whose names and types are those of Cryptomatte.
fn looking_so(file: &ExrFile) -> impl Iterator<Item = &str> {
    let channels = file.parts.iter().flat_map(|part| &part.channels);
    let floats = channels.filter(|channel| channel.sample_type == SampleType::Float);
    floats.filter_map(|channel| {
        let (level, _) = channel.name.rsplit_once('.')?;
        let layer = level.trim_end_matches(|c: char| c.is_ascii_digit());
        let is_one = layer.to_ascii_lowercase().contains("crypto");
        (is_one && place(&channel.name, layer).is_some()).then_some(layer)
    })
}

/// The number of the layer of channels and the component, 0 to 3, of a channel that is one of `layer`.
fn place(channel: &str, layer: &str) -> Option<(u32, usize)> {
    let (level, component) = channel.strip_prefix(layer)?.split_once('.')?;
    let is_number = !level.is_empty() && level.bytes().all(|b| b.is_ascii_digit());
    let component = match component.to_ascii_lowercase().as_str() {
        "r" | "red" => 0,
        "g" | "green" => 1,
        "b" | "blue" => 2,
        "a" | "alpha" => 3,
        _ => return None,
    };
    is_number.then(|| Some((level.parse().ok()?, component)))?
}

impl Cryptomatte {
    /// Whether a layer called `name` is one of those that hold its samples.
    pub(crate) fn holds(&self, name: &str) -> bool {
        place(&format!("{name}.r"), &self.layer).is_some()
    }

    /// All of its channels.
    pub(crate) fn channels(&self) -> Vec<ChannelId> {
        self.ranks.iter().flatten().copied().collect()
    }

    /// The channel that a lossy compression has altered, if there is one: numbers must be kept bit for bit.
    pub(crate) fn spoilt<'f>(&self, file: &'f ExrFile) -> Option<&'f str> {
        let spoilt = |id: &&[ChannelId; 2]| file.parts[id[0].part].is_lossy(id[0].channel);
        let [number, _] = self.ranks.iter().find(spoilt)?;
        Some(&file.parts[number.part].channels[number.channel].name)
    }
}

/// How much of each pixel objects with these `numbers` cover, 0..1, from planes as [`Cryptomatte::channels`] names them.
pub(crate) fn coverage(planes: &[Plane], numbers: &[u32]) -> Plane {
    let (ranks, _) = planes.as_chunks::<2>();
    let [first, _] = &ranks[0];
    let mut covered = Plane::filled(first.width(), first.height(), 0.0);
    for [number, share] in ranks {
        let samples = number.samples().iter().zip(share.samples());
        for (sum, (number, share)) in covered.samples_mut().iter_mut().zip(samples) {
            // NaN is not a share.
            if *share > 0.0 && numbers.contains(&number.to_bits()) {
                *sum = (*sum + share).min(1.0);
            }
        }
    }
    covered
}

/// The `most` numbers that cover most, with their shares of all pixels, 0..1, the largest first, from planes as
/// [`Cryptomatte::channels`] names them.
pub(crate) fn largest(planes: &[Plane], most: usize) -> Vec<(u32, f64)> {
    let (ranks, _) = planes.as_chunks::<2>();
    let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
    for [number, share] in ranks {
        let samples = number.samples().iter().zip(share.samples());
        for (number, share) in
            samples.filter(|(number, share)| number.to_bits() != 0 && **share > 0.0)
        {
            *sums.entry(number.to_bits()).or_default() += f64::from(*share);
        }
    }
    let pixels = planes[0].samples().len().max(1) as f64;
    let mut shares: Vec<_> = sums
        .into_iter()
        .map(|(number, sum)| (number, sum / pixels))
        .collect();
    shares.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    shares.truncate(most);
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_those_of_a_layer_and_its_number() {
        let layer = "ViewLayer.CryptoObject";
        assert_eq!(place("ViewLayer.CryptoObject00.r", layer), Some((0, 0)));
        assert_eq!(place("ViewLayer.CryptoObject02.A", layer), Some((2, 3)));
        assert_eq!(place("ViewLayer.CryptoObject.r", layer), None);
        assert_eq!(place("ViewLayer.CryptoObjects00.r", layer), None);
        assert_eq!(place("ViewLayer.CryptoObject00.z", layer), None);
    }

    #[test]
    fn shares_of_all_ranks_are_summed_and_what_is_no_number_is_none() {
        let plane = |samples: [f32; 3]| Plane::from_samples(3, 1, samples.to_vec());
        let [a, b] = [f32::from_bits(0x3f12_3456), f32::from_bits(0x4098_7654)];
        let planes = [
            plane([a, b, a]),
            plane([0.5, 0.75, f32::NAN]),
            plane([b, a, 0.0]),
            plane([0.25, 0.25, 1.0]),
        ];
        let of = |numbers: &[f32]| {
            let numbers: Vec<u32> = numbers.iter().map(|n| n.to_bits()).collect();
            coverage(&planes, &numbers).into_samples()
        };
        assert_eq!(of(&[a]), [0.5, 0.25, 0.0]);
        assert_eq!(of(&[a, b]), [0.75, 1.0, 0.0]);
        assert_eq!(of(&[]), [0.0; 3]);
        // 0.5 and 0.25 of three pixels, and 0.75 and 0.25; the last share has no object.
        let numbers = [b, a].map(f32::to_bits);
        assert_eq!(
            largest(&planes, 9),
            [(numbers[0], 1.0 / 3.0), (numbers[1], 0.25)]
        );
        assert_eq!(largest(&planes, 1), [(numbers[0], 1.0 / 3.0)]);
    }
}
