//! Axes of normals and the sense of depth by outlines, where slopes leave two readings open.

use crate::common::exr::Part;
use crate::common::files::{self, load};
use crate::common::program::fixture;
use crate::prelude::*;

/// A ball of 30 pixels before a wall, without perspective.
fn ball() -> Frame {
    let mut scene = ExactScene::orthographic(Surface::ball(30.0), 48.0, 40.0);
    let wall = Surface::plane(DVec3::Z).moved(DVec3::new(0.0, 0.0, -60.0));
    scene.surfaces.push(wall);
    scene.at_distance(40.0).frame(96, 80)
}

/// The bust of the fixtures.
fn bust() -> Frame {
    load(fixture("bust.exr"), |_, _| ()).frame
}

fn axes(flip: Flip) -> DVec3 {
    DVec3::from([flip.x, flip.y, flip.z].map(|reversed| if reversed { -1.0 } else { 1.0 }))
}

/// Normals with these axes reversed.
fn reversed(normal: &Vector3Planes, flip: Flip) -> Vector3Planes {
    let at = |x, y| axes(flip) * normal.at(x, y);
    Vector3Planes::from_fn(normal.x.width(), normal.x.height(), at)
}

/// The scene as read with these axes reversed, and with depth as greys of no name, white far or near, or without depth.
fn read(scene: &Frame, flip: Flip, depth: Option<StoredDepth>) -> Loaded {
    let (mask, normal) = (&scene.mask, reversed(&scene.normal, flip));
    let distances = scene.depth.as_ref().unwrap();
    let seen = || covered(mask).map(|(x, y)| distances.at(x, y));
    let (near, far) = (seen().fold(f32::MAX, f32::min), seen().fold(0.0, f32::max));
    let grey = Plane::from_fn(mask.width(), mask.height(), |x, y| {
        let share = match mask.at(x, y) {
            true => (distances.at(x, y) - near) / (far - near),
            false => 1.0,
        };
        match depth {
            Some(StoredDepth::NormalizedNearIsOne) => 1.0 - share,
            _ => share,
        }
    });
    let Vector3Planes { x, y, z } = &normal;
    let part = Part::of([("N.X", x), ("N.Y", y), ("N.Z", z), ("grey.V", &grey)]);
    files::read(part, |inputs, _| {
        inputs.depth = Some(depth.map_or(Inputs::NONE, |_| "grey").into());
    })
}

const fn reversing(x: bool, y: bool) -> Flip {
    Flip { x, y, z: false }
}

const X: Flip = reversing(true, false);
const Y: Flip = reversing(false, true);

fn warns(loaded: &Loaded, of: &str) -> bool {
    loaded.warnings.iter().any(|text| text.contains(of))
}

#[test]
fn the_side_that_turns_outward_is_in_front() {
    for (name, scene) in [("ball", ball()), ("bust", bust())] {
        for flip in [Flip::NONE, X, Y] {
            for depth in [StoredDepth::WhiteFar, StoredDepth::NormalizedNearIsOne] {
                let loaded = read(&scene, flip, Some(depth));
                // Greys that a lens explains are read as distances, or as one over them, and then x reversed as a left-handed
                // world whose camera is recovered to some degrees.
                let falls = match loaded.conventions.depth_kind.unwrap() {
                    StoredDepth::NormalizedNearIsOne | StoredDepth::Inverse => true,
                    StoredDepth::WhiteFar | StoredDepth::Planar => false,
                    other => panic!("{name}: {other}"),
                };
                assert_eq!(falls, depth == StoredDepth::NormalizedNearIsOne, "{name}");
                let frame = &loaded.frame;
                let cosine = |(x, y)| frame.normal.at(x, y).dot(scene.normal.at(x, y));
                let cosines: Vec<f64> = covered(&frame.mask).map(cosine).collect();
                let mean = cosines.iter().sum::<f64>() / cosines.len() as f64;
                assert!(mean > 0.99, "{name}, {flip} reversed: {mean}");
            }
        }
    }
}

#[test]
fn without_depth_outlines_and_curl_tell_x_from_y() {
    let scene = bust();
    for flip in [Flip::NONE, X, Y, X.and(Y)] {
        let loaded = read(&scene, flip, None);
        assert_eq!(loaded.conventions.normal_flip, flip);
        // A bowl with y reversed looks as a dome with x reversed.
        let is_warned = warns(&loaded, "hollow form");
        assert_eq!(is_warned, flip.x, "{:?}", loaded.warnings);
    }
    // What ends on all sides but bends nowhere shows nothing.
    let mut flat = ball();
    flat.normal = Vector3Planes::from_fn(96, 80, |x, y| match x.min(y) > 8 && x.max(y) < 60 {
        true => DVec3::Z,
        false => DVec3::ZERO,
    });
    let loaded = read(&flat, X, None);
    assert_eq!(loaded.conventions.normal_flip, Flip::NONE);
}

