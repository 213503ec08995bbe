//! Axes of normals and the sense of depth by outlines, where slopes leave two readings open.

use crate::common::exr::Part;
use relievo::frame::{Mask, Plane, Vector3Planes};
use relievo::io::inputs::{Flip, Inputs, StoredDepth};
use relievo::io::{Loaded, Needs, load};
use std::path::Path;

/// Normals and depth in view space.
struct Scene {
    normal: Vector3Planes,
    mask: Mask,
    depth: Plane,
}

/// A ball of 30 pixels before a wall, without perspective.
fn ball() -> Scene {
    let height = |x: usize, y: usize| {
        let (dx, dy) = (x as f64 - 47.5, 39.5 - y as f64);
        (900.0 - dx * dx - dy * dy, dx, dy)
    };
    let normal = Vector3Planes::from_fn(96, 80, |x, y| match height(x, y) {
        (square, dx, dy) if square > 0.0 => glam::DVec3::new(dx, dy, square.sqrt()) / 30.0,
        _ => glam::DVec3::Z,
    });
    let depth = Plane::from_fn(96, 80, |x, y| {
        let (square, ..) = height(x, y);
        100.0 - square.max(0.0).sqrt() as f32 - if square > 0.0 { 60.0 } else { 0.0 }
    });
    Scene {
        normal,
        mask: Mask::full(96, 80),
        depth,
    }
}

/// The bust of the fixtures.
fn bust() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/bust.exr");
    let inputs = Inputs {
        picture: path,
        ..Inputs::default()
    };
    let frame = load(&inputs, Needs::default()).unwrap().frame;
    Scene {
        normal: frame.normal,
        mask: frame.mask,
        depth: frame.depth.unwrap(),
    }
}

fn axes(flip: Flip) -> [f32; 3] {
    [flip.x, flip.y, flip.z].map(|reversed| if reversed { -1.0 } else { 1.0 })
}

/// The scene as read with these axes reversed, and with depth as greys of no name, white far or near, or without depth.
fn read(scene: &Scene, flip: Flip, depth: Option<StoredDepth>) -> Loaded {
    let Scene { normal, mask, .. } = scene;
    let signs = axes(flip);
    let stored: Vec<_> = [&normal.x, &normal.y, &normal.z]
        .into_iter()
        .zip(signs)
        .map(|(plane, sign)| plane.map(|n| sign * n))
        .collect();
    let seen = || {
        let samples = scene.depth.samples().iter();
        let pairs = samples.zip(mask.plane().samples());
        pairs.filter(|(_, covered)| **covered).map(|(d, _)| *d)
    };
    let (near, far) = (seen().fold(f32::MAX, f32::min), seen().fold(0.0, f32::max));
    let grey = Plane::from_fn(mask.width(), mask.height(), |x, y| {
        let share = match mask.at(x, y) {
            true => (scene.depth.at(x, y) - near) / (far - near),
            false => 1.0,
        };
        match depth {
            Some(StoredDepth::NormalizedNearIsOne) => 1.0 - share,
            _ => share,
        }
    });
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("scene.exr");
    let names = ["N.X", "N.Y", "N.Z", "grey.V"];
    Part::of(names.into_iter().zip(stored.iter().chain([&grey]))).write(&path);
    let inputs = Inputs {
        picture: path,
        depth: Some(depth.map_or(Inputs::NONE, |_| "grey").into()),
        ..Inputs::default()
    };
    load(&inputs, Needs::default()).unwrap()
}

