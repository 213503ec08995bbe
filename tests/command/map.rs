//! Grey maps of normal maps.

use crate::common::apart;
use crate::common::program::Desk;
use glam::DVec3;
use relievo::frame::Plane;
use relievo::io::exr::SampleType;
use relievo::io::{Needs, inputs::Inputs, load};
use std::f64::consts::TAU;

const SIZE: usize = 96;
const RADIUS: f64 = 200.0;

/// Writes a normal map of 16 bits.
fn write_normals(desk: &Desk, name: &str, normal: impl Fn(f64, f64) -> DVec3) {
    let planes = [0, 1, 2].map(|axis| {
        Plane::from_fn(SIZE, SIZE, |x, y| {
            let middle = 0.5 * SIZE as f64;
            let n = normal(x as f64 + 0.5 - middle, middle - y as f64 - 0.5).normalize();
            (0.5 * n[axis] + 0.5) as f32
        })
    });
    desk.write_codes(name, planes, 16);
}

/// The cap of a ball, seen from above.
fn cap(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, (RADIUS * RADIUS - x * x - y * y).sqrt())
}

/// A roof with its ridge in the middle, each side 30 degrees steep.
fn roof(x: f64, _: f64) -> DVec3 {
    DVec3::new(x.signum() * 0.5, 0.0, 0.75_f64.sqrt())
}

fn grey_at(desk: &Desk, name: &str, x: usize, y: usize) -> f32 {
    let photo = desk.photo(name);
    assert_eq!(photo.channels.len(), 1, "{name}");
    photo.channels[0].at(x, y)
}

/// A ball of radius 200 has curvature 2/200 everywhere; a gain of 50 maps it to tanh(0.5) = 0.46212: a grey of 0.73106.
#[test]
fn a_ball_is_as_bright_as_it_is_curved() {
    let desk = Desk::new();
    write_normals(&desk, "ball.png", cap);
    let map = |words: &str| desk.make(format!("map ball.png --iterations 0 --gain 50 -q {words}"));
    map("-o {map}.png --map curvature,convex,concave");
    map("-o eight.tif --bits 8");
    // With y as in DirectX the cap is a saddle, whose curvatures cancel.
    map("-o flipped.png --normal-flip y");
    for (name, grey, tolerance) in [
        ("curvature.png", 0.731_06, 2e-3),
        ("convex.png", 0.462_12, 4e-3),
        ("concave.png", 0.0, 1e-6),
        ("eight.tif", 0.731_06, 4e-3),
        ("flipped.png", 0.5, 2e-3),
    ] {
        let found = grey_at(&desk, name, 40, 50);
        assert!((found - grey).abs() < tolerance, "{name}: {found}");
    }
    assert_eq!(desk.photo("curvature.png").bits, 16);
    assert_eq!(desk.photo("eight.tif").bits, 8);
    // In an EXR numbers are as they are, and stand beside each other.
    map("-o all.exr --map curvature,concave");
    let of = |name: &str| desk.channel("all.exr", name).at(40, 50);
    assert!((of("map.curvature") - 0.462_12).abs() < 4e-3);
    assert_eq!(of("map.concave"), 0.0);
}

/// Each scale has a file and a gain of its own; their sum is a weighted mean.
#[test]
fn scales_have_maps_of_their_own_or_one_together() {
    let desk = Desk::new();
    write_normals(&desk, "in.png", |x, y| {
        DVec3::new((x / 5.0).sin(), (y / 9.0).cos(), 3.0)
    });
    let said = desk
        .make("map in.png -o {map}.exr --scale 1,4 --map curvature,edges")
        .stderr;
    assert_eq!(said.matches("curvature gain").count(), 2, "{said}");
    let mut exr = desk.names("");
    exr.retain(|name| name.ends_with("exr"));
    assert_eq!(exr, ["curvature_1.exr", "curvature_4.exr", "edges.exr"]);
    let of = |name: &str, layer: &str| desk.channel(name, layer).at(50, 20);
    let fine = of("curvature_1.exr", "map.curvature_1");
    let coarse = of("curvature_4.exr", "map.curvature_4");
    desk.make("map in.png -o sum.exr --scale 1,4 --sum 1,3 -q --save-recipe r.toml");
    let sum = of("sum.exr", "map.curvature");
    let is_mean = (sum - (fine + 3.0 * coarse) / 4.0).abs() < 1e-6;
    assert!(is_mean, "{sum} {fine} {coarse}");
    // A recipe keeps what was asked.
    desk.make("run r.toml in.png -o by_recipe.exr -q");
    assert_eq!(of("by_recipe.exr", "map.curvature"), sum);
}

