//! Views and windows: grouping of layers, and their pixels.

use super::truth::{HEIGHT, WIDTH, display, truth};
use crate::common::exr::{Part, Stored, write};
use glam::DVec3;
use relievo::frame::{Plane, Window};
use relievo::io::inputs::Inputs;
use relievo::io::{self, Needs};
use std::path::Path;

/// A normal and a depth channel of an eye, under the names that `name` makes; the right eye's normals are turned
/// over, and its depth lies a unit farther.
fn eye(part: Part, right: bool, name: impl Fn(&str, &str) -> String) -> Part {
    let truth = truth();
    let mut part = part;
    for (axis, component) in ["X", "Y", "Z"].into_iter().enumerate() {
        let turned = |n: DVec3| if right { DVec3::new(n.y, -n.x, n.z) } else { n };
        let plane = truth.normal(axis, 0.0, turned);
        part = part.channel(&name("Normal", component), Stored::Float, &plane);
    }
    let farther = f64::from(u8::from(right));
    let depth = truth.depth(1e10, |z, _| z + farther);
    part.channel(&name("Depth", "Z"), Stored::Float, &depth)
}

fn inputs(path: &Path, view: Option<&str>) -> Inputs {
    Inputs {
        picture: path.to_path_buf(),
        view: view.map(Into::into),
        // The reversed normals of the right eye do not match its depth.
        normal_space: Some(relievo::frame::NormalSpace::View),
        normal_flip: Some(relievo::io::inputs::Flip::NONE),
        ..Inputs::default()
    }
}

/// Loads a view and returns whether all of it is the left eye's; all of it must be one eye's.
fn is_left(path: &Path, view: Option<&str>) -> bool {
    let frame = io::load(&inputs(path, view), Needs::default())
        .unwrap()
        .frame;
    let left = [
        truth().worst_angle_deg(&frame) < 1e-3,
        truth().worst_depth(&frame, false, 1.0) < 1e-6,
    ];
    assert_eq!(left[0], left[1], "{}, view {view:?}", path.display());
    left[0]
}

fn multi_view(part: Part, views: &[&str]) -> Part {
    let mut bytes = Vec::new();
    for view in views {
        bytes.extend((view.len() as i32).to_le_bytes());
        bytes.extend(view.as_bytes());
    }
    let mut part = part;
    part.attributes
        .push(("multiView".into(), "stringvector", bytes));
    part
}

#[test]
fn all_layers_come_from_one_view() {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("stereo.exr");
    let plain = |layer: &str, component: &str| format!("{layer}.{component}");
    let part = || Part::new(display());
    let files = [
        // A view per part.
        vec![
            eye(part().named("L").text("view", "left"), false, plain),
            eye(part().named("R").text("view", "right"), true, plain),
        ],
        // A word of the name, in either place; with a list, and without.
        vec![eye(
            eye(part(), false, |layer, c| format!("left.{layer}.{c}")),
            true,
            |layer, c| format!("right.{layer}.{c}"),
        )],
        vec![multi_view(
            eye(
                eye(part(), false, |layer, c| {
                    format!("ViewLayer.{layer}.left.{c}")
                }),
                true,
                |layer, c| format!("ViewLayer.{layer}.right.{c}"),
            ),
            &["left", "right"],
        )],
        // The default view's layers bear no name.
        vec![multi_view(
            eye(eye(part(), false, plain), true, |layer, c| {
                format!("{layer}.right.{c}")
            }),
            &["left", "right"],
        )],
    ];
    for parts in files {
        write(&path, display(), &parts);
        assert!(is_left(&path, None));
        assert!(is_left(&path, Some("left")));
        assert!(!is_left(&path, Some("Right")));
        let refused = io::load(&inputs(&path, Some("up")), Needs::default());
        let message = refused.err().expect("took an unknown view").to_string();
        assert!(message.contains("left, right"), "{message}");
    }
    // With one view there is nothing to choose.
    write(&path, display(), &[eye(part(), false, plain)]);
    assert!(is_left(&path, None));
    assert!(io::load(&inputs(&path, Some("left")), Needs::default()).is_err());
}

#[test]
fn windows_that_differ_are_brought_to_the_picture_s() {
    // The picture with overscan, depth cropped: all of the picture stays, and pixels without depth are not covered.
    let (truth, desk) = (truth(), tempfile::tempdir().unwrap());
    let path = desk.path().join("overscan.exr");
    let overscan = Window::at(-8, -6, WIDTH + 16, HEIGHT + 12);
    let crop = Window::at(20, 10, WIDTH - 40, HEIGHT - 20);
    let ramp = Plane::from_fn(overscan.width(), overscan.height(), |x, _| x as f32);
    let depth = truth.depth(1e10, |z, _| z).crop(display(), crop);
    let mut beauty = Part::new(overscan).named("rgba");
    for name in ["R", "G", "B"] {
        beauty = beauty.channel(name, Stored::Float, &ramp);
    }
    let mut normal = Part::new(display()).named("N");
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        normal = normal.channel(name, Stored::Float, &truth.normal(axis, 0.0, |n| n));
    }
    let z = Part::new(crop)
        .named("depth")
        .channel("Z", Stored::Float, &depth);
    write(&path, display(), &[beauty, normal, z]);
    let needs = Needs {
        color: true,
        ..Needs::default()
    };
    let frame = io::load(&inputs(&path, None), needs).unwrap().frame;
    assert_eq!(
        (frame.data_window, frame.display_window),
        (overscan, display())
    );
    assert!(frame.color.as_ref().unwrap().r == ramp);
    let inner = frame.crop(display());
    let alpha = truth.alpha();
    for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
        let seen = alpha.at(x, y) == 1.0 && crop.encloses(&Window::at(x as i32, y as i32, 1, 1));
        assert_eq!(inner.mask.at(x, y), seen, "{x} {y}");
    }
    assert_eq!(frame.mask.count(), inner.mask.count());
    assert!(frame.normal.x.samples().iter().all(|v| v.is_finite()));
    // Without the picture the normals' window is the frame's.
    let frame = io::load(&inputs(&path, None), Needs::default())
        .unwrap()
        .frame;
    assert_eq!(frame.data_window, display());
}
