//! Any bytes as an EXR file: a frame or an error, whole or by rows, and a copy with a part more.

use relievo::io::exr::{ExrFile, Limits, OutputChannel, OutputPart, OutputType, PartWriter};
use relievo::io::inputs::{Inputs, LightInputs};
use relievo::io::{Needs, load};
use std::io::{Cursor, Write};

/// Larger pictures are read as any other, only more slowly.
const MOST_PIXELS: usize = 1 << 18;

pub(super) fn run(data: &[u8]) {
    let mut file = tempfile::Builder::new()
        .suffix(".exr")
        .tempfile()
        .expect("room for a file");
    file.write_all(data).expect("room for a file");
    let Ok(exr) = ExrFile::open(file.path(), &Limits::default()) else {
        return;
    };
    let _ = exr.is_whole();
    let pixels = |part: &relievo::io::exr::Part| part.window.width() * part.window.height();
    if exr.parts.iter().map(pixels).sum::<usize>() > MOST_PIXELS {
        return;
    }
    let everything = Needs {
        color_if_any: true,
        albedo: true,
        projection: true,
        motion: true,
        ..Needs::default()
    };
    let mut inputs = Inputs {
        picture: file.path().into(),
        light: Some(LightInputs::default()),
        ..Inputs::default()
    };
    let _ = load(&inputs, everything);
    inputs.rows = Some(1..3);
    let _ = load(&inputs, everything);
    let plane = relievo::frame::Plane::filled(2, 2, 0.5);
    let window = relievo::frame::Window::from_size(2, 2);
    let part = OutputPart {
        name: "more".into(),
        data_window: window,
        display_window: window,
        pixel_aspect: 1.0,
        channels: vec![OutputChannel {
            name: "R".into(),
            plane: &plane,
            sample_type: OutputType::Half,
        }],
        attributes: Vec::new(),
        chromaticities: None,
        compression: Default::default(),
    };
    let mut copy = Cursor::new(Vec::new());
    let _ = PartWriter::append(&exr, &mut copy, file.path(), &part.description())
        .and_then(|writer| writer.write(&part));
}
