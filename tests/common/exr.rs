//! The writer of input files, independent of the code under test: any names, parts, windows and attributes, nothing
//! compressed.

use half::f16;
use relievo::frame::{Plane, Window};
use relievo::io::exr::{ChannelId, ExrFile, Limits};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Type of stored samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stored {
    Half,
    Float,
}

/// One part of a file.
#[derive(Debug, Clone)]
pub struct Part {
    pub name: Option<String>,
    pub window: Window,
    pub channels: Vec<(String, Stored, Plane)>,
    /// Name, type and bytes.
    pub attributes: Vec<(String, &'static str, Vec<u8>)>,
}

impl Part {
    pub fn new(window: Window) -> Self {
        Self {
            name: None,
            window,
            channels: Vec::new(),
            attributes: Vec::new(),
        }
    }

    /// Channels of 32 bits and one size.
    pub fn of<'a, N: AsRef<str>>(channels: impl IntoIterator<Item = (N, &'a Plane)>) -> Self {
        let channels: Vec<_> = channels
            .into_iter()
            .map(|(name, plane)| (name.as_ref().into(), Stored::Float, plane.clone()))
            .collect();
        let first = &channels[0].2;
        let window = Window::from_size(first.width(), first.height());
        Self {
            channels,
            ..Self::new(window)
        }
    }

    /// Writes a file of this part alone.
    pub fn write(self, path: &Path) {
        write(path, self.window, &[self]);
    }

    pub fn named(mut self, name: &str) -> Self {
        self.name = Some(name.into());
        self
    }

    pub fn channel(mut self, name: &str, stored: Stored, plane: &Plane) -> Self {
        self.channels.push((name.into(), stored, plane.clone()));
        self
    }

    pub fn text(mut self, name: &str, value: &str) -> Self {
        self.attributes
            .push((name.into(), "string", value.as_bytes().to_vec()));
        self
    }

    pub fn floats(mut self, name: &str, kind: &'static str, values: &[f64]) -> Self {
        let bytes = values.iter().flat_map(|v| (*v as f32).to_le_bytes());
        self.attributes.push((name.into(), kind, bytes.collect()));
        self
    }

    pub fn chromaticities(self, values: [f32; 8]) -> Self {
        self.floats("chromaticities", "chromaticities", &values.map(f64::from))
    }

    fn sorted(&self) -> Vec<&(String, Stored, Plane)> {
        let mut channels: Vec<_> = self.channels.iter().collect();
        channels.sort_by(|a, b| a.0.cmp(&b.0));
        channels
    }

    fn header(&self, display: Window, multi: bool) -> Vec<u8> {
        let mut out = Vec::new();
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            for text in [name, kind] {
                out.extend_from_slice(text.as_bytes());
                out.push(0);
            }
            out.extend_from_slice(&(value.len() as i32).to_le_bytes());
            out.extend_from_slice(value);
        };
        let corners = |w: Window| {
            [w.x0, w.y0, w.x1 - 1, w.y1 - 1]
                .map(i32::to_le_bytes)
                .concat()
        };
        let mut list = Vec::new();
        for (name, stored, _) in self.sorted() {
            list.extend_from_slice(name.as_bytes());
            list.push(0);
            let kind: i32 = if *stored == Stored::Half { 1 } else { 2 };
            list.extend([kind, 0, 1, 1].map(i32::to_le_bytes).concat());
        }
        list.push(0);
        attribute("channels", "chlist", &list);
        attribute("compression", "compression", &[0]);
        attribute("dataWindow", "box2i", &corners(self.window));
        attribute("displayWindow", "box2i", &corners(display));
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
        if let Some(name) = &self.name {
            attribute("name", "string", name.as_bytes());
        }
        if multi {
            attribute("type", "string", b"scanlineimage");
            let rows = self.window.height() as i32;
            attribute("chunkCount", "int", &rows.to_le_bytes());
        }
        for (name, kind, value) in &self.attributes {
            attribute(name, kind, value);
        }
        out.push(0);
        out
    }

    /// The row `y` of every channel, channel after channel.
    fn row(&self, y: usize) -> Vec<u8> {
        let mut out = Vec::new();
        for (_, stored, plane) in self.sorted() {
            for &v in plane.row(y) {
                match stored {
                    Stored::Half => out.extend(f16::from_f32(v).to_le_bytes()),
                    Stored::Float => out.extend(v.to_le_bytes()),
                }
            }
        }
        out
    }
}

/// Writes a file of these parts.
pub fn write(path: &Path, display: Window, parts: &[Part]) {
    let multi = parts.len() > 1;
    // Version 2, long names, and perhaps several parts.
    let flags = 2u32 | 1 << 10 | if multi { 1 << 12 } else { 0 };
    let mut out = [0x0131_2f76u32, flags].map(u32::to_le_bytes).concat();
    for part in parts {
        out.extend(part.header(display, multi));
    }
    if multi {
        out.push(0);
    }
    let (rows, index) = (
        |part: &Part| 0..part.window.height(),
        if multi { 4 } else { 0 },
    );
    let count: usize = parts.iter().map(|part| part.window.height()).sum();
    let mut offset = out.len() + 8 * count;
    for part in parts {
        let chunk = index + 8 + part.row(0).len();
        for _ in rows(part) {
            out.extend((offset as u64).to_le_bytes());
            offset += chunk;
        }
    }
    let mut file = BufWriter::new(File::create(path).unwrap());
    let mut put = |bytes: &[u8]| file.write_all(bytes).unwrap();
    put(&out);
    for (i, part) in parts.iter().enumerate() {
        for y in rows(part) {
            let row = part.row(y);
            put(&(i as i32).to_le_bytes()[..index]);
            put(&(part.window.y0 + y as i32).to_le_bytes());
            put(&(row.len() as i32).to_le_bytes());
            put(&row);
        }
    }
    file.flush().unwrap();
}

/// The full name of one of our channels: `relievo.CurvatureKappa.V` of `curvature.kappa`.
pub fn full(short: &str) -> String {
    let Some((layer, component)) = short.rsplit_once('.') else {
        return short.into();
    };
    let capital = |word: &str| match word.split_at(1) {
        (first, rest) if first.starts_with(char::is_numeric) => format!("_{first}{rest}"),
        (first, rest) => first.to_uppercase() + rest,
    };
    match layer {
        "relievo" => format!("relievo.Picture.{component}"),
        "normal" => format!("relievo.Normal.{component}"),
        _ => {
            let words = layer.split('_').chain([component]);
            format!("relievo.{}.V", words.map(capital).collect::<String>())
        }
    }
}

/// The first channel called so, or so in full, of any part.
pub fn channel(path: &Path, name: &str) -> Plane {
    let file = ExrFile::open(path, &Limits::default()).unwrap();
    let names = [name.to_string(), full(name)];
    let is_it = |id: &ChannelId| names.contains(&file.parts[id.part].channels[id.channel].name);
    let id = file.channel_ids().find(is_it);
    let id = id.unwrap_or_else(|| panic!("no {name} in {}", path.display()));
    file.read_channels(&[id]).unwrap().remove(0)
}
