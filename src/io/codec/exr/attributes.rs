//! Header attributes, byte for byte.
//!
//! They are kept as stored in the file, so that a copy reproduces every one of them: in the same order, of unknown
//! types, and with values no reader understands.

use super::fault::{Fault, Parsed};
use crate::frame::Window;
use crate::io::text::is_one_of;
use std::borrow::Cow;
use std::io::Read;

/// Longest name of an attribute, a type or a channel.
pub(super) const MAX_NAME: usize = 255;
/// Longest name that needs no flag in the file's version field.
pub(super) const MAX_SHORT_NAME: usize = 31;
/// Most bytes of all headers together; Cryptomatte manifests reach a few MiB.
const MAX_HEADER_BYTES: u64 = 32 << 20;
/// Most attributes of all headers together; renderers write hundreds to a part.
const MAX_ATTRIBUTES: usize = 1 << 16;
/// Longest rendering of an attribute as text, in characters.
const MAX_TEXT: usize = 4096;

/// Attributes of simple kinds that say how pixels are stored.
const PIXEL_NAMES: &str = "type name version chunkCount maxSamplesPerPixel dwaCompressionLevel";
/// Kinds of the others.
const PIXEL_KINDS: &str = "chlist compression box2i lineOrder tiledesc preview";

/// One attribute.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Attribute {
    pub(super) name: Vec<u8>,
    pub(super) kind: Vec<u8>,
    pub(super) value: Vec<u8>,
}

/// The attributes of one part, in the order of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Attributes(Vec<Attribute>);

impl Attributes {
    pub(super) fn get(&self, name: &str) -> Option<&Attribute> {
        self.0.iter().find(|a| a.name == name.as_bytes())
    }

    /// The value of the attribute `name`, if it is of the type `kind`.
    fn value(&self, name: &str, kind: &str) -> Option<&[u8]> {
        self.get(name)
            .filter(|a| a.kind == kind.as_bytes())
            .map(|a| a.value.as_slice())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Attribute> {
        self.0.iter()
    }

    /// Replaces the attribute `name`, or appends it.
    pub(super) fn set(&mut self, name: &str, kind: &str, value: Vec<u8>) {
        let attribute = Attribute {
            name: name.into(),
            kind: kind.into(),
            value,
        };
        match self.0.iter_mut().find(|a| a.name == attribute.name) {
            Some(old) => *old = attribute,
            None => self.0.push(attribute),
        }
    }

    /// Removes the attribute `name`, if there is one.
    pub(super) fn remove(&mut self, name: &str) {
        self.0.retain(|a| a.name != name.as_bytes());
    }

    pub(super) fn set_text(&mut self, name: &str, text: &str) {
        self.set(name, "string", text.into());
    }

    pub(super) fn set_int(&mut self, name: &str, value: i32) {
        self.set(name, "int", value.to_le_bytes().into());
    }

    pub(super) fn set_floats(&mut self, name: &str, kind: &str, values: &[f32]) {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.set(name, kind, bytes);
    }

    /// Stores a window, which must not be empty, with EXR's inclusive corners.
    pub(super) fn set_window(&mut self, name: &str, window: Window) {
        let corners = [window.x0, window.y0, window.x1 - 1, window.y1 - 1];
        let bytes = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.set(name, "box2i", bytes);
    }

    pub(super) fn sort(&mut self) {
        self.0.sort_by(|a, b| a.name.cmp(&b.name));
    }

    pub(super) fn text(&self, name: &str) -> Option<String> {
        self.value(name, "string").map(text_of_bytes)
    }

    pub(super) fn byte(&self, name: &str, kind: &str) -> Option<u8> {
        self.value(name, kind)?.first().copied()
    }

    pub(super) fn floats<const N: usize>(&self, name: &str, kind: &str) -> Option<[f32; N]> {
        exactly(elements(self.value(name, kind)?, f32::from_le_bytes))
    }

    /// Inclusive corners: left, top, right, bottom.
    pub(super) fn corners(&self, name: &str) -> Option<[i32; 4]> {
        exactly(elements(self.value(name, "box2i")?, i32::from_le_bytes))
    }

    /// Whether a name is too long for files without the long-name flag.
    pub(super) fn has_long_names(&self) -> bool {
        self.iter()
            .any(|a| a.name.len() > MAX_SHORT_NAME || a.kind.len() > MAX_SHORT_NAME)
    }

    /// Those that say where the pixels are and how they are stored, and those of their kinds, which must be sound too.
    pub(super) fn of_pixels(&self) -> Self {
        let all = self.iter().filter(|attribute| {
            is_one_of(&text_of_bytes(&attribute.name), PIXEL_NAMES)
                || is_one_of(&text_of_bytes(&attribute.kind), PIXEL_KINDS)
        });
        Self(all.cloned().collect())
    }

    /// Appends the attributes and the zero byte that ends them.
    pub(super) fn write_to(&self, bytes: &mut Vec<u8>) {
        for a in self.iter() {
            bytes.extend_from_slice(&a.name);
            bytes.push(0);
            bytes.extend_from_slice(&a.kind);
            bytes.push(0);
            bytes.extend_from_slice(&(a.value.len() as i32).to_le_bytes());
            bytes.extend_from_slice(&a.value);
        }
        bytes.push(0);
    }
}

/// Reads headers, never past the end of the file nor past the limit for all headers.
pub(super) struct HeaderReader<R> {
    read: R,
    pub(super) position: u64,
    file_len: u64,
    /// Attributes read so far.
    count: usize,
}

impl<R: Read> HeaderReader<R> {
    pub(super) fn new(read: R, file_len: u64) -> Self {
        HeaderReader {
            read,
            position: 0,
            file_len,
            count: 0,
        }
    }

