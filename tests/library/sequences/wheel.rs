//! Motion of two rendered frames: a wheel that turns before standing cloth, past which the camera goes.

use super::moving;
use crate::common::exr::Part;
use crate::common::files::load;
use crate::common::program::fixture;
use crate::prelude::*;
use relievo::io::camera::read_camera;
use relievo::io::motion::{FrameBefore, MotionVerdict};
use std::path::{Path, PathBuf};

fn read(path: PathBuf, camera: Option<&str>, space: Option<NormalSpace>) -> Loaded {
    load(path, |inputs, needs| {
        (inputs.camera, inputs.normal_space) = (camera.map(fixture), space);
        *needs = moving();
    })
}

fn frame(number: u32) -> Loaded {
    let name = |end: &str| format!("wheel.{number:04}.{end}");
    read(fixture(&name("exr")), Some(&name("camera.json")), None)
}

fn judged(now: &Loaded, before: &Frame) -> MotionVerdict {
    let layers = now.motion.as_ref().unwrap();
    layers.judge(&now.frame, &FrameBefore::of(before), 1, None)
}

/// The mean distance of normals to those of the frame before at the nearest pixel, where both frames are seen.
fn unlike(now: &Frame, before: &Frame, come: impl Fn(usize, usize) -> [f32; 2]) -> f64 {
    let (width, height) = (now.mask.width(), now.mask.height());
    let apart = places(width, height).filter_map(|(x, y)| {
        let [dx, dy] = come(x, y);
        let [u, v] = [x as f32 - dx, y as f32 + dy].map(|at| at.round() as usize);
        let is_seen = u < width && v < height;
        is_seen.then(|| now.normal.at(x, y).distance(before.normal.at(u, v)))
    });
    let apart: Vec<f64> = apart.collect();
    apart.iter().sum::<f64>() / apart.len() as f64
}

#[test]
fn the_motion_of_a_rendered_wheel_is_found() {
    let [before, now] = [1, 2].map(frame);
    let verdict = judged(&now, &before.frame);
    let conclusion = "Vector.X Vector.Y, to the frame before, in pixels, y up";
    assert_eq!(verdict.conclusion, conclusion, "{}", verdict.evidence);
    let flags = "--motion \"Vector\" --motion-convention back,up,pixels";
    assert_eq!(verdict.flags.as_deref(), Some(flags));
    let layers = now.motion.as_ref().unwrap();
    let found = layers.read_as(&verdict).unwrap();
    let followed = unlike(&now.frame, &before.frame, |x, y| {
        [found.x.at(x, y), found.y.at(x, y)]
    });
    let still = unlike(&now.frame, &before.frame, |_, _| [0.0; 2]);
    assert!(followed < 0.5 * still, "{followed} along it, {still} still");

    // The cloth stands still: depth and both cameras say how far it has come. Blender rounds motion and depth to halves.
    let mut standing = now.frame.clone();
    standing.source.depth_kind = DepthKind::Planar;
    let camera = fixture("wheel.0001.camera.json");
    let camera = read_camera(&camera, standing.display_window, 1.0).unwrap();
    let expected = static_world_motion(&standing, &camera).unwrap();
    // The left edge is cloth alone.
    for y in 0..standing.mask.height() {
        let off = [(&found.x, &expected.x), (&found.y, &expected.y)];
        let off = off.map(|(found, expected)| (found.at(4, y) - expected.at(4, y)).abs());
        assert!(off[0] < 0.05 && off[1] < 0.05, "row {y}: {off:?} px off");
        assert!(expected.x.at(4, y) < -1.0, "the camera goes to the right");
    }
}

/// A name, its two components, and what they hold where the surface has come so far, x right, y up, in pixels.
type Renderer = (&'static str, [&'static str; 2], fn([f32; 2]) -> [f32; 2]);

/// Arnold's over half a frame, V-Ray's with y down, Nuke's both ways, and 0..1 of 2048 pixels.
const RENDERERS: [Renderer; 5] = [
    ("motionvector", ["R", "G"], |[x, y]| [0.5 * x, 0.5 * y]),
    ("VRayVelocity", ["R", "G"], |[x, y]| [x, -y]),
    ("forward", ["u", "v"], |[x, y]| [x, y]),
    ("backward", ["u", "v"], |[x, y]| [-x, -y]),
    ("mv", ["R", "G"], |come| come.map(|c| 0.5 + c / 4096.0)),
];

#[test]
fn it_is_found_under_the_names_and_signs_of_other_renderers() {
    let [before, now] = [1, 2].map(frame);
    let layers = now.motion.as_ref().unwrap();
    let come = layers.read_as(&judged(&now, &before.frame)).unwrap();
    let desk = tempfile::tempdir().unwrap();
    for (name, components, stored) in RENDERERS {
        let path = desk.path().join("frame.exr");
        write(&path, &now.frame, &come, (name, components, stored));
        let again = read(path, None, Some(NormalSpace::View));
        let verdict = judged(&again, &before.frame);
        let found = again.motion.as_ref().unwrap().read_as(&verdict);
        let found = found.unwrap_or_else(|| panic!("{name}: {}", verdict.evidence));
        for (found, come) in [(&found.x, &come.x), (&found.y, &come.y)] {
            let worst = apart(found, come);
            // 0..1 over 4096 pixels in 32-bit floats is good to 2^-24 * 4096 px.
            assert!(worst < 1e-3, "{name}: {worst} px off");
        }
    }
}

/// The frame, in view space, with its motion as a renderer writes it.
fn write(path: &Path, frame: &Frame, come: &Vector2Planes, (name, components, stored): Renderer) {
    let (n, color) = (&frame.normal, frame.color.as_ref().unwrap());
    let motion = [0, 1].map(|axis| {
        Plane::from_fn(n.x.width(), n.x.height(), |x, y| {
            stored([come.x.at(x, y), come.y.at(x, y)])[axis]
        })
    });
    let names = ["R", "G", "B", "N.X", "N.Y", "N.Z", "Z"].map(String::from);
    let names = names
        .into_iter()
        .chain(components.map(|component| format!("{name}.{component}")));
    let planes = [&color.r, &color.g, &color.b, &n.x, &n.y, &n.z];
    let planes = planes.into_iter().chain(&frame.depth).chain(&motion);
    Part::of(names.zip(planes)).write(path);
}
