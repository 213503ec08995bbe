//! Motion as renderers write it: the sign, the unit and the pair of channels are found from two frames.

use crate::common::exr::Part;
use crate::common::files::read;
use crate::prelude::*;
use relievo::io::motion::{FrameBefore, MotionLayers, MotionVerdict};

const SIZE: [usize; 2] = [120, 90];
const W: f64 = 120.0;
const H: f64 = 90.0;
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

/// What has come to each pixel, or the position of the relief that it looks at.
type Of<'a> = &'a dyn Fn(f64, f64) -> [f64; 2];

/// Channels of layers, and their values by the surface's motion, x right, y up, in pixels.
type Channels = (&'static str, fn(f64, f64) -> [f64; 4]);

/// Two frames of a relief that has come `come(x, y)` to each pixel, x right, y up; the second has these channels too.
fn judged(come: Of, channels: Channels) -> Option<(MotionLayers, MotionVerdict)> {
    let from = |x: f64, y: f64| {
        let [dx, dy] = come(x, y);
        [x - dx, y + dy]
    };
    judged_between([&|x, y| [x, y], &from], come, channels)
}

/// The same for two frames that look at these positions of the relief.
fn judged_between(
    at: [Of; 2],
    come: Of,
    (names, stored): Channels,
) -> Option<(MotionLayers, MotionVerdict)> {
    let seen = |planes: &[(String, Plane)]| {
        let part = Part::of(planes.iter().map(|(name, plane)| (name, plane)));
        read(part, |inputs, needs| {
            inputs.normal_space = Some(NormalSpace::View);
            (needs.color_if_any, needs.motion) = (true, true);
        })
    };
    let before = seen(&frame(at[0]));
    let mut planes = frame(at[1]);
    for (i, name) in names.split_whitespace().enumerate() {
        let plane = Plane::from_fn(SIZE[0], SIZE[1], |x, y| {
            let [dx, dy] = come(x as f64 + 0.5, y as f64 + 0.5);
            stored(dx, dy)[i] as f32
        });
        planes.push((name.to_string(), plane));
    }
    let now = seen(&planes);
    let layers = now.motion?;
    let verdict = layers.judge(&now.frame, &FrameBefore::of(&before.frame), 1, None);
    Some((layers, verdict))
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
fn off(come: Of, layers: &MotionLayers, verdict: &MotionVerdict) -> f64 {
    let found = layers.read_as(verdict).expect("motion was found");
    largest(places(SIZE[0], SIZE[1]).map(|(x, y)| {
        let [dx, dy] = come(x as f64 + 0.5, y as f64 + 0.5);
        let [a, b] = [&found.x, &found.y].map(|plane| f64::from(plane.at(x, y)));
        (a - dx).hypot(b - dy)
    }))
}

#[test]
fn every_convention_of_every_renderer_is_found_from_two_frames() {
    #[rustfmt::skip]
    let cases: [(&str, Channels); 9] = [
        // Blender: previous minus current by x and y; current minus next by z and w, here of a motion that slows down.
        ("Blender", ("ViewLayer.Vector.X ViewLayer.Vector.Y ViewLayer.Vector.Z ViewLayer.Vector.W",
            |x, y| [-x, -y, -0.5 * x, -0.5 * y])),
        ("the two pairs swapped", ("Vector.X Vector.Y Vector.Z Vector.W", |x, y| [0.5 * x, 0.5 * y, -x, -y])),
        ("Nuke", ("forward.u forward.v", |x, y| [x, y, 0.0, 0.0])),
        ("Arnold over half a frame", ("motionvector.R motionvector.G", |x, y| [0.5 * x, 0.5 * y, 0.0, 0.0])),
        ("RenderMan", ("motionBack.r motionBack.g motionFore.r motionFore.g", |x, y| [-x, y, 0.4 * x, -0.4 * y])),
        ("V-Ray, y down", ("VRayVelocity.R VRayVelocity.G VRayVelocity.B", |x, y| [x, -y, 0.25, 0.0])),
        ("encoded as 0..1", ("mv.R mv.G", |x, y| [0.5 + 0.5 * x / 2048.0, 0.5 + 0.5 * y / 2048.0, 0.0, 0.0])),
        ("widths and heights", ("MotionVectors.x MotionVectors.y", |x, y| [x / W, -y / H, 0.0, 0.0])),
        // No name: numbers alone distinguish it from layers with other content.
        ("nameless", ("aov_7.x aov_7.y aov_8.x aov_8.y", |x, y| [-2.0 * x / W, -2.0 * y / H, 3.0, 4.0])),
    ];
    for (name, channels) in cases {
        for (what, come) in [("pan", &pan as Of), ("wheel", &wheel)] {
            let (layers, verdict) = judged(come, channels).unwrap();
            let case = format!(
                "{name}, {what}: {}, {}",
                verdict.conclusion, verdict.evidence
            );
            assert!(verdict.is_found(), "{case}");
            let off = off(come, &layers, &verdict);
            // 0..1 over 4096 pixels in 32-bit floats is good to 2^-24 * 4096 px.
            assert!(off < 1e-3, "{case}: {off} px off");
        }
    }
}

#[test]
fn what_frames_do_not_show_is_not_guessed() {
    const XY: &str = "velocity.x velocity.y";
    let still: Of = &|_, _| [0.0; 2];
    let verdict = |come, channels| judged(come, channels).unwrap().1;
    // Nothing moves.
    let found = verdict(still, (XY, |_, _| [0.0; 4]));
    assert!(!found.is_found() && found.is_still, "{found:?}");
    // The surface moves, but the layer has other content.
    let found = verdict(&pan, (XY, |_, _| [5.0, 9.0, 0.0, 0.0]));
    assert!(!found.is_found() && !found.is_still, "{found:?}");
    // Three numbers that lead nowhere in the picture may do so in the world.
    let xyz = "velocity.x velocity.y velocity.z";
    let evidence = verdict(&pan, (xyz, |_, _| [5.0, 9.0, 1.0, 0.0])).evidence;
    assert!(evidence.contains("world space"), "{evidence}");
    // It does not move, but the layer says it does. Its name does not imply a reading, Blender's does.
    let (layers, found) = judged(still, (XY, |_, _| [2.0, 1.0, 0.0, 0.0])).unwrap();
    assert!(!found.is_found() && layers.by_name().is_none());
    // One colour and one slope everywhere: motion inside looks the same in every reading.
    let inside = |x: f64, y: f64| match (x - MIDDLE[0]).hypot(y - MIDDLE[1]) < 20.0 {
        true => [3.5, -2.25],
        false => [0.0; 2],
    };
    let up: Channels = (XY, |x, y| [x, y, 0.0, 0.0]);
    let (_, found) = judged_between([still; 2], &inside, up).unwrap();
    assert!(!found.is_found());
    // No layer, no verdict; motion along x alone leaves the sense of y open for later frames.
    assert!(judged(&pan, ("", |_, _| [0.0; 4])).is_none());
    let down: Channels = (XY, |x, y| [x, -y, 0.0, 0.0]);
    let found = verdict(&|_, _| [3.5, 0.0], down);
    assert!(found.is_found() && !found.is_settled, "{found:?}");
    assert!(verdict(&pan, down).is_settled);
}
