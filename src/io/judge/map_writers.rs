//! Whose normal maps have which axes reversed, recognised by what a file records or by its name.

use crate::io::open::open_buffered;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;

/// The program that wrote a map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapWriter {
    name: String,
    /// Whether the file records it, rather than its name alone.
    pub(crate) is_recorded: bool,
    /// Whether it reverses x, and y.
    pub(crate) reversed: [bool; 2],
}

impl fmt::Display for MapWriter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let by = match self.is_recorded {
            true => "as the file records",
            false => "by its name",
        };
        let axes = match self.reversed {
            [true, _] => "whose x points left",
            [false, true] => "whose y points down",
            [false, false] => "whose x points right and y up",
        };
        write!(f, "{by}, it is a map of {}, {axes}", self.name)
    }
}

const X_LEFT: [bool; 2] = [true, false];
const Y_DOWN: [bool; 2] = [false, true];

/// Words of file names, and what they stand for.
const NAMES: [(&str, &str, [bool; 2]); 10] = [
    ("dsine", "DSINE", X_LEFT),
    ("normalbae", "NormalBAE", X_LEFT),
    ("bae", "NormalBAE", X_LEFT),
    ("stablenormal", "StableNormal", X_LEFT),
    ("directx", "DirectX", Y_DOWN),
    ("normaldx", "DirectX", Y_DOWN),
    ("dx", "DirectX", Y_DOWN),
    ("opengl", "OpenGL", [false; 2]),
    ("normalgl", "OpenGL", [false; 2]),
    ("gl", "OpenGL", [false; 2]),
];

/// Nodes of ComfyUI that store (n + 1) / 2 of estimators whose x points left (their `dsine` and `normalbae` modules).
const NODES: [&str; 2] = ["DSINE-NormalMapPreprocessor", "BAE-NormalMapPreprocessor"];

/// The longest workflow that is inflated, in bytes.
const MOST_TEXT: usize = 1 << 22;

/// Most nodes on the way from a saved picture to the one that made it.
const MOST_NODES: usize = 64;

impl MapWriter {
    /// The one that the file at `path` records, or else that of its name.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        recorded(path).or_else(|| named(path))
    }
}

fn named(path: &Path) -> Option<MapWriter> {
    let name = path.file_stem()?.to_str()?.to_ascii_lowercase();
    let words: Vec<_> = name.split(|c: char| !c.is_ascii_alphanumeric()).collect();
    // Short words are letters within others.
    let stands_in = |word: &str| words.contains(&word) || word.len() > 3 && name.contains(word);
    let (_, name, reversed) = NAMES.iter().find(|(word, ..)| stands_in(word))?;
    Some(MapWriter {
        name: (*name).into(),
        is_recorded: false,
        reversed: *reversed,
    })
}

/// The estimator at the other end of the workflow that ComfyUI keeps in a PNG as text called `prompt`.
fn recorded(path: &Path) -> Option<MapWriter> {
    let file = open_buffered(path).ok()?;
    let reader = png::Decoder::new(file).read_info().ok()?;
    let info = reader.info();
    let mut plain = info.uncompressed_latin1_text.iter();
    let plain = plain.find(|text| text.keyword == "prompt");
    let text = match plain {
        Some(text) => text.text.clone(),
        None => {
            let mut texts = info.utf8_text.iter();
            let mut text = texts.find(|text| text.keyword == "prompt")?.clone();
            text.decompress_text_with_limit(MOST_TEXT).ok()?;
            text.get_text().ok()?
        }
    };
    let name = estimator(&serde_json::from_str(&text).ok()?)?;
    Some(MapWriter {
        name: format!("{name} of ComfyUI"),
        is_recorded: true,
        reversed: X_LEFT,
    })
}

/// The one of [`NODES`] whose picture is saved, on no way that changes it, where no other node makes normals that are saved; of
/// several saved pictures these are meant.
fn estimator(nodes: &Value) -> Option<&'static str> {
    let saved = nodes.as_object()?.values().filter(|node| {
        let class = node["class_type"].as_str().unwrap_or_default();
        class.starts_with("SaveImage") || class.starts_with("PreviewImage")
    });
    let found: BTreeSet<_> = saved.filter_map(|node| upstream(nodes, node)).collect();
    match found.len() {
        1 => found.into_iter().next().filter(|name| *name != UNKNOWN),
        _ => None,
    }
}

/// Another node that makes normals.
const UNKNOWN: &str = "";

