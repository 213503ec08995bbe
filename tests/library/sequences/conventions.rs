//! Motion as renderers write it: the sign, the unit and the pair of channels are found from two frames.

use crate::common::exr::Part;
use relievo::frame::{NormalSpace, Plane};
use relievo::io::inputs::Inputs;
use relievo::io::motion::{FrameBefore, MotionLayers, MotionVerdict};
use relievo::io::{Loaded, Needs, load};
use std::path::Path;

const SIZE: [usize; 2] = [120, 90];
const MIDDLE: [f64; 2] = [60.0, 45.0];

/// A relief that fills the picture: slopes of waves of some ten pixels, and a paint of others. `at` is where on it a pixel looks.
fn frame(at: impl Fn(f64, f64) -> [f64; 2]) -> Vec<(String, Plane)> {
    let plane = |value: &dyn Fn(f64, f64) -> f64| {
        Plane::from_fn(SIZE[0], SIZE[1], |x, y| {
            let [u, v] = at(x as f64 + 0.5, y as f64 + 0.5);
            value(u, v) as f32
        })
    };
    let slope = |u: f64, v: f64| {
        [
            0.4 * (0.71 * u + 0.13 * v).sin() + 0.2 * (0.31 * v - 0.05 * u).cos(),
            0.4 * (0.53 * v - 0.21 * u).cos() + 0.2 * (0.37 * u).sin(),
        ]
    };
    let normal = |axis: usize| {
        plane(&|u, v| {
            let [p, q] = slope(u, v);
            glam::DVec3::new(-p, -q, 1.0).normalize()[axis]
        })
    };
    let paint = plane(&|u, v| 0.5 + 0.3 * (0.47 * u).sin() * (0.59 * v).cos());
    let normals = ["X", "Y", "Z"].into_iter().enumerate();
    let normals = normals.map(|(axis, name)| (format!("N.{name}"), normal(axis)));
    let paint = ["R", "G", "B"].map(|name| (name.to_string(), paint.clone()));
    normals.chain(paint).collect()
}

fn read(path: &Path) -> Loaded {
    let inputs = Inputs {
        picture: path.into(),
        normal_space: Some(NormalSpace::View),
        ..Inputs::default()
    };
    let needs = Needs {
        color_if_any: true,
        motion: true,
        ..Needs::default()
    };
    load(&inputs, needs).unwrap()
}

/// The channels of a layer, with their values as a function of the surface's motion, x right, y up, in pixels.
type Channels<'a> = &'a [(&'a str, &'a dyn Fn(f64, f64) -> f64)];

/// Two frames of a relief that has come `come(x, y)` to each pixel, x right, y up; the second has these channels too.
fn judged(
    come: &dyn Fn(f64, f64) -> [f64; 2],
    channels: Channels,
) -> (Option<MotionLayers>, Option<MotionVerdict>) {
    let from = |x: f64, y: f64| {
        let [dx, dy] = come(x, y);
        [x - dx, y + dy]
    };
    judged_between([&|x, y| [x, y], &from], come, channels)
}

/// The same for two frames that look at these positions of the relief.
fn judged_between(
    at: [&dyn Fn(f64, f64) -> [f64; 2]; 2],
    come: &dyn Fn(f64, f64) -> [f64; 2],
    channels: Channels,
) -> (Option<MotionLayers>, Option<MotionVerdict>) {
    let desk = tempfile::tempdir().unwrap();
    let write = |name: &str, planes: &[(String, Plane)]| {
        let path = desk.path().join(name);
        Part::of(planes.iter().map(|(name, plane)| (name, plane))).write(&path);
        read(&path)
    };
    let before = write("1.exr", &frame(at[0]));
    let mut planes = frame(at[1]);
    for (name, stored) in channels {
        let plane = Plane::from_fn(SIZE[0], SIZE[1], |x, y| {
            let [dx, dy] = come(x as f64 + 0.5, y as f64 + 0.5);
            stored(dx, dy) as f32
        });
        planes.push((name.to_string(), plane));
    }
    let now = write("2.exr", &planes);
    let seen = FrameBefore::of(&before.frame);
    let verdict = now
        .motion
        .as_ref()
        .map(|layers| layers.judge(&now.frame, &seen, 1, None));
    (now.motion, verdict)
}

fn pan(_: f64, _: f64) -> [f64; 2] {
    [3.5, -2.25]
}

/// A turn by 0.06 about the middle of the picture: up to 4.5 px at its corners, and none in the middle.
fn wheel(x: f64, y: f64) -> [f64; 2] {
    let (x, y) = (x - MIDDLE[0], MIDDLE[1] - y);
    let (sin, cos) = 0.06f64.sin_cos();
    [x - (cos * x + sin * y), y - (cos * y - sin * x)]
}

/// Error of the motion found, in pixels, at the worst pixel.
fn off(come: &dyn Fn(f64, f64) -> [f64; 2], layers: &MotionLayers, verdict: &MotionVerdict) -> f64 {
    let found = layers.read_as(verdict).expect("motion was found");
    let mut worst = 0.0f64;
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let [dx, dy] = come(x as f64 + 0.5, y as f64 + 0.5);
            let [a, b] = [&found.x, &found.y].map(|plane| f64::from(plane.at(x, y)));
            worst = worst.max((a - dx).hypot(b - dy));
        }
    }
    worst
}

