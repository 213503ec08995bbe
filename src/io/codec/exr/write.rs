//! Parts to be written, and their headers.

use super::OutputCompression;
use super::attributes::{Attributes, MAX_NAME};
use super::header::{VERSION, typed};
use crate::error::{Error, Result};
use crate::frame::{Plane, Window};
use crate::io::text::is_one_of;
use ::exr::meta::header::Header;
use std::path::Path;

/// OpenEXR's standard attribute of pixels per inch along x.
pub(crate) const X_DENSITY: &str = "xDensity";
/// Attributes that describe the part and are not free to be given.
const RESERVED: &str = "channels compression dataWindow displayWindow lineOrder pixelAspectRatio screenWindowCenter \
                        screenWindowWidth name type chunkCount tiles version maxSamplesPerPixel chromaticities timeCode \
                        preview envmap multiView dwaCompressionLevel";

/// A part to be written, with channels of the kind `C`.
#[derive(Debug, Clone, PartialEq)]
pub struct PartWith<C> {
    /// Its name. Where it is taken already a number is added.
    pub name: String,
    /// The pixels that are stored.
    pub data_window: Window,
    /// The pixels meant to be shown.
    pub display_window: Window,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The stored channels.
    pub channels: Vec<C>,
    /// More text attributes by name, such as "software"; `xDensity`, pixels per inch, is stored as a number.
    pub attributes: Vec<(String, String)>,
    /// x and y of the red, green and blue primaries and of white; `None` means Rec. 709.
    pub chromaticities: Option<[f32; 8]>,
    /// How the pixels are compressed. A lossy one is refused for channels that are no colour: names
    /// in `R`, `G` or `B` of a layer that has not all three, and in `Y`, `RY` or `BY`.
    pub compression: OutputCompression,
}

/// A part to be written with its samples; the channels are in any order.
pub type OutputPart<'a> = PartWith<OutputChannel<'a>>;

/// A part to be written whose samples come later, some rows at a time: by the full name and type of each channel, in the
/// order in which their planes will be given.
pub type PartDescription = PartWith<(String, OutputType)>;

/// A channel to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputChannel<'a> {
    /// Its full name, such as "relief.R".
    pub name: String,
    /// Its samples, of the size of the data window.
    pub plane: &'a Plane,
    /// How they are stored.
    pub sample_type: OutputType,
}

/// How samples are written, by the numbers in files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum OutputType {
    /// 16-bit floating point, rounded to nearest; what is too large becomes 65504 with its sign.
    /// Infinities and NaN stay what they are.
    Half = 1,
    /// 32-bit floating point.
    Float,
}

impl<C> PartWith<C> {
    /// The same with other channels.
    pub(super) fn with<D>(&self, channels: Vec<D>) -> PartWith<D> {
        PartWith {
            name: self.name.clone(),
            data_window: self.data_window,
            display_window: self.display_window,
            pixel_aspect: self.pixel_aspect,
            channels,
            attributes: self.attributes.clone(),
            chromaticities: self.chromaticities,
            compression: self.compression,
        }
    }
}

impl OutputPart<'_> {
    /// The same without its samples.
    pub fn description(&self) -> PartDescription {
        let channels = self.channels.iter();
        self.with(channels.map(|c| (c.name.clone(), c.sample_type)).collect())
    }

    /// The planes of all channels, in their order.
    pub(super) fn planes(&self) -> Vec<&Plane> {
        self.channels.iter().map(|c| c.plane).collect()
    }
}

/// Where the samples of a channel come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SampleSource {
    /// The plane given with this index.
    Given(usize, OutputType),
    /// A channel of the part that is added to: bytes of a pixel before it.
    Carried { before: usize },
}

/// A part whose header has been made.
pub(super) struct ReadyPart {
    pub(super) attributes: Attributes,
    pub(super) header: Header,
    /// Where each channel comes from, sorted by name, as the file needs them.
    pub(super) sources: Vec<SampleSource>,
}

impl ReadyPart {
    /// Makes the header of `part`; `shared` is the first part of the file it is added to.
    pub(super) fn new(
        part: &PartDescription,
        target: &Path,
        shared: Option<&Attributes>,
    ) -> Result<Self> {
        let order = sorted_channels(part)?;
        let names: Vec<&str> = part.channels.iter().map(|(n, _)| n.as_str()).collect();
        part.compression.check_channels(&names)?;
        let mut attributes = attributes_of(part, &order)?;
        if let Some(shared) = shared {
            share(&mut attributes, shared);
        }
        let given = |&i: &usize| SampleSource::Given(i, part.channels[i].1);
        let sources = order.iter().map(given).collect();
        let mut ready = Self::of(attributes, sources, target)?;
        ready.attributes.sort();
        Ok(ready)
    }

