//! Folders and archives as estimators of normals and depth write them, and maps as numbers.

use super::inputs::write_planes;
use crate::common::exr::{Part, channel};
use crate::common::program::{fixture, relievo};
use glam::DVec3;
use relievo::frame::Plane;
use relievo::io::photo::Photo;
use relievo::io::picture::ViewTransform;
use std::fs;
use std::path::Path;

const SIZE: [usize; 2] = [96, 72];
/// 60 degrees across 96 pixels: 48 / tan 30.
const FOCAL: f64 = 83.138_438_76;

/// A ball of radius 6 whose middle is 9 before the camera, which fills the view: it spans asin(6/9) = 41.8 degrees to each
/// side, and the corners are atan(.72) = 35.8 away. The point that a pixel shows, and its normal; x right, y down, z away.
fn ball(x: usize, y: usize) -> (DVec3, DVec3) {
    let [x, y] = [x as f64 - 47.5, y as f64 - 35.5];
    let ray = DVec3::new(x / FOCAL, y / FOCAL, 1.0);
    let (middle, square) = (DVec3::new(0.0, 0.0, 9.0), ray.length_squared());
    let along = ray.dot(middle);
    let t = (along - (along * along - square * (81.0 - 36.0)).sqrt()) / square;
    (t * ray, (t * ray - middle) / 6.0)
}

/// y up and z toward the viewer.
fn to_gl() -> DVec3 {
    DVec3::new(1.0, -1.0, -1.0)
}

fn planes(value: impl Fn(usize, usize) -> DVec3) -> [Plane; 3] {
    let [width, height] = SIZE;
    [0, 1, 2].map(|axis| Plane::from_fn(width, height, |x, y| value(x, y)[axis] as f32))
}

/// Writes a NumPy array of floats, of one plane or several.
fn write_npy(path: &Path, planes: &[Plane]) {
    let [width, height] = SIZE;
    let count = planes.len();
    let shape = match count {
        1 => format!("({height}, {width})"),
        _ => format!("({height}, {width}, {count})"),
    };
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.bytes());
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let samples = pixels.flat_map(|(x, y)| planes.iter().map(move |plane| plane.at(x, y)));
    file.extend(samples.flat_map(f32::to_le_bytes));
    fs::write(path, file).unwrap();
}