    pub(super) fn array<const N: usize>(&mut self) -> Parsed<[u8; N]> {
        let mut bytes = [0; N];
        self.read.read_exact(&mut bytes)?;
        self.position += N as u64;
        Ok(bytes)
    }

    /// The attributes of the next part; empty where the list of parts ends.
    pub(super) fn attributes(&mut self) -> Parsed<Attributes> {
        let mut attributes = Attributes::default();
        loop {
            let name = self.name()?;
            if name.is_empty() {
                return Ok(attributes);
            }
            self.count += 1;
            if self.count > MAX_ATTRIBUTES {
                return Err(Fault::Unsupported {
                    found: format!("has more than {MAX_ATTRIBUTES} attributes"),
                    remedy: "remove those that are not needed",
                });
            }
            let kind = self.name()?;
            if kind.is_empty() {
                // The `exr` crate would read the following bytes as its type.
                let name = text_of_bytes(&name);
                return Err(Fault::Damaged(format!("attribute {name:?} has no type")));
            }
            let size = i32::from_le_bytes(self.array()?);
            let value = self.bytes(size, &name)?;
            attributes.0.push(Attribute { name, kind, value });
        }
    }

    /// Text up to a zero byte.
    fn name(&mut self) -> Parsed<Vec<u8>> {
        let mut name = Vec::new();
        loop {
            match self.array()? {
                [0] => return Ok(name),
                [byte] if name.len() < MAX_NAME => name.push(byte),
                _ => return Err(Fault::damaged("holds an attribute name that never ends")),
            }
        }
    }

    fn bytes(&mut self, size: i32, name: &[u8]) -> Parsed<Vec<u8>> {
        let left = self.file_len.saturating_sub(self.position);
        let Some(size) = u64::try_from(size).ok().filter(|&s| s <= left) else {
            let name = text_of_bytes(name);
            let found = format!("attribute {name:?} claims {size} bytes, the file has {left} left");
            return Err(Fault::Damaged(found));
        };
        if self.position + size > MAX_HEADER_BYTES {
            return Err(Fault::Unsupported {
                found: format!("has a header of more than {} MiB", MAX_HEADER_BYTES >> 20),
                remedy: "remove its large attributes",
            });
        }
        let mut bytes = vec![0; size as usize];
        self.read.read_exact(&mut bytes)?;
        self.position += size;
        Ok(bytes)
    }
}

/// Bytes as UTF-8, or as Latin-1 where they are not.
pub(super) fn text_of_bytes(bytes: &[u8]) -> String {
    text_or_latin(bytes).into_owned()
}

/// The same, without a copy where they are UTF-8.
pub(super) fn text_or_latin(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|&b| char::from(b)).collect()),
    }
}

impl Attribute {
    /// The value as text: numbers in the order of the file with blanks between them, so that they
    /// can be read back; types without a plain rendering as their name and size.
    pub(super) fn text(&self) -> String {
        let v = self.value.as_slice();
        let text = match self.kind.as_slice() {
            b"string" => text_or_latin(v),
            b"stringvector" => joined(strings(v)),
            b"float" | b"v2f" | b"v3f" | b"m33f" | b"m44f" | b"box2f" | b"chromaticities" => {
                joined(elements(v, f32::from_le_bytes))
            }
            b"double" | b"v2d" | b"v3d" | b"m33d" | b"m44d" => {
                joined(elements(v, f64::from_le_bytes))
            }
            b"int" | b"v2i" | b"v3i" | b"box2i" | b"rational" | b"keycode" => {
                joined(elements(v, i32::from_le_bytes))
            }
            b"timecode" => joined(elements(v, u32::from_le_bytes)),
            b"compression" | b"lineOrder" | b"envmap" => joined(v.iter()),
            kind => format!("({}, {} bytes)", text_of_bytes(kind), v.len()).into(),
        };
        shortened(&text)
    }
}

fn elements<const N: usize, T>(
    bytes: &[u8],
    element: impl Fn([u8; N]) -> T,
) -> impl Iterator<Item = T> {
    bytes.as_chunks().0.iter().map(move |&b| element(b))
}

/// The `values`, if there are `N` of them.
fn exactly<const N: usize, T>(values: impl Iterator<Item = T>) -> Option<[T; N]> {
    let values: Vec<T> = values.take(N + 1).collect();
    values.try_into().ok()
}

/// The values with blanks between them; no more of them than will be left of the text.
fn joined<T: ToString>(values: impl Iterator<Item = T>) -> Cow<'static, str> {
    let mut joined = String::new();
    for (i, value) in values.enumerate().take(MAX_TEXT + 2) {
        if i > 0 {
            joined.push(' ');
        }
        joined += &value.to_string();
    }
    joined.into()
}

/// The strings of a vector, as far as it is sound.
fn strings(mut bytes: &[u8]) -> impl Iterator<Item = String> {
    std::iter::from_fn(move || {
        let (size, rest) = bytes.split_first_chunk()?;
        let (text, rest) = rest.split_at_checked(u32::from_le_bytes(*size) as usize)?;
        bytes = rest;
        Some(text_of_bytes(text))
    })
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(MAX_TEXT) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}...", &text[..end]),
    }
}