#[test]
fn every_convention_of_every_renderer_is_found_from_two_frames() {
    let [w, h] = SIZE.map(|side| side as f64);
    let cases: [(&str, Channels); 9] = [
        // Blender: previous minus current by x and y; current minus next by z and w, here of a motion that slows down.
        (
            "Blender",
            &[
                ("ViewLayer.Vector.X", &|x, _| -x),
                ("ViewLayer.Vector.Y", &|_, y| -y),
                ("ViewLayer.Vector.Z", &|x, _| -0.5 * x),
                ("ViewLayer.Vector.W", &|_, y| -0.5 * y),
            ],
        ),
        // A file with the two pairs swapped.
        (
            "swapped",
            &[
                ("Vector.X", &|x, _| 0.5 * x),
                ("Vector.Y", &|_, y| 0.5 * y),
                ("Vector.Z", &|x, _| -x),
                ("Vector.W", &|_, y| -y),
            ],
        ),
        (
            "Nuke",
            &[("forward.u", &|x, _| x), ("forward.v", &|_, y| y)],
        ),
        (
            "Arnold over half a frame",
            &[
                ("motionvector.R", &|x, _| 0.5 * x),
                ("motionvector.G", &|_, y| 0.5 * y),
            ],
        ),
        (
            "RenderMan",
            &[
                ("motionBack.r", &|x, _| -x),
                ("motionBack.g", &|_, y| y),
                ("motionFore.r", &|x, _| 0.4 * x),
                ("motionFore.g", &|_, y| -0.4 * y),
            ],
        ),
        (
            "V-Ray, y down",
            &[
                ("VRayVelocity.R", &|x, _| x),
                ("VRayVelocity.G", &|_, y| -y),
                ("VRayVelocity.B", &|_, _| 0.25),
            ],
        ),
        (
            "encoded as 0..1",
            &[
                ("mv.R", &|x, _| 0.5 + 0.5 * x / 2048.0),
                ("mv.G", &|_, y| 0.5 + 0.5 * y / 2048.0),
            ],
        ),
        (
            "widths and heights",
            &[
                ("MotionVectors.x", &move |x, _| x / w),
                ("MotionVectors.y", &move |_, y| -y / h),
            ],
        ),
        // No name: numbers alone distinguish it from layers with other content.
        (
            "nameless",
            &[
                ("aov_7.x", &move |x, _| -2.0 * x / w),
                ("aov_7.y", &move |_, y| -2.0 * y / h),
                ("aov_8.x", &|_, _| 3.0),
                ("aov_8.y", &|_, _| 4.0),
            ],
        ),
    ];
    for (name, channels) in cases {
        for (what, come) in [("pan", &pan as &dyn Fn(f64, f64) -> _), ("wheel", &wheel)] {
            let (layers, verdict) = judged(come, channels);
            let (layers, verdict) = (layers.unwrap(), verdict.unwrap());
            assert!(verdict.is_found(), "{name}, {what}: {}", verdict.evidence);
            let off = off(come, &layers, &verdict);
            // 0..1 over 4096 pixels in 32-bit floats is good to 2^-24 * 4096 px.
            assert!(
                off < 1e-3,
                "{name}, {what}: {off} px off, {}",
                verdict.conclusion
            );
        }
    }
}

#[test]
fn what_frames_do_not_show_is_not_guessed() {
    // Nothing moves.
    let (_, verdict) = judged(
        &|_, _| [0.0; 2],
        &[("velocity.x", &|_, _| 0.0), ("velocity.y", &|_, _| 0.0)],
    );
    let verdict = verdict.unwrap();
    assert!(!verdict.is_found() && verdict.is_still, "{verdict:?}");
    // The surface moves, but the layer has other content.
    let (_, verdict) = judged(
        &pan,
        &[("velocity.x", &|_, _| 5.0), ("velocity.y", &|_, _| 9.0)],
    );
    let verdict = verdict.unwrap();
    assert!(!verdict.is_found() && !verdict.is_still, "{verdict:?}");
    // Three numbers that lead nowhere in the picture may do so in the world.
    let third = ("velocity.z", &(|_, _| 1.0) as &dyn Fn(f64, f64) -> f64);
    let (_, verdict) = judged(
        &pan,
        &[
            ("velocity.x", &|_, _| 5.0),
            ("velocity.y", &|_, _| 9.0),
            third,
        ],
    );
    let evidence = verdict.unwrap().evidence;
    assert!(evidence.contains("world space"), "{evidence}");
    // It does not move, but the layer says it does.
    let (layers, verdict) = judged(
        &|_, _| [0.0; 2],
        &[("velocity.x", &|_, _| 2.0), ("velocity.y", &|_, _| 1.0)],
    );
    assert!(!verdict.unwrap().is_found());
    // Its name does not imply a reading, Blender's does.
    assert!(layers.unwrap().by_name().is_none());
    // One colour and one slope everywhere: motion inside looks the same in every reading.
    let inside = |x: f64, y: f64| match (x - MIDDLE[0]).hypot(y - MIDDLE[1]) < 20.0 {
        true => [3.5, -2.25],
        false => [0.0; 2],
    };
    let (_, verdict) = judged_between(
        [&|_, _| [0.0; 2], &|_, _| [0.0; 2]],
        &inside,
        &[("velocity.x", &|x, _| x), ("velocity.y", &|_, y| y)],
    );
    assert!(!verdict.unwrap().is_found());
    // No layer, no verdict; motion along x alone leaves the sense of y open for later frames.
    assert!(judged(&pan, &[]).1.is_none());
    let along_x = |_: f64, _: f64| [3.5, 0.0];
    let (_, verdict) = judged(
        &along_x,
        &[("velocity.x", &|x, _| x), ("velocity.y", &|_, y| -y)],
    );
    let verdict = verdict.unwrap();
    assert!(verdict.is_found() && !verdict.is_settled, "{verdict:?}");
    let (_, verdict) = judged(
        &pan,
        &[("velocity.x", &|x, _| x), ("velocity.y", &|_, y| -y)],
    );
    assert!(verdict.unwrap().is_settled);
}
