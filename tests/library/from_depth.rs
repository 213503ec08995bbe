//! Frames without normals: those of depth, positions, or heights take their place.

use crate::common::exr::Part;
use crate::common::files::{load, try_load, try_read};
use crate::prelude::*;
use std::path::Path;

const SIZE: [usize; 2] = [96, 80];

fn seen(surface: Surface) -> Frame {
    let exact = ExactScene::orthographic(surface, 48.0, 40.0).in_perspective();
    exact.frame(SIZE[0], SIZE[1])
}

/// Writes planes as channels of an EXR, and reads it without anything else but a camera.
fn read(
    channels: &[(&str, &Plane)],
    camera: Option<Camera>,
    change: impl Fn(&mut Inputs),
) -> relievo::Result<Loaded> {
    try_read(Part::of(channels.iter().copied()), |inputs, _| {
        inputs.known_camera = camera.map(known);
        change(inputs);
    })
}

fn known(camera: Camera) -> KnownCamera {
    let is_placed = true;
    KnownCamera { camera, is_placed }
}

/// Sets another file as depth.
fn with_depth(inputs: &mut Inputs, path: &Path) {
    inputs.depth = Some(path.to_str().unwrap().into());
}

fn tells(found: &Loaded, what: &str) -> bool {
    found.warnings.iter().any(|line| line.contains(what))
}

/// Whether a pixel lies within 3/4 of the radius of a ball of 30 pixels.
fn is_inner(x: usize, y: usize) -> bool {
    (x as f64 - 47.5).hypot(y as f64 - 39.5) < 0.75 * 30.0
}

/// The largest angle, in degrees, between two frames' normals, of pixels that `counts`; all these are covered.
fn worst_deg(found: &Frame, exact: &Frame, counts: impl Fn(usize, usize) -> bool) -> f64 {
    let counted = places(SIZE[0], SIZE[1]).filter(|&(x, y)| counts(x, y));
    let off = counted.map(|(x, y)| {
        assert!(found.mask.at(x, y), "({x}, {y})");
        let [found, exact] = [found, exact].map(|frame| frame.normal.at(x, y));
        found.angle_between(exact).to_degrees()
    });
    off.fold(0.0, f64::max)
}

/// One over the depth is affine on planes in perspective: slopes are exact but for the rounding of depth, 6e-8 of it,
/// which the focal length of some 1000 pixels makes 6e-5: .004 degrees.
#[test]
fn planes_are_exact_and_balls_nearly() {
    let plane = seen(Surface::plane(DVec3::new(0.5, -0.3, 0.8)));
    let depth = plane.depth.as_ref().unwrap();
    let found = read(&[("Z", depth)], plane.camera, |_| ()).unwrap().frame;
    let off = worst_deg(&found, &plane, |_, _| true);
    assert!(off < 0.01, "{off}");
    // At 3/4 of the radius R = 30 central differences of sqrt(R^2 - r^2) miss 3 R^2 r / (6 (R^2 - r^2)^2.5) = .0033 of
    // the slope 1.13, which turns the normal by .0033 / (1 + 1.13^2) = .083 degrees.
    let ball = seen(Surface::ball(30.0));
    let depth = ball.depth.as_ref().unwrap();
    let found = read(&[("Z", depth)], ball.camera, |_| ()).unwrap();
    let off = worst_deg(&found.frame, &ball, is_inner);
    assert!(off < 0.12, "{off}");
    assert!(tells(&found, "normals from depth"));
    // What is no surface stays none.
    assert!(!found.frame.mask.at(2, 2) && found.frame.normal_length.is_none());
}

/// Positions are those of the same points.
#[test]
fn positions_serve_as_depth_does() {
    let ball = seen(Surface::ball(30.0));
    let exact = ExactScene::orthographic(Surface::ball(30.0), 48.0, 40.0).in_perspective();
    let position = [0, 1, 2].map(|axis| {
        let seen = |x, y| exact.exact(x, y).map(|seen| seen.point[axis] as f32);
        Plane::from_fn(SIZE[0], SIZE[1], |x, y| seen(x, y).unwrap_or(0.0))
    });
    let [x, y, z] = &position;
    let channels = [("Position.X", x), ("Position.Y", y), ("Position.Z", z)];
    let found = read(&channels, ball.camera, |_| ()).unwrap();
    let off = worst_deg(&found.frame, &ball, is_inner);
    assert!(off < 0.12, "{off}");
    assert!(tells(&found, "normals from positions"));
}

