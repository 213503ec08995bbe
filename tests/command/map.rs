//! Grey maps of normal maps.

use super::inputs::write_planes;
use crate::common::exr::channel;
use crate::common::program::{fixture, names, relievo};
use glam::DVec3;
use relievo::frame::Plane;
use relievo::io::exr::{ExrFile, Limits, SampleType};
use relievo::io::photo::Photo;
use relievo::io::picture::ViewTransform;
use std::path::Path;

const SIZE: usize = 96;
const RADIUS: f64 = 200.0;

/// Writes a normal map of 16 bits.
fn write_normals(path: &Path, normal: impl Fn(f64, f64) -> DVec3) {
    let planes = [0, 1, 2].map(|axis| {
        Plane::from_fn(SIZE, SIZE, |x, y| {
            let middle = 0.5 * SIZE as f64;
            let n = normal(x as f64 + 0.5 - middle, middle - y as f64 - 0.5).normalize();
            (0.5 * n[axis] + 0.5) as f32
        })
    });
    write_planes(path, planes, None, 16, ViewTransform::None);
}

/// The cap of a ball, seen from above.
fn cap(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, (RADIUS * RADIUS - x * x - y * y).sqrt())
}

/// A roof with its ridge in the middle, each side 30 degrees steep.
fn roof(x: f64, _: f64) -> DVec3 {
    DVec3::new(x.signum() * 0.5, 0.0, 0.75_f64.sqrt())
}

fn grey_at(path: &Path, x: usize, y: usize) -> f32 {
    let photo = Photo::read(path).unwrap();
    assert_eq!(photo.channels.len(), 1, "{}", path.display());
    photo.channels[0].at(x, y)
}

/// A ball of radius 200 has curvature 2/200 everywhere; a gain of 50 maps it to tanh(0.5) = 0.46212: a grey of 0.73106.
#[test]
fn a_ball_is_as_bright_as_it_is_curved() {
    let desk = tempfile::tempdir().unwrap();
    write_normals(&desk.path().join("ball.png"), cap);
    let map = "map ball.png --iterations 0 --gain 50 -q";
    let of = |name: &str, grey: f32, tolerance: f32| {
        let found = grey_at(&desk.path().join(name), 40, 50);
        assert!((found - grey).abs() < tolerance, "{name}: {found}");
    };
    relievo(
        desk.path(),
        &format!("{map} -o {{map}}.png --map curvature,convex,concave"),
    )
    .done();
    of("curvature.png", 0.731_06, 2e-3);
    of("convex.png", 0.462_12, 4e-3);
    of("concave.png", 0.0, 1e-6);
    relievo(desk.path(), &format!("{map} -o eight.tif --bits 8")).done();
    of("eight.tif", 0.731_06, 4e-3);
    assert_eq!(
        Photo::read(&desk.path().join("curvature.png"))
            .unwrap()
            .bits,
        16
    );
    assert_eq!(Photo::read(&desk.path().join("eight.tif")).unwrap().bits, 8);
    // In an EXR numbers are as they are, and stand beside each other.
    relievo(
        desk.path(),
        &format!("{map} -o all.exr --map curvature,concave"),
    )
    .done();
    let of = |name: &str| channel(&desk.path().join("all.exr"), name).at(40, 50);
    assert!((of("map.curvature") - 0.462_12).abs() < 4e-3);
    assert_eq!(of("map.concave"), 0.0);
    // With y as in DirectX the cap is a saddle, whose curvatures cancel.
    relievo(
        desk.path(),
        &format!("{map} -o flipped.png --normal-flip y"),
    )
    .done();
    assert!((grey_at(&desk.path().join("flipped.png"), 40, 50) - 0.5).abs() < 2e-3);
}