/// The ridge of a roof bends by 60 degrees: an edge, at which curvature is not cut out. Slopes of +-0.5, diffused by 2
/// pixels, change by 1 / (sqrt(2 pi) 2) = 0.2 per pixel: tanh(10 * 0.2) = 0.96.
#[test]
fn a_ridge_is_an_edge_and_the_most_convex() {
    let desk = Desk::new();
    write_normals(&desk, "roof.png", roof);
    desk.make("map roof.png -o {map}.png --map edges,convex --gain 10 --wrap none -q");
    let at = |name: &str, x: usize| grey_at(&desk, name, x, 40);
    assert_eq!([at("edges.png", 48), at("edges.png", 30)], [1.0, 0.0]);
    assert!(at("convex.png", 48) > 0.9 && at("convex.png", 30) < 0.01);
}

/// A ball of radius 200 seen from above is 200 - sqrt(200^2 - 2 47.5^2) = 11.63 pixels lower in the corner than in the middle,
/// and nothing hides its sky. A tile of waves goes on across its borders, also in its height.
#[test]
fn height_and_occlusion_are_those_of_the_surface() {
    let desk = Desk::new();
    write_normals(&desk, "ball.png", cap);
    let rows = "
        -o all.exr => 0: !NaN
        -o {map}.png => 0: is black ... root mean square
    ";
    desk.check(
        "map ball.png --wrap none --map height,occlusion,residual {}",
        rows,
    );
    let [height, sky] = ["map.height", "map.occlusion"].map(|name| desk.channel("all.exr", name));
    let drop = height.at(47, 47) - height.at(0, 95);
    assert!((drop - 11.63).abs() < 0.02, "{drop}");
    assert!((sky.at(40, 60) - 1.0).abs() < 1e-3);
    let grey = |x, y| grey_at(&desk, "height.png", x, y);
    assert!(grey(47, 47) > 0.99 && grey(0, 0) < 0.01);

    write_normals(&desk, "tile.png", |x, y| {
        let [u, v] = [x, y].map(|at| TAU * at / SIZE as f64);
        DVec3::new(-0.8 * u.cos(), 0.6 * (2.0 * v).sin(), 1.0)
    });
    desk.make("map tile.png -o tile.exr --map height,occlusion -q");
    for name in ["map.height", "map.occlusion"] {
        let plane = desk.channel("tile.exr", name);
        let jump = |a: usize, b: usize| {
            let jumps = (0..SIZE).map(|y| (plane.at(a, y) - plane.at(b, y)).abs());
            jumps.fold(0.0, f32::max)
        };
        let (across, beside) = (jump(0, SIZE - 1), jump(0, 1).max(jump(SIZE - 2, SIZE - 1)));
        assert!(across < 1.1 * beside, "{name} {across} {beside}");
    }
}

/// Height is written by `shape` where it is named, in floats; with depth and a camera it is minus the distance.
#[test]
fn a_render_has_its_height_as_a_layer_on_request() {
    let desk = Desk::new();
    desk.make("shape fixtures/bust.exr -q -o all.exr");
    let relief = "--write relief,bent --layers results --height-detail 4";
    desk.make(format!("shape fixtures/bust.exr -q -o relief.exr {relief}"));
    let types = |file: &str, name: &str| -> Vec<SampleType> {
        let file = desk.exr(file);
        let channels = file.parts.iter().flat_map(|part| &part.channels);
        let named = channels.filter(|channel| channel.name.contains(name));
        named.map(|channel| channel.sample_type).collect()
    };
    assert!(types("all.exr", "Relief").is_empty());
    assert_eq!(types("relief.exr", "").len(), 6);
    assert_eq!(types("relief.exr", "ReliefHeight"), [SampleType::Float]);
    assert!(!types("relief.exr", "ReliefSky").contains(&SampleType::Float));
    let inputs = Inputs {
        picture: desk.at("fixtures/bust.exr"),
        ..Inputs::default()
    };
    let needs = Needs {
        projection: true,
        ..Needs::default()
    };
    let frame = load(&inputs, needs).unwrap().frame;
    let depth = frame.depth.unwrap();
    let height = desk.channel("relief.exr", "relief.height");
    let mut apart: Vec<f32> = (0..frame.mask.height())
        .flat_map(|y| frame.mask.runs(y).flatten().map(move |x| (x, y)))
        .map(|(x, y)| (height.at(x, y) + depth.at(x, y)).abs() / depth.at(x, y))
        .collect();
    apart.sort_by(f32::total_cmp);
    // Normals shape it over four pixels alone.
    assert!(apart[apart.len() / 2] < 3e-4, "{}", apart[apart.len() / 2]);
}