/// A height of .3 x - .2 y, x right and y down, leans by (-.3, -.2): 0 and less are heights too.
#[test]
fn heights_below_0_are_heights() {
    let slanted = |x: usize, y: usize| 0.15 * x as f32 - 0.1 * y as f32 - 3.0;
    let height = Plane::from_fn(SIZE[0], SIZE[1], slanted);
    let found = read(&[("H", &height)], None, |inputs| {
        inputs.depth = Some("H".into());
        inputs.depth_kind = Some(StoredDepth::Height);
        inputs.height_scale = Some(2.0);
    });
    let frame = found.unwrap().frame;
    let expected = DVec3::new(-0.3, -0.2, 1.0).normalize();
    for (x, y) in [(0, 0), (95, 79), (20, 60)] {
        let off = frame.normal.at(x, y).distance(expected);
        assert!(off < 1e-5, "({x}, {y})");
    }
    assert_eq!(frame.mask.count(), SIZE[0] * SIZE[1]);
    let projection = frame.camera.unwrap().projection;
    let is_parallel = matches!(projection, Projection::Orthographic { sx: 1.0, .. });
    assert!(is_parallel);
}

/// What nothing says is told, and how to say it.
#[test]
fn guesses_are_told() {
    let ramp = Plane::from_fn(SIZE[0], SIZE[1], |x, _| 0.2 + 0.005 * x as f32);
    let found = read(&[("Z", &ramp)], None, |_| ()).unwrap();
    for told in ["--depth-kind white-far", "--camera FILE"] {
        assert!(tells(&found, told), "{told}");
    }
    // White is near: what rises to the right faces left.
    assert!(found.frame.normal.at(40, 40).x < -0.05);
    let far = read(&[("Z", &ramp)], None, |inputs| {
        inputs.depth_kind = Some(StoredDepth::WhiteFar)
    });
    assert!(far.unwrap().frame.normal.at(40, 40).x > 0.05);
    let grey = [("R", &ramp), ("G", &ramp), ("B", &ramp)];
    let error = read(&grey, None, |_| ()).err().unwrap().to_string();
    let remedies = ["--normal FILE", "--depth LAYER|FILE"];
    assert!(remedies.iter().all(|flag| error.contains(flag)), "{error}");
}

/// A bump is a bump in distances and in disparity, which a name tells; where none does, that is told. Colours are refused.
#[test]
fn disparity_is_known_by_its_name() {
    let desk = tempfile::tempdir().unwrap();
    let photo = desk.path().join("photo.png");
    let grey = image::RgbImage::from_pixel(96, 80, image::Rgb([90; 3]));
    grey.save(&photo).unwrap();
    // The ball's nearest point is in the middle, where 1/z is largest: to the left of it normals point left.
    let exact = seen(Surface::ball(30.0));
    let depth = exact.depth.as_ref().unwrap();
    let save = |name: &str, of: fn(f32) -> f32| {
        let path = desk.path().join(name);
        let plane = depth.map(|z| if z > 0.0 { 40.0 * of(z) } else { 0.0 });
        Part::of([("Y", &plane)]).write(&path);
        load(&photo, |inputs, _| {
            inputs.known_camera = exact.camera.map(known);
            with_depth(inputs, &path);
        })
    };
    for name in ["ball_disparity.exr", "inverse_depth.exr", "a.exr"] {
        let found = save(name, if name == "a.exr" { |z| z } else { |z| 1.0 / z });
        assert!(found.frame.normal.at(30, 40).x < -0.3, "{name}");
    }
    let colours = desk.path().join("depth.png");
    let colour = |x, _| image::Rgb([x as u8, 200 - x as u8, 40]);
    let picture = image::RgbImage::from_fn(96, 80, colour);
    picture.save(&colours).unwrap();
    let refused = try_load(&photo, |inputs, _| with_depth(inputs, &colours));
    let error = refused.err().unwrap().to_string();
    assert!(error.contains("is in colours"), "{error}");
}

/// A picture of heights is lit as a surface of one colour, and can be enhanced as the picture that it is.
#[test]
fn heights_are_no_colours_of_what_is_lit() {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("heights.png");
    let heights = image::GrayImage::from_fn(32, 24, |x, y| image::Luma([(4 * x + y) as u8]));
    heights.save(&path).unwrap();
    for color in [false, true] {
        let loaded = load(&path, |inputs, needs| {
            with_depth(inputs, &path);
            inputs.depth_kind = Some(StoredDepth::Height);
            inputs.height_scale = Some(9.0);
            (needs.color, needs.color_if_any) = (color, !color);
        });
        assert_eq!(loaded.frame.color.is_some(), color);
    }
}