const X: Flip = Flip {
    x: true,
    ..Flip::NONE
};
const Y: Flip = Flip {
    y: true,
    ..Flip::NONE
};

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
                let (mut cosines, mut count) = (0.0, 0);
                for y in 0..scene.mask.height() {
                    for x in (0..scene.mask.width()).filter(|&x| loaded.frame.mask.at(x, y)) {
                        cosines += loaded.frame.normal.at(x, y).dot(scene.normal.at(x, y));
                        count += 1;
                    }
                }
                let mean = cosines / f64::from(count);
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
        let warned = loaded
            .warnings
            .iter()
            .any(|text| text.contains("hollow form"));
        assert_eq!(warned, flip.x, "{:?}", loaded.warnings);
    }
    // What ends on all sides but bends nowhere shows nothing.
    let mut flat = ball();
    flat.normal = Vector3Planes::from_fn(96, 80, |x, y| match x.min(y) > 8 && x.max(y) < 60 {
        true => glam::DVec3::Z,
        false => glam::DVec3::ZERO,
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
    let inputs = Inputs {
        picture: path,
        depth,
        ..Inputs::default()
    };
    load(&inputs, Needs::default()).unwrap()
}

/// The mean of blocks of `side` pixels, or a plane of noise with a deviation of 0.05 added to it.
fn worse(plane: &Plane, side: usize, noise: u64) -> Plane {
    let mut state = noise;
    let mut uniform = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f32 / (1 << 24) as f32 - 0.5
    };
    let amplitude = if noise > 0 { 0.05 } else { 0.0 };
    Plane::from_fn(plane.width() / side, plane.height() / side, |x, y| {
        let samples = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
        let sum: f32 = samples
            .map(|(i, j)| plane.at(side * x + i, side * y + j))
            .sum();
        // The sum of twelve uniform numbers has a deviation of 1.
        sum / (side * side) as f32 + amplitude * (0..12).map(|_| uniform()).sum::<f32>()
    })
}

/// Eight conventions in three forms, with depth and without, clean, noisy and at half the resolution: small, so that rims are few.
#[test]
fn axes_are_right_or_in_doubt() {
    let mut scene = bust();
    let mask = scene.mask.clone();
    // A wall behind it: nothing tells where the bust ends but its rims.
    let wall = |x: usize, y: usize, n: f32, behind: f32| if mask.at(x, y) { n } else { behind };
    let far = scene
        .depth
        .samples()
        .iter()
        .fold(0.0_f32, |far, d| far.max(*d));
    let (width, height) = (mask.width(), mask.height());
    scene.depth = Plane::from_fn(width, height, |x, y| {
        wall(x, y, scene.depth.at(x, y), 2.0 * far)
    });
    let components = [&scene.normal.x, &scene.normal.y, &scene.normal.z];
    let behind = [0.0, 0.3, 0.954];
    let truth: Vec<_> = components
        .into_iter()
        .zip(behind)
        .map(|(plane, behind)| {
            Plane::from_fn(width, height, |x, y| wall(x, y, plane.at(x, y), behind))
        })
        .collect();
    let (mut all, mut right) = (0, 0);
    for (side, noise) in [(2, 0), (2, 7), (4, 0)] {
        let planes = truth.iter().zip(1..);
        let planes: Vec<_> = planes
            .map(|(plane, i)| worse(plane, side, i * noise))
            .collect();
        let depth = worse(&scene.depth, side, 0);
        for flip in (0..8).map(|bits| Flip {
            x: bits & 1 > 0,
            y: bits & 2 > 0,
            z: bits & 4 > 0,
        }) {
            let turned = planes.iter().zip(axes(flip));
            let turned: Vec<_> = turned
                .map(|(plane, sign)| plane.map(|n| sign * n))
                .collect();
            let map = Vector3Planes {
                x: turned[0].clone(),
                y: turned[1].clone(),
                z: turned[2].clone(),
            };
            for form in [Form::Floats, Form::Pair, Form::Codes] {
                for depth in [None, Some(&depth)] {
                    let loaded = read_map(&map, form, depth);
                    let read = &loaded.frame.normal;
                    let agree = |read: &Plane, own: &Plane| {
                        let pairs = read.samples().iter().zip(own.samples());
                        pairs.map(|(a, b)| a * b).sum::<f32>() > 0.0
                    };
                    let is_right = agree(&read.x, &planes[0]) && agree(&read.y, &planes[1]);
                    let is_doubted = loaded
                        .warnings
                        .iter()
                        .any(|text| text.contains("--normal-flip"));
                    let what = (side, noise, flip, form, depth.is_some());
                    assert!(
                        is_right || is_doubted,
                        "{what:?} {:?} {:?}",
                        loaded.findings,
                        loaded.warnings
                    );
                    all += 1;
                    right += usize::from(is_right);
                }
            }
        }
    }
    eprintln!("{right} of {all}");
    assert!(3 * right >= 2 * all, "{right} of {all}");
}