/// Each scale has a file and a gain of its own; their sum is a weighted mean.
#[test]
fn scales_have_maps_of_their_own_or_one_together() {
    let desk = tempfile::tempdir().unwrap();
    write_normals(&desk.path().join("in.png"), |x, y| {
        DVec3::new((x / 5.0).sin(), (y / 9.0).cos(), 3.0)
    });
    let run = |words: &str| relievo(desk.path(), &format!("map in.png {words}"));
    let said = run("-o {map}.exr --scale 1,4 --map curvature,edges")
        .done()
        .stderr;
    assert_eq!(said.matches("curvature gain").count(), 2, "{said}");
    let exr: Vec<_> = names(desk.path(), "")
        .into_iter()
        .filter(|name| name.ends_with("exr"))
        .collect();
    assert_eq!(exr, ["curvature_1.exr", "curvature_4.exr", "edges.exr"]);
    let of = |name: &str, layer: &str| channel(&desk.path().join(name), layer).at(50, 20);
    let [fine, coarse] = [1, 4].map(|px| {
        of(
            &format!("curvature_{px}.exr"),
            &format!("map.curvature_{px}"),
        )
    });
    run("-o sum.exr --scale 1,4 --sum 1,3 -q").done();
    let sum = of("sum.exr", "map.curvature");
    assert!(
        (sum - (fine + 3.0 * coarse) / 4.0).abs() < 1e-6,
        "{sum} {fine} {coarse}"
    );
    // A recipe keeps what was asked.
    run("-o again.exr --scale 1,4 --sum 1,3 -q --save-recipe r.toml").done();
    relievo(desk.path(), "run r.toml in.png -o by_recipe.exr -q").done();
    assert_eq!(of("by_recipe.exr", "map.curvature"), sum);
}

/// The ridge of a roof bends by 60 degrees: an edge, at which curvature is not cut out. Slopes of +-0.5, diffused by 2
/// pixels, change by 1 / (sqrt(2 pi) 2) = 0.2 per pixel: tanh(10 * 0.2) = 0.96.
#[test]
fn a_ridge_is_an_edge_and_the_most_convex() {
    let desk = tempfile::tempdir().unwrap();
    write_normals(&desk.path().join("roof.png"), roof);
    relievo(
        desk.path(),
        "map roof.png -o {map}.png --map edges,convex --gain 10 --wrap none -q",
    )
    .done();
    let at = |name: &str, x: usize| grey_at(&desk.path().join(name), x, 40);
    assert_eq!([at("edges.png", 48), at("edges.png", 30)], [1.0, 0.0]);
    assert!(at("convex.png", 48) > 0.9 && at("convex.png", 30) < 0.01);
}

/// A ball of radius 200 seen from above is 200 - sqrt(200^2 - 2 47.5^2) = 11.63 pixels lower in the corner than in the middle,
/// and nothing hides its sky. A tile of waves goes on across its borders, also in its height.
#[test]
fn height_and_occlusion_are_those_of_the_surface() {
    let desk = tempfile::tempdir().unwrap();
    write_normals(&desk.path().join("ball.png"), cap);
    let map = "map ball.png --wrap none --map height,occlusion,residual";
    let said = relievo(desk.path(), &format!("{map} -o all.exr"))
        .done()
        .stderr;
    let plane = |name: &str| channel(&desk.path().join("all.exr"), name);
    let (height, sky) = (plane("map.height"), plane("map.occlusion"));
    let drop = height.at(47, 47) - height.at(0, 95);
    assert!((drop - 11.63).abs() < 0.02, "{drop}");
    assert!((sky.at(40, 60) - 1.0).abs() < 1e-3);
    assert!(said.is_empty() || !said.contains("NaN"), "{said}");
    let said = relievo(desk.path(), &format!("{map} -o {{map}}.png"))
        .done()
        .stderr;
    assert!(
        said.contains("is black") && said.contains("root mean square"),
        "{said}"
    );
    let grey = |x: usize, y: usize| grey_at(&desk.path().join("height.png"), x, y);
    assert!(grey(47, 47) > 0.99 && grey(0, 0) < 0.01);

    let wave = |x: f64, y: f64| {
        let [u, v] = [x, y].map(|at| std::f64::consts::TAU * at / SIZE as f64);
        DVec3::new(-0.8 * u.cos(), 0.6 * (2.0 * v).sin(), 1.0)
    };
    write_normals(&desk.path().join("tile.png"), wave);
    relievo(
        desk.path(),
        "map tile.png -o tile.exr --map height,occlusion -q",
    )
    .done();
    for name in ["map.height", "map.occlusion"] {
        let plane = channel(&desk.path().join("tile.exr"), name);
        let jump = |a: usize, b: usize| {
            (0..SIZE)
                .map(|y| (plane.at(a, y) - plane.at(b, y)).abs())
                .fold(0.0, f32::max)
        };
        let (across, beside) = (jump(0, SIZE - 1), jump(0, 1).max(jump(SIZE - 2, SIZE - 1)));
        assert!(across < 1.1 * beside, "{name} {across} {beside}");
    }
}