    /// The part with these attributes, but for the number of chunks, which follows from them.
    pub(super) fn of(
        mut attributes: Attributes,
        sources: Vec<SampleSource>,
        target: &Path,
    ) -> Result<Self> {
        let typed = typed(VERSION, std::slice::from_ref(&attributes));
        let header = typed.map_err(|fault| fault.at(target))?.headers.remove(0);
        attributes.set_int("chunkCount", header.chunk_count as i32);
        Ok(ReadyPart {
            attributes,
            header,
            sources,
        })
    }
}

/// The indices of the channels, in the order of their names.
pub(super) fn sorted_channels(part: &PartDescription) -> Result<Vec<usize>> {
    let name = |i: usize| part.channels[i].0.as_str();
    let mut order: Vec<usize> = (0..part.channels.len()).collect();
    order.sort_by_key(|&i| name(i).as_bytes());
    for &i in &order {
        check_name("channel name", name(i))?;
    }
    match order.windows(2).find(|pair| name(pair[0]) == name(pair[1])) {
        Some(pair) => Err(Error::BadParameter {
            name: "channel name",
            found: format!("{:?} is used twice", name(pair[0])),
            remedy: "give each channel a name of its own".into(),
        }),
        None => Ok(order),
    }
}

fn check_name(what: &'static str, name: &str) -> Result<()> {
    match name.is_empty() || name.len() > MAX_NAME || name.contains('\0') {
        true => Err(Error::BadParameter {
            name: what,
            found: format!("is {name:?}"),
            remedy: format!("use 1 to {MAX_NAME} bytes without a zero byte"),
        }),
        false => Ok(()),
    }
}

fn attributes_of(part: &PartDescription, order: &[usize]) -> Result<Attributes> {
    if part.data_window.width() == 0 || part.data_window.height() == 0 || order.is_empty() {
        return Err(Error::BadParameter {
            name: "output",
            found: format!("has {} channels, {}", order.len(), part.data_window),
            remedy: "write at least one channel and one pixel".into(),
        });
    }
    let mut attributes = Attributes::default();
    let entry = |&i: &usize| channel_entry(&part.channels[i].0, part.channels[i].1);
    let mut list: Vec<u8> = order.iter().flat_map(entry).collect();
    list.push(0);
    attributes.set("channels", "chlist", list);
    attributes.set("compression", "compression", vec![part.compression.code()]);
    attributes.set_window("dataWindow", part.data_window);
    attributes.set_window("displayWindow", part.display_window);
    attributes.set("lineOrder", "lineOrder", vec![0]);
    attributes.set_text("name", &part.name);
    attributes.set_floats("pixelAspectRatio", "float", &[part.pixel_aspect]);
    attributes.set_floats("screenWindowCenter", "v2f", &[0.0, 0.0]);
    attributes.set_floats("screenWindowWidth", "float", &[1.0]);
    attributes.set_text("type", "scanlineimage");
    if let Some(chromaticities) = part.chromaticities {
        attributes.set_floats("chromaticities", "chromaticities", &chromaticities);
    }
    set_added(&mut attributes, part)?;
    Ok(attributes)
}

/// Sets the attributes that are added to those a part has by itself.
pub(super) fn set_added(attributes: &mut Attributes, part: &PartDescription) -> Result<()> {
    for (name, text) in &part.attributes {
        check_attribute_name(name)?;
        match text.parse::<f32>() {
            Ok(density) if name == X_DENSITY => attributes.set_floats(name, "float", &[density]),
            _ => attributes.set_text(name, text),
        }
    }
    Ok(())
}

pub(super) fn check_attribute_name(name: &str) -> Result<()> {
    match is_one_of(name, RESERVED) {
        true => Err(Error::BadParameter {
            name: "attribute",
            found: format!("{name:?} describes the file itself"),
            remedy: "use another name".into(),
        }),
        false => check_name("attribute", name),
    }
}

/// A channel in the list of channels.
pub(super) fn channel_entry(name: &str, sample_type: OutputType) -> Vec<u8> {
    let mut bytes = name.as_bytes().to_vec();
    bytes.push(0);
    bytes.extend_from_slice(&(sample_type as i32).to_le_bytes());
    bytes.extend_from_slice(&[0; 4]); // not perceptually linear, three bytes unused
    bytes.extend_from_slice(&1i32.to_le_bytes());
    bytes.extend_from_slice(&1i32.to_le_bytes());
    bytes
}

/// Attributes that all parts of a file share.
const SHARED: [&str; 4] = [
    "displayWindow",
    "pixelAspectRatio",
    "chromaticities",
    "timeCode",
];

/// Takes over what all parts of a file must have in common.
fn share(attributes: &mut Attributes, first: &Attributes) {
    for name in SHARED {
        match first.get(name) {
            Some(a) => attributes.set(name, &String::from_utf8_lossy(&a.kind), a.value.clone()),
            None => attributes.remove(name),
        }
    }
}