#[test]
fn what_cannot_be_made_is_refused_in_a_line() {
    let desk = Desk::new();
    write_normals(&desk, "in.png", cap);
    write_normals(&desk, "in_edges.png", cap);
    let small = [0.5, 0.5, 1.0].map(|v| Plane::filled(8, 8, v));
    desk.write_codes("small.png", small, 16);
    let rows = "
        map in.png -o one.png --map curvature,edges => 2: {map}
        map in.png -o one.png --scale 1,4 => 2: {map}
        map in.png -o one.png --scale 1,4 --sum 1,2,3 => 2: --sum
        map in.png -o one.png --scale 1,4 --sum 0,0 => 2: --sum
        map in.png -o one.png --sum 1,2 => 2: --sum
        map in.png -o one.png --flatten => 2: --map normals
        // Each map is checked against the inputs.
        map in_edges.png -o in_{map}.png --map curvature,edges => 2: in_edges.png
        map in.png -o in_{map}.png --map curvature,edges --no-clobber => 2: in_edges.png
        // A normal map is no picture, and has a size.
        enhance in.png -o out.png => 1: --color
        normals in.png --detail small.png -o n.png -q => 1: 8x8
        normals in.png --as world -q -o w.png => 2: --camera FILE
        enhance fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png --occlusion computed -o no.png => 2: --scaling-ambient
    ";
    desk.check("{}", rows);
}

/// Normals come out as they went in, in the axes asked for: y is the other way round for DirectX. An EXR of them is read
/// again, but for the rounding of their lengths.
#[test]
fn normals_are_written_in_the_axes_asked_for() {
    let desk = Desk::new();
    write_normals(&desk, "ball.png", cap);
    desk.make("normals ball.png -o ball.exr -q");
    desk.make("normals ball.exr -o again.exr --layers results -q");
    desk.make("map ball.png --map normals --as directx -o dx.png -q");
    for axis in ["normal.x", "normal.y", "normal.z"] {
        let [first, again] = ["ball.exr", "again.exr"].map(|file| desk.channel(file, axis));
        assert!(apart(&first, &again) < 2e-7);
    }
    let first = desk.channel("ball.exr", "normal.y");
    let stored = ["ball.png", "dx.png"].map(|file| desk.photo(file));
    for (x, y) in [(3, 5), (90, 20), (48, 48)] {
        let stored = stored.each_ref();
        let [gl, dx] = stored.map(|photo| [0, 1, 2].map(|i| photo.channels[i].at(x, y)));
        // A code of 16 bits is 1.5e-5, and vectors of unit length are off by one.
        let off = [gl[0] - dx[0], gl[1] + dx[1] - 1.0, gl[2] - dx[2]];
        let is_near = off.iter().all(|off| off.abs() < 4e-5);
        assert!(is_near, "({x}, {y}): {off:?}");
        assert!((first.at(x, y) - (2.0 * gl[1] - 1.0)).abs() < 1e-4);
    }
}

/// A tilt by 20 degrees is subtracted, and a detail is turned onto what is left: on a flat surface it is the detail itself.
#[test]
fn a_bend_is_subtracted_and_a_detail_laid_over() {
    let desk = Desk::new();
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    write_normals(&desk, "tilted.png", |_, _| DVec3::new(sin, 0.0, cos));
    write_normals(&desk, "detail.png", |x, y| {
        DVec3::new(0.3 * (x / 4.0).sin(), 0.2 * (y / 5.0).cos(), 1.0)
    });
    for words in [
        "tilted.png --flatten -o flat.npy",
        "tilted.png --flatten --detail detail.png -o both.npy",
        "detail.png -o alone.npy",
    ] {
        desk.make(format!("normals {words} -q"));
    }
    let [flat, both, alone] = ["flat.npy", "both.npy", "alone.npy"].map(|file| {
        let photo = desk.photo(file);
        move |x, y| DVec3::from([0, 1, 2].map(|i| f64::from(photo.channels[i].at(x, y))))
    });
    // A code of 16 bits is 1.5e-5 of a component.
    assert!(flat(70, 9).distance(DVec3::Z) < 1e-4);
    for (x, y) in [(3, 90), (50, 40), (95, 0)] {
        let off = both(x, y).distance(alone(x, y));
        assert!(off < 2e-4, "({x}, {y}): {off}");
    }
}

#[test]
fn the_occlusion_of_the_shape_is_scaled_without_a_file_between() {
    let desk = Desk::new();
    desk.make("map fixtures/tablet.normal.png -o ao.png --map occlusion --bits 16");
    let enhanced = |flags: &str| {
        let photo = "fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png";
        desk.picture(format!("enhance {photo} {flags}")).channels
    };
    let read = enhanced("--occlusion ao.png --scaling-ambient 1");
    let computed = enhanced("--occlusion computed --scaling-ambient 1");
    let without = enhanced("");
    let off = |other: &[Plane]| {
        let pairs = computed.iter().zip(other);
        let pairs = pairs.flat_map(|(a, b)| a.samples().iter().zip(b.samples()));
        let mut off: Vec<f32> = pairs.map(|(a, b)| (a - b).abs()).collect();
        off.sort_by(f32::total_cmp);
        [
            off[off.len() / 2],
            off.iter().sum::<f32>() / off.len() as f32,
        ]
    };
    // The same occlusion; jumps of a layer of it make silhouettes, too.
    let ([median, mean], [_, change]) = (off(&read), off(&without));
    let is_same = median < 0.5 / 255.0 && 5.0 * mean < change;
    assert!(is_same, "{median} {mean} {change}");
}