/// Height is written by `shape` where it is named, in floats; with depth and a camera it is minus the distance.
#[test]
fn a_render_has_its_height_as_a_layer_on_request() {
    let desk = tempfile::tempdir().unwrap();
    std::fs::copy(fixture("bust.exr"), desk.path().join("in.exr")).unwrap();
    let run = |words: &str| relievo(desk.path(), &format!("shape in.exr -q {words}")).done();
    run("-o all.exr");
    run("-o relief.exr --write relief,bent --layers results --height-detail 4");
    let channels = |name: &str| {
        let file = ExrFile::open(&desk.path().join(name), &Limits::default()).unwrap();
        let parts = file.parts.iter().flat_map(|part| &part.channels);
        parts
            .map(|channel| (channel.name.clone(), channel.sample_type))
            .collect::<Vec<_>>()
    };
    assert!(
        !channels("all.exr")
            .iter()
            .any(|(name, _)| name.contains("Relief"))
    );
    let own = channels("relief.exr");
    assert_eq!(own.len(), 6, "{own:?}");
    let is_float = |name: &str| {
        own.iter()
            .any(|(own, kind)| own.contains(name) && *kind == SampleType::Float)
    };
    assert!(is_float("ReliefHeight") && !is_float("ReliefSky"));
    let depth = relievo::io::load(
        &relievo::io::inputs::Inputs {
            picture: desk.path().join("in.exr"),
            ..Default::default()
        },
        relievo::io::Needs {
            projection: true,
            ..Default::default()
        },
    );
    let frame = depth.unwrap().frame;
    let (depth, height) = (
        frame.depth.unwrap(),
        channel(&desk.path().join("relief.exr"), "relief.height"),
    );
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
    let desk = tempfile::tempdir().unwrap();
    write_normals(&desk.path().join("in.png"), cap);
    write_normals(&desk.path().join("in_edges.png"), cap);
    let refused = |words: &str, code: i32, names: &str| {
        let line = relievo(desk.path(), &format!("map {words}")).refused(code);
        assert!(line.contains(names), "{line}");
    };
    refused("in.png -o one.png --map curvature,edges", 2, "{map}");
    refused("in.png -o one.png --scale 1,4", 2, "{map}");
    refused("in.png -o one.png --scale 1,4 --sum 1,2,3", 2, "--sum");
    refused("in.png -o one.png --scale 1,4 --sum 0,0", 2, "--sum");
    refused("in.png -o one.png --sum 1,2", 2, "--sum");
    // Each map is checked against the inputs.
    refused(
        "in_edges.png -o in_{map}.png --map curvature,edges",
        2,
        "in_edges.png",
    );
    assert!(!desk.path().join("in_curvature.png").exists());
    refused(
        "in.png -o in_{map}.png --map curvature,edges --no-clobber",
        2,
        "in_edges.png",
    );
    // A normal map is no picture.
    let line = relievo(desk.path(), "enhance in.png -o out.png").refused(1);
    assert!(line.contains("--color"), "{line}");
}

/// Normals come out as they went in, in the axes asked for: y is the other way round for DirectX. An EXR of them is read
/// again, but for the rounding of their lengths.
#[test]
fn normals_are_written_in_the_axes_asked_for() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_normals(&here.join("ball.png"), cap);
    relievo(here, "normals ball.png -o ball.exr -q").done();
    relievo(here, "normals ball.exr -o again.exr --layers results -q").done();
    relievo(here, "map ball.png --map normals --as directx -o dx.png -q").done();
    let of = |file: &str| {
        ["x", "y", "z"].map(|axis| channel(&here.join(file), &format!("normal.{axis}")))
    };
    let [first, again] = ["ball.exr", "again.exr"].map(of);
    let pairs = first.iter().zip(&again);
    let pairs = pairs.flat_map(|(a, b)| a.samples().iter().zip(b.samples()));
    assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 2e-7);
    let stored = ["ball.png", "dx.png"].map(|file| Photo::read(&here.join(file)).unwrap());
    for (x, y) in [(3, 5), (90, 20), (48, 48)] {
        let [gl, dx] = stored
            .each_ref()
            .map(|photo| [0, 1, 2].map(|i| photo.channels[i].at(x, y)));
        // A code of 16 bits is 1.5e-5, and vectors of unit length are off by one.
        let off = [gl[0] - dx[0], gl[1] + dx[1] - 1.0, gl[2] - dx[2]];
        assert!(
            off.iter().all(|off| off.abs() < 4e-5),
            "({x}, {y}): {off:?}"
        );
        assert!((first[1].at(x, y) - (2.0 * gl[1] - 1.0)).abs() < 1e-4);
    }
    let world = relievo(here, "normals ball.png --as world -o w.png");
    assert!(world.error(2).contains("--camera FILE"));
}

