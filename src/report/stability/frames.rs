//! The small frames that the cases are made of: straight, and through a file.

use crate::error::{Error, Result};
use crate::frame::{Frame, Mask, NormalSpace, Plane, Vector3Planes};
use crate::io::exr::{OutputChannel, OutputPart, OutputType, write_results};
use crate::io::inputs::Inputs;
use crate::io::{self, Loaded, Needs};
use glam::Vec3;

/// A gentle relief that fills the picture.
pub(super) fn relief(width: usize, height: usize) -> Frame {
    Frame {
        depth: Some(Plane::from_fn(width, height, |x, y| {
            5.0 + 0.01 * (x + y) as f32
        })),
        ..Frame::of_normals(normals(width, height, gentle), Mask::full(width, height))
    }
}

/// The relief's unit normal.
pub(super) fn gentle(x: usize, y: usize) -> Vec3 {
    Vec3::new(0.3 * (x as f32).sin(), 0.2 * (y as f32).cos(), 1.0).normalize()
}

/// Numbers that look random and are the same in every run, 0..1.
pub(super) fn noise(x: usize, y: usize, channel: u32) -> f32 {
    let seed = (x as u32).wrapping_mul(0x9e37_79b9)
        ^ (y as u32).wrapping_mul(0x85eb_ca6b)
        ^ channel.wrapping_mul(0xc2b2_ae35);
    let mixed = (seed ^ (seed >> 15)).wrapping_mul(0x2c1b_3c6d);
    let mixed = (mixed ^ (mixed >> 12)).wrapping_mul(0x297a_2d39);
    (mixed ^ (mixed >> 15)) as f32 / u32::MAX as f32
}

/// Unit normals all ways, the viewer's side and the other.
pub(super) fn rough(x: usize, y: usize) -> Vec3 {
    Vec3::from_array([1, 2, 3].map(|c| 2.0 * noise(x, y, c) - 1.0)).normalize_or(Vec3::Z)
}

/// Planes of the normals `at`.
pub(super) fn normals(
    width: usize,
    height: usize,
    at: impl Fn(usize, usize) -> Vec3,
) -> Vector3Planes {
    let plane = |axis: usize| Plane::from_fn(width, height, |x, y| at(x, y)[axis]);
    Vector3Planes {
        x: plane(0),
        y: plane(1),
        z: plane(2),
    }
}

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

/// A frame covered only where `covered` says.
pub(super) fn masked(frame: Frame, covered: impl FnMut(usize, usize) -> bool) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    Frame {
        mask: Mask::new(Plane::from_fn(width, height, covered)),
        ..frame
    }
}

/// A rough surface whose conductance is what `open` says: 1, or 0 where a normal is so short that a
/// filter must have mixed unlike ones.
pub(super) fn with_conductance(open: impl Fn(usize, usize) -> bool) -> Frame {
    let frame = relief(29, 23);
    let length = Plane::from_fn(29, 23, |x, y| if open(x, y) { 1.0 } else { 0.1 });
    Frame {
        normal_length: Some(length),
        ..frame
    }
}

/// The frame as it is read from an EXR that holds its normals, depth and picture as floats.
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
