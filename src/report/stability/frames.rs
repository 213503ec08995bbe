//! The small frames of the cases: in memory, and through a file.

use crate::error::{Error, Result};
use crate::frame::{Frame, NormalSpace, Plane};
use crate::io::exr::{OutputChannel, OutputPart, OutputType, write_results};
use crate::io::inputs::Inputs;
use crate::io::{self, Loaded, Needs};
use crate::report::scenes::frames::{normals, relief, rough};
use glam::Vec3;

/// A relief of 29x23 with other normals.
pub(super) fn with_normals(at: impl Fn(usize, usize) -> Vec3) -> Frame {
    let frame = relief(29, 23);
    Frame {
        normal: normals(29, 23, at),
        ..frame
    }
}

/// A relief of 29x23 with other depth.
pub(super) fn with_depth(at: impl FnMut(usize, usize) -> f32) -> Frame {
    let frame = relief(29, 23);
    Frame {
        depth: Some(Plane::from_fn(29, 23, at)),
        ..frame
    }
}

/// A rough surface with the conductance given by `open`: 1, or 0 by a normal so short that a filter must have mixed
/// different ones.
pub(super) fn with_conductance(open: impl Fn(usize, usize) -> bool) -> Frame {
    let frame = relief(29, 23);
    let length = Plane::from_fn(29, 23, |x, y| if open(x, y) { 1.0 } else { 0.1 });
    Frame {
        normal_length: Some(length),
        ..frame
    }
}

/// A relief of random unit normals, including those facing away.
pub(super) fn random(width: usize, height: usize) -> impl Fn() -> Frame {
    move || Frame {
        normal: normals(width, height, rough),
        ..relief(width, height)
    }
}

/// A ball, or a bowl if `bend` is negative.
pub(super) fn ball(bend: f32) -> Frame {
    with_normals(move |x, y| {
        Vec3::new(bend * (x as f32 - 14.0), bend * (11.0 - y as f32), 0.7).normalize()
    })
}

/// A tilted cylinder.
pub(super) fn cylinder() -> Frame {
    with_normals(|x, y| {
        let across = 0.03 * (x as f32 - 14.0) + 0.02 * (11.0 - y as f32);
        Vec3::new(0.83 * across, 0.55 * across, 1.0).normalize()
    })
}

/// The frame as loaded from an EXR with its normals, depth and picture as floats.
pub(super) fn through_a_file(frame: &Frame) -> Result<Loaded> {
    let channel = |name: &str, plane| OutputChannel {
        name: name.into(),
        plane,
        sample_type: OutputType::Float,
    };
    let normal = &frame.normal;
    let mut channels = vec![
        channel("N.x", &normal.x),
        channel("N.y", &normal.y),
        channel("N.z", &normal.z),
    ];
    if let Some(color) = &frame.color {
        let colors = [("R", &color.r), ("G", &color.g), ("B", &color.b)];
        channels.extend(colors.map(|(name, plane)| channel(name, plane)));
    }
    channels.extend(frame.depth.as_ref().map(|depth| channel("Z", depth)));
    let part = OutputPart {
        name: "main".into(),
        data_window: frame.data_window,
        display_window: frame.display_window,
        pixel_aspect: 1.0,
        channels,
        attributes: Vec::new(),
        chromaticities: None,
        compression: Default::default(),
    };
    let place = std::env::temp_dir();
    let directory = tempfile::tempdir().map_err(Error::io(&place, "write"))?;
    let picture = directory.path().join("case.exr");
    let mut file = std::fs::File::create(&picture).map_err(Error::io(&picture, "write"))?;
    write_results(&mut file, &picture, &part)?;
    let inputs = Inputs {
        picture,
        normal_space: Some(NormalSpace::View),
        ..Inputs::default()
    };
    io::load(
        &inputs,
        Needs {
            color: frame.color.is_some(),
            projection: false,
            ..Needs::default()
        },
    )
}