/// The node that made the normals of a saved picture.
fn upstream(nodes: &Value, from: &Value) -> Option<&'static str> {
    let mut node = from;
    for _ in 0..MOST_NODES {
        let inputs = &node["inputs"];
        let link = ["images", "image"]
            .iter()
            .find_map(|key| inputs[*key][0].as_str())?;
        node = &nodes[link];
        let class = node["class_type"].as_str()?;
        if let Some(known) = NODES.iter().find(|known| **known == class) {
            return Some(known);
        }
        let class = class.to_ascii_lowercase();
        if class.contains("normal") {
            return Some(UNKNOWN);
        }
        if ["invert", "flip", "rotate", "channel"]
            .iter()
            .any(|turns| class.contains(turns))
        {
            return None;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_of_axes() {
        let axes = |name: &str| named(Path::new(name)).map(|writer| writer.reversed);
        for (name, expected) in [
            ("photo_dsine.png", X_LEFT),
            ("out/NormalBAE_00001_.png", X_LEFT),
            ("bae-7.png", X_LEFT),
            ("Bricks_1K-JPG_NormalDX.jpg", Y_DOWN),
            ("wall_nor_gl_1k.exr", [false; 2]),
        ] {
            assert_eq!(axes(name), Some(expected), "{name}");
        }
        for name in [
            "baroque.png",
            "normal.png",
            "dsine/normal.png",
            "glass_dxf.png",
            "",
        ] {
            assert_eq!(axes(name), None, "{name}");
        }
    }

    #[test]
    fn a_workflow_is_followed_from_what_is_saved_to_what_made_it() {
        let workflow = |saved: &str, way: &str| {
            let text = format!(
                r#"{{"1": {{"class_type": "LoadImage", "inputs": {{"image": "a.png"}}}},
                    "2": {{"class_type": "BAE-NormalMapPreprocessor", "inputs": {{"image": ["1", 0]}}}},
                    "3": {{"class_type": "{way}", "inputs": {{"image": ["2", 0]}}}},
                    "4": {{"class_type": "SaveImage", "inputs": {{"images": ["{saved}", 0]}}}},
                    "5": {{"class_type": "ImageScale", "inputs": {{"image": ["5", 0]}}}}}}"#
            );
            estimator(&serde_json::from_str(&text).unwrap())
        };
        let bae = Some("BAE-NormalMapPreprocessor");
        assert_eq!(workflow("2", "ImageScale"), bae);
        assert_eq!(workflow("3", "ImageScale"), bae);
        // What inverts the map, what is no map, and a way in a circle.
        for (saved, way) in [
            ("3", "ImageInvert"),
            ("1", "ImageScale"),
            ("5", "ImageScale"),
            ("9", ""),
        ] {
            assert_eq!(workflow(saved, way), None, "{saved}, {way}");
        }
        assert_eq!(workflow("3", "MarigoldNormals"), None);
        assert_eq!(estimator(&serde_json::json!([1, {"class_type": 2}])), None);
    }

    /// As text of a PNG, as it is or compressed; what would be longer than a workflow is not inflated.
    #[test]
    fn a_workflow_is_found_in_a_png() {
        use png::text_metadata::{EncodableTextChunk, ITXtChunk, TEXtChunk};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fn told(path: &Path, chunk: &impl EncodableTextChunk) -> Option<(bool, [bool; 2])> {
            let file = std::fs::File::create(path).unwrap();
            let mut writer = png::Encoder::new(file, 1, 1).write_header().unwrap();
            writer.write_text_chunk(chunk).unwrap();
            writer.write_image_data(&[0]).unwrap();
            drop(writer);
            MapWriter::of(path).map(|writer| (writer.is_recorded, writer.reversed))
        }
        let nodes = r#"{"1": {"class_type": "DSINE-NormalMapPreprocessor", "inputs": {}},
            "2": {"class_type": "SaveImage", "inputs": {"images": ["1", 0]}}}"#;
        let recorded = Some((true, X_LEFT));
        assert_eq!(told(&path, &TEXtChunk::new("prompt", nodes)), recorded);
        let long = format!("{nodes}{}", " ".repeat(2 * MOST_TEXT));
        for (text, expected) in [(nodes, recorded), (&long, None)] {
            let mut chunk = ITXtChunk::new("prompt", text);
            chunk.compressed = true;
            chunk.compress_text().unwrap();
            assert_eq!(told(&path, &chunk), expected);
        }
    }
}
