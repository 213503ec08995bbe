//! Views and windows: grouping of layers, and their pixels.

use super::truth::{HEIGHT, WIDTH};
use super::*;

/// A normal and a depth channel of an eye, under the names that `name` makes; the right eye's normals are turned
/// over, and its depth lies a unit farther.
fn eye(mut part: Part, right: bool, name: impl Fn(&str, &str) -> String) -> Part {
    let turned = |n: DVec3| if right { DVec3::new(n.y, -n.x, n.z) } else { n };
    for (component, plane) in XYZ.iter().zip(normals(DVec3::ZERO, turned)) {
        part = part.channel(&name("Normal", component), Stored::Float, &plane);
    }
    let farther = f64::from(u8::from(right));
    let depth = truth().depth(1e10, |z, _| z + farther);
    part.channel(&name("Depth", "Z"), Stored::Float, &depth)
}

fn try_view(parts: &[Part], view: Option<&str>, color: bool) -> relievo::Result<Loaded> {
    try_read(parts, |inputs, needs| {
        inputs.view = view.map(Into::into);
        // The reversed normals of the right eye do not match its depth.
        inputs.normal_space = Some(NormalSpace::View);
        inputs.normal_flip = Some(Flip::NONE);
        needs.color = color;
    })
}

/// Loads a view and returns whether all of it is the left eye's; all of it must be one eye's.
fn is_left(parts: &[Part], view: Option<&str>) -> bool {
    let frame = try_view(parts, view, false).unwrap().frame;
    let by_normals = truth().worst_angle_deg(&frame) < 1e-3;
    let by_depth = truth().worst_depth(&frame, false, 1.0) < 1e-6;
    assert_eq!(by_normals, by_depth, "view {view:?}");
    by_normals
}

fn multi_view(mut part: Part, views: &[&str]) -> Part {
    let mut bytes = Vec::new();
    for view in views {
        bytes.extend((view.len() as i32).to_le_bytes());
        bytes.extend(view.as_bytes());
    }
    part.attributes
        .push(("multiView".into(), "stringvector", bytes));
    part
}

#[test]
fn all_layers_come_from_one_view() {
    type Name = fn(&str, &str) -> String;
    let plain: Name = |layer, c| format!("{layer}.{c}");
    let part = || Part::new(display());
    let both = |left: Name, right: Name| eye(eye(part(), false, left), true, right);
    let views = ["left", "right"];
    let files = [
        // A view per part.
        vec![
            eye(part().named("L").text("view", "left"), false, plain),
            eye(part().named("R").text("view", "right"), true, plain),
        ],
        // A word of the name, in either place; with a list, and without.
        vec![both(
            |layer, c| format!("left.{layer}.{c}"),
            |layer, c| format!("right.{layer}.{c}"),
        )],
        vec![multi_view(
            both(
                |layer, c| format!("ViewLayer.{layer}.left.{c}"),
                |layer, c| format!("ViewLayer.{layer}.right.{c}"),
            ),
            &views,
        )],
        // The default view's layers bear no name.
        vec![multi_view(
            both(plain, |layer, c| format!("{layer}.right.{c}")),
            &views,
        )],
    ];
    for parts in files {
        assert!(is_left(&parts, None) && is_left(&parts, Some("left")));
        assert!(!is_left(&parts, Some("Right")));
        let refused = try_view(&parts, Some("up"), false);
        let message = refused.err().expect("took an unknown view").to_string();
        assert!(message.contains("left, right"), "{message}");
    }
    // With one view there is nothing to choose.
    let one = [eye(part(), false, plain)];
    assert!(is_left(&one, None) && try_view(&one, Some("left"), false).is_err());
}

#[test]
fn windows_that_differ_are_brought_to_the_picture_s() {
    // The picture with overscan, depth cropped: all of the picture stays, and pixels without depth are not covered.
    let truth = truth();
    let overscan = Window::at(-8, -6, WIDTH + 16, HEIGHT + 12);
    let crop = Window::at(20, 10, WIDTH - 40, HEIGHT - 20);
    let ramp = Plane::from_fn(overscan.width(), overscan.height(), |x, _| x as f32);
    let depth = truth.depth(1e10, |z, _| z).crop(display(), crop);
    let of = |window: Window, name: &str, components: &[&str], planes: &[Plane]| {
        let channels = components.iter().zip(planes);
        channels.fold(Part::new(window).named(name), |part, (component, plane)| {
            part.channel(component, Stored::Float, plane)
        })
    };
    let parts = [
        of(
            overscan,
            "rgba",
            &["R", "G", "B"],
            &[ramp.clone(), ramp.clone(), ramp.clone()],
        ),
        of(display(), "N", &XYZ, &normals(DVec3::ZERO, |n| n)),
        of(crop, "depth", &["Z"], &[depth]),
    ];
    let frame = try_view(&parts, None, true).unwrap().frame;
    let windows = (frame.data_window, frame.display_window);
    assert_eq!(windows, (overscan, display()));
    assert!(frame.color.as_ref().unwrap().r == ramp);
    let inner = frame.crop(display());
    let alpha = truth.alpha();
    for (x, y) in places(WIDTH, HEIGHT) {
        let seen = alpha.at(x, y) == 1.0 && crop.encloses(&Window::at(x as i32, y as i32, 1, 1));
        assert_eq!(inner.mask.at(x, y), seen, "{x} {y}");
    }
    assert_eq!(frame.mask.count(), inner.mask.count());
    assert!(frame.normal.x.samples().iter().all(|v| v.is_finite()));
    // Without the picture the normals' window is the frame's.
    let frame = try_view(&parts, None, false).unwrap().frame;
    assert_eq!(frame.data_window, display());
}