/// A folder as MoGe writes one, with normals in colours, 16 bits of each.
fn write_folder(folder: &Path) {
    fs::create_dir(folder).unwrap();
    let at = |name: &str| folder.join(name);
    let lit = planes(|x, y| DVec3::splat(0.2 + 0.6 * -ball(x, y).1.z));
    write_planes(&at("image.png"), lit, None, 8, ViewTransform::Srgb);
    let coded = planes(|x, y| 0.5 * (to_gl() * ball(x, y).1 + DVec3::ONE));
    write_planes(&at("normal.png"), coded, None, 16, ViewTransform::None);
    let [_, _, depth] = planes(|x, y| ball(x, y).0);
    write_npy(&at("depth.npy"), &[depth]);
    write_npy(&at("points.npy"), &planes(|x, y| ball(x, y).0));
    let covered = planes(|_, _| DVec3::ONE);
    write_planes(
        &at("mask.png"),
        covered.clone(),
        None,
        8,
        ViewTransform::None,
    );
    write_planes(&at("depth_vis.png"), covered, None, 8, ViewTransform::None);
    fs::write(at("fov.json"), r#"{"fov_x": 60.0, "fov_y": 46.826}"#).unwrap();
    fs::write(at("mesh.ply"), "ply").unwrap();
}

/// The largest error of normals in an array, in view space.
fn error(path: &Path) -> f64 {
    let photo = Photo::read(path).unwrap();
    let [width, height] = SIZE;
    assert_eq!(
        [photo.width, photo.height, photo.channels.len()],
        [width, height, 3]
    );
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let errors = pixels.map(|(x, y)| {
        let found = [0, 1, 2].map(|i| f64::from(photo.channels[i].at(x, y)));
        let expected = ball(x, y).1 * to_gl();
        (DVec3::from(found) - expected).abs().max_element()
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn a_folder_of_an_estimator_stands_where_a_file_does() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_folder(&here.join("moge"));
    let run = |words: &str| relievo(here, words);
    let said = run("normals moge -o n.npy").done().stderr;
    for taken in [
        "image.png as image",
        "normal.png as normals",
        "depth.npy as depth",
        "mask.png as mask",
        "fov.json as camera",
        "left out: points.npy",
    ] {
        assert!(said.contains(taken), "{taken}: {said}");
    }
    // A code of 16 bits is 3e-5, and vectors of unit length are off by two.
    assert!(error(&here.join("n.npy")) < 1e-4);
    // Flags overrule it.
    let said = run("normals moge --depth none -o n.npy").done().stderr;
    assert!(said.contains("left out: depth.npy, points.npy"), "{said}");
    // The picture is the image, and {name} the folder's.
    run("enhance moge -o {name}_e.png --backend cpu -q").done();
    assert_eq!(Photo::read(&here.join("moge_e.png")).unwrap().width, 96);
    let said = run("inspect moge").done().stdout;
    assert!(said.contains("focal 83.1 px"), "{said}");
    // Nothing is written among what is read, and two of a kind are told apart by a user alone.
    let line = run("normals moge -o moge/n.png").refused(2);
    assert!(line.contains("lies in moge"), "{line}");
    let at = |name: &str| here.join("moge").join(name);
    fs::copy(at("normal.png"), at("normal_2.png")).unwrap();
    let line = run("normals moge -o n.npy").refused(1);
    assert!(line.contains("normal.png, normal_2.png"), "{line}");
    run("normals moge/image.png --normal moge/normal_2.png -o n.npy -q").done();
    fs::remove_file(at("normal_2.png")).unwrap();
    // OpenCV calls the one channel of an EXR Y. Of two files of one name that of floats is taken.
    let [_, _, depth] = planes(|x, y| ball(x, y).0);
    fs::remove_file(at("depth.npy")).unwrap();
    Part::of([("Y", &depth)]).write(&at("depth.exr"));
    let [x, y, z] = planes(|x, y| to_gl() * ball(x, y).1);
    Part::of([("R", &x), ("G", &y), ("B", &z)]).write(&at("normal.exr"));
    let said = run("normals moge -o n.npy").done().stderr;
    assert!(
        said.contains("normal.exr as normals") && said.contains("depth.exr as depth"),
        "{said}"
    );
    assert!(error(&here.join("n.npy")) < 1e-5);
    fs::remove_file(at("normal.exr")).unwrap();
    // A folder for each frame.
    fs::create_dir(here.join("shot")).unwrap();
    fs::rename(here.join("moge"), here.join("shot/0002")).unwrap();
    run("normals shot/#### --frames 2 -o n.####.npy -q").done();
    assert!(error(&here.join("n.0002.npy")) < 1e-4);
    let line = run("normals shot/#### --frames 2 -o shot/####/n.npy").refused(2);
    assert!(line.contains("all of which is read"), "{line}");
    fs::rename(here.join("shot/0002"), here.join("moge")).unwrap();
    // Axes as in OpenCV are found by the depth; so are normals where there are none but points.
    fs::remove_file(at("normal.png")).unwrap();
    write_npy(&at("normals.npy"), &planes(|x, y| ball(x, y).1));
    run("normals moge -o n.npy -q").done();
    assert!(error(&here.join("n.npy")) < 1e-5);
    for name in ["normals.npy", "depth.exr", "image.png"] {
        fs::remove_file(at(name)).unwrap();
    }
    run("normals moge -o n.npy -q").done();
    // Differences of neighbours on a ball of radius 6, a fifteenth apart; at borders to one side alone.
    assert!(error(&here.join("n.npy")) < 0.01);
    fs::remove_file(at("points.npy")).unwrap();
    let line = run("normals moge -o n.npy").refused(1);
    assert!(line.contains("holds no image, normal"), "{line}");
}

/// Arrays of an archive, which NumPy deflated, are the same as files.
#[test]
fn an_archive_is_read_by_the_names_of_its_arrays() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    fs::copy(fixture("estimated.npz"), here.join("in.npz")).unwrap();
    let said = relievo(here, "normals in.npz -o n.npy").done().stderr;
    for taken in [
        "image as image",
        "normal as normals",
        "depth as depth",
        "mask as mask",
    ] {
        assert!(said.contains(taken), "{taken}: {said}");
    }
    let read = |name: &str| Photo::read(&here.join(name)).unwrap();
    let (own, written) = (read("in.npz/normal"), read("n.npy"));
    for (own, written) in own.channels.iter().zip(&written.channels) {
        let off = own.samples().iter().zip(written.samples());
        assert!(off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 1e-6);
    }
    // The image holds codes of 8 bits, which are shown as they are where nothing is enhanced.
    relievo(here, "enhance in.npz -o e.png --scaling 0 --backend cpu -q").done();
    assert_eq!(
        read("e.png").channels,
        read("in.npz/image").channels,
        "codes"
    );
    relievo(
        here,
        "normals in.npz/depth --depth in.npz/depth -o d.npy -q",
    )
    .done();
    let line = relievo(here, "normals in.npz/image --normal in.npz/none -o n.npy").refused(1);
    assert!(
        line.contains("found intrinsics, image") && line.contains("depth"),
        "{line}"
    );
}

/// Floats of whole numbers up to 240 are the codes of the same picture in 8 bits, as a warning says; the decoded light of it is
/// light.
#[test]
fn whole_numbers_of_a_picture_are_codes() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_folder(&here.join("in"));
    let codes = planes(|x, y| DVec3::new((x + y) as f64, 2.0 * y as f64, 240.0 - x as f64));
    write_npy(&here.join("codes.npy"), &codes);
    let light = |v: f32| v / 255.0;
    write_npy(
        &here.join("shares.npy"),
        &codes.each_ref().map(|plane| plane.map(light)),
    );
    let shown = |picture: &str| {
        let words = format!(
            "enhance {picture} --normal in/normal.png --scaling 0 --backend cpu -o out.png"
        );
        let said = relievo(here, &words).done().stderr;
        let read = Photo::read(&here.join("out.png")).unwrap();
        let code = |i: usize| (255.0 * read.channels[i].at(70, 50)).round();
        ([0, 1, 2].map(code), said.contains("codes of 8 bits"))
    };
    assert_eq!(shown("codes.npy"), ([120.0, 100.0, 170.0], true));
    let encoded = shown("shares.npy --colorspace srgb");
    assert_eq!(encoded, ([120.0, 100.0, 170.0], false));
}

/// Numbers of maps are those of an EXR, in NumPy arrays and in TIFF, and are read again.
#[test]
fn maps_are_written_as_numbers() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let coded = planes(|x, y| 0.5 * (to_gl() * ball(x, y).1 + DVec3::ONE));
    write_planes(&here.join("in.png"), coded, None, 16, ViewTransform::None);
    let run = |words: &str| relievo(here, &format!("{words} --backend cpu -q"));
    let bits =
        |plane: &Plane| -> Vec<u32> { plane.samples().iter().map(|v| v.to_bits()).collect() };
    let same = |file: &str, planes: &[Plane]| {
        let read = Photo::read(&here.join(file)).unwrap();
        assert!(read.is_float, "{file}");
        for (own, read) in planes.iter().zip(&read.channels) {
            assert!(bits(own) == bits(read), "{file}");
        }
    };
    let in_exr = |file: &str, names: &[&str]| -> Vec<Plane> {
        names
            .iter()
            .map(|name| channel(&here.join(file), name))
            .collect()
    };
    run("normals in.png -o n.exr").done();
    run("map in.png --map height,curvature -o m.exr").done();
    run("shape in.png -o s.exr --write curvature.mean --depth-of-output float").done();
    let normals = in_exr("n.exr", &["normal.x", "normal.y", "normal.z"]);
    for end in ["npy", "tif"] {
        run(&format!("normals in.png -o n.{end}")).done();
        same(&format!("n.{end}"), &normals);
        run(&format!(
            "map in.png --map height,curvature -o {{map}}.{end}"
        ))
        .done();
        same(&format!("height.{end}"), &in_exr("m.exr", &["map.height"]));
        same(
            &format!("curvature.{end}"),
            &in_exr("m.exr", &["map.curvature"]),
        );
        run(&format!("shape in.png -o s.{end} --write curvature.mean")).done();
        same(&format!("s.{end}"), &in_exr("s.exr", &["curvature.mean"]));
        // As they were read, but for the rounding of their lengths.
        run(&format!("normals n.{end} -o again.exr --layers results")).done();
        let again = in_exr("again.exr", &["normal.x", "normal.y", "normal.z"]);
        let pairs = normals.iter().zip(&again);
        let pairs = pairs.flat_map(|(a, b)| a.samples().iter().zip(b.samples()));
        assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 3e-7);
        // x and y alone tell z.
        run(&format!("normals in.png --as xy -o xy.{end}")).done();
        run(&format!("normals xy.{end} -o xyz.npy")).done();
        assert!(error(&here.join("xyz.npy")) < 1e-4);
    }
    run("map in.png -o codes.tif --bits 16").done();
    assert_eq!(Photo::read(&here.join("codes.tif")).unwrap().bits, 16);
    for (words, named) in [
        ("map in.png --map height,curvature -o m.npy", "{map}"),
        ("map in.png -o m.npy --bits 8", "--bits"),
        ("map in.png -o m.png --bits 32", "--bits"),
        ("shape in.png -o s.npy", "--write"),
        (
            "shape in.png --normal-flip none -o s.npy --write *",
            "--write",
        ),
        ("enhance in.png -o e.npy", ".exr"),
        ("hatch in.png -o e.npy", ".exr"),
    ] {
        let line = relievo(here, words).refused(2);
        assert!(line.contains(named), "{line}");
    }
}