/// A tilt by 20 degrees is subtracted, and a detail is turned onto what is left: on a flat surface it is the detail itself.
#[test]
fn a_bend_is_subtracted_and_a_detail_laid_over() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let lean = 20_f64.to_radians();
    write_normals(&here.join("tilted.png"), |_, _| {
        DVec3::new(lean.sin(), 0.0, lean.cos())
    });
    let wave = |x: f64, y: f64| DVec3::new(0.3 * (x / 4.0).sin(), 0.2 * (y / 5.0).cos(), 1.0);
    write_normals(&here.join("detail.png"), wave);
    let run = |words: &str| relievo(here, &format!("{words} -q")).done();
    run("normals tilted.png --flatten -o flat.npy");
    let at = |file: &str, x: usize, y: usize| {
        let photo = Photo::read(&here.join(file)).unwrap();
        DVec3::from([0, 1, 2].map(|i| f64::from(photo.channels[i].at(x, y))))
    };
    // A code of 16 bits is 1.5e-5 of a component.
    assert!(at("flat.npy", 70, 9).distance(DVec3::Z) < 1e-4);
    run("normals tilted.png --flatten --detail detail.png -o both.npy");
    run("normals detail.png -o alone.npy");
    for (x, y) in [(3, 90), (50, 40), (95, 0)] {
        let off = at("both.npy", x, y).distance(at("alone.npy", x, y));
        assert!(off < 2e-4, "({x}, {y}): {off}");
    }
    let refused = |words: &str, code: i32, names: &str| {
        let line = relievo(here, words).refused(code);
        assert!(line.contains(names), "{line}");
    };
    refused("map tilted.png --flatten -o c.png", 2, "--map normals");
    let small = [0, 1, 2].map(|axis| Plane::filled(8, 8, if axis == 2 { 1.0 } else { 0.5 }));
    write_planes(
        &here.join("small.png"),
        small,
        None,
        16,
        ViewTransform::None,
    );
    refused("normals tilted.png --detail small.png -o n.png", 1, "8x8");
}

#[test]
fn the_occlusion_of_the_shape_is_scaled_without_a_file_between() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let [color, normal] = ["tablet.color.jpg", "tablet.normal.png"].map(fixture);
    let photo = format!("{} --normal {}", color.display(), normal.display());
    let map = format!(
        "map {} -o ao.png --map occlusion --bits 16",
        normal.display()
    );
    relievo(here, &map).ended(0);
    let enhanced = |name: &str, flags: &str| {
        relievo(here, &format!("enhance {photo} {flags} -o {name}")).ended(0);
        Photo::read(&here.join(name)).unwrap().channels
    };
    let read = enhanced("read.png", "--occlusion ao.png --scaling-ambient 1");
    let computed = enhanced("computed.png", "--occlusion computed --scaling-ambient 1");
    let without = enhanced("without.png", "");
    let off = |other: &[Plane]| {
        let pairs = computed.iter().zip(other);
        let pairs = pairs.flat_map(|(a, b)| a.samples().iter().zip(b.samples()));
        let mut off: Vec<f32> = pairs.map(|(a, b)| (a - b).abs()).collect();
        off.sort_by(f32::total_cmp);
        (
            off[off.len() / 2],
            off.iter().sum::<f32>() / off.len() as f32,
        )
    };
    // The same occlusion; jumps of a layer of it make silhouettes, too.
    let ([median, mean], change) = (<[f32; 2]>::from(off(&read)), off(&without).1);
    assert!(
        median < 0.5 / 255.0 && 5.0 * mean < change,
        "{median} {mean} {change}"
    );
    let unscaled = format!("enhance {photo} --occlusion computed -o no.png");
    let said = relievo(here, &unscaled).ended(2);
    assert!(said.contains("--scaling-ambient"), "{said}");
}