/// How a test stores normals.
#[derive(Debug, Clone, Copy)]
enum Form {
    Floats,
    /// Two of the three components.
    Pair,
    /// 8 bits in a PNG.
    Codes,
}

/// A map of normals, read from a file, with depth in a file of its own where there is any.
fn read_map(map: &Vector3Planes, form: Form, depth: Option<&Plane>) -> Loaded {
    let desk = tempfile::tempdir().unwrap();
    let (width, height) = (map.x.width(), map.x.height());
    let path = desk.path().join(match form {
        Form::Codes => "map.png",
        _ => "map.exr",
    });
    let channels = [("N.X", &map.x), ("N.Y", &map.y), ("N.Z", &map.z)];
    match form {
        Form::Floats => Part::of(channels).write(&path),
        Form::Pair => Part::of(channels.into_iter().take(2)).write(&path),
        Form::Codes => image::RgbImage::from_fn(width as u32, height as u32, |x, y| {
            let n = map.at(x as usize, y as usize).to_array();
            image::Rgb(n.map(|n| (127.5 + 127.5 * n).round() as u8))
        })
        .save(&path)
        .unwrap(),
    }
    let depth = depth.map(|depth| {
        let path = desk.path().join("depth.exr");
        Part::of([("Z", depth)]).write(&path);
        path.to_str().unwrap().to_owned()
    });
    load(path, |inputs, _| inputs.depth = depth)
}

/// The mean of blocks of `side` pixels, or a plane of noise with a deviation of 0.05 added to it.
fn worse(plane: &Plane, side: usize, noise: u64) -> Plane {
    let mut state = noise;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005);
        state = state.wrapping_add(1);
        (state >> 40) as f32 / (1 << 24) as f32 - 0.5
    };
    let amplitude = if noise > 0 { 0.05 } else { 0.0 };
    Plane::from_fn(plane.width() / side, plane.height() / side, |x, y| {
        let samples = places(side, side).map(|(i, j)| plane.at(side * x + i, side * y + j));
        let sum: f32 = samples.sum();
        // The sum of twelve uniform numbers has a deviation of 1.
        sum / (side * side) as f32 + amplitude * (0..12).map(|_| uniform()).sum::<f32>()
    })
}

/// Eight conventions in three forms, with depth and without, clean, noisy and at half the resolution: small, so that rims are few.
#[test]
fn axes_are_right_or_in_doubt() {
    let scene = bust();
    let mask = scene.mask.clone();
    // A wall behind it: nothing tells where the bust ends but its rims.
    let before = |plane: &Plane, behind: f32| {
        Plane::from_fn(mask.width(), mask.height(), |x, y| match mask.at(x, y) {
            true => plane.at(x, y),
            false => behind,
        })
    };
    let depth = scene.depth.as_ref().unwrap();
    let far = depth.samples().iter().copied().fold(0.0, f32::max);
    let distances = before(depth, 2.0 * far);
    let n = &scene.normal;
    let truth = [(&n.x, 0.0), (&n.y, 0.3), (&n.z, 0.954)];
    let truth = truth.map(|(plane, behind)| before(plane, behind));
    let (mut all, mut right) = (0, 0);
    for (side, noise) in [(2, 0), (2, 7), (4, 0)] {
        let [x, y, z] = [0, 1, 2].map(|i| worse(&truth[i], side, (i as u64 + 1) * noise));
        let planes = Vector3Planes { x, y, z };
        let depth = worse(&distances, side, 0);
        for [x, y, z] in (0..8).map(|bits| [1, 2, 4].map(|axis| bits & axis > 0)) {
            let flip = Flip { x, y, z };
            let map = reversed(&planes, flip);
            for form in [Form::Floats, Form::Pair, Form::Codes] {
                for depth in [None, Some(&depth)] {
                    let loaded = read_map(&map, form, depth);
                    let read = &loaded.frame.normal;
                    let agree = |read: &Plane, own: &Plane| {
                        let pairs = read.samples().iter().zip(own.samples());
                        pairs.map(|(a, b)| a * b).sum::<f32>() > 0.0
                    };
                    let is_right = agree(&read.x, &planes.x) && agree(&read.y, &planes.y);
                    let is_doubted = warns(&loaded, "--normal-flip");
                    let what = (side, noise, flip, form, depth.is_some());
                    let found = &loaded.findings;
                    assert!(is_right || is_doubted, "{what:?} {found:?}");
                    all += 1;
                    right += usize::from(is_right);
                }
            }
        }
    }
    assert!(3 * right >= 2 * all, "{right} of {all}");
}
