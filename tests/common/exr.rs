//! A writer of plain OpenEXR files: any names, parts, windows and attributes, nothing compressed.

use half::f16;
use relievo::frame::{Plane, Window};
use std::path::Path;

/// How samples are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stored {
    Half,
    Float,
}

/// One part of a file.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub(crate) name: Option<&'static str>,
    pub(crate) window: Window,
    pub(crate) channels: Vec<(String, Stored, Plane)>,
    /// Name, type and bytes.
    pub(crate) attributes: Vec<(String, &'static str, Vec<u8>)>,
}

impl Part {
    pub(crate) fn new(window: Window) -> Self {
        Self {
            name: None,
            window,
            channels: Vec::new(),
            attributes: Vec::new(),
        }
    }

    pub(crate) fn named(mut self, name: &'static str) -> Self {
        self.name = Some(name);
        self
    }

    pub(crate) fn channel(mut self, name: &str, stored: Stored, plane: &Plane) -> Self {
        self.channels.push((name.into(), stored, plane.clone()));
        self
    }

    pub(crate) fn text(mut self, name: &str, value: &str) -> Self {
        self.attributes
            .push((name.into(), "string", value.as_bytes().to_vec()));
        self
    }

    pub(crate) fn floats(mut self, name: &str, kind: &'static str, values: &[f64]) -> Self {
        let bytes = values.iter().flat_map(|v| (*v as f32).to_le_bytes());
        self.attributes.push((name.into(), kind, bytes.collect()));
        self
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
        if let Some(name) = self.name {
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
pub(crate) fn write(path: &Path, display: Window, parts: &[Part]) {
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
    let chunks: Vec<Vec<u8>> = parts
        .iter()
        .enumerate()
        .flat_map(|(i, part)| (0..part.window.height()).map(move |y| (i, part, y)))
        .map(|(i, part, y)| {
            let row = part.row(y);
            let mut chunk = Vec::new();
            if multi {
                chunk.extend((i as i32).to_le_bytes());
            }
            chunk.extend((part.window.y0 + y as i32).to_le_bytes());
            chunk.extend((row.len() as i32).to_le_bytes());
            chunk.extend(row);
            chunk
        })
        .collect();
    let mut offset = (out.len() + 8 * chunks.len()) as u64;
    for chunk in &chunks {
        out.extend(offset.to_le_bytes());
        offset += chunk.len() as u64;
    }
    out.extend(chunks.concat());
    std::fs::write(path, out).unwrap();
}
