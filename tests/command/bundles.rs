//! Folders and archives as estimators of normals and depth write them, and maps as numbers.

use crate::common::program::Desk;
use crate::common::{apart, bits};
use glam::DVec3;
use relievo::frame::Plane;
use std::fs;

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
fn write_npy(desk: &Desk, name: &str, planes: &[Plane]) {
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
    desk.write(name, file);
}

/// Normals as colours, y up and z toward the viewer.
fn coded() -> [Plane; 3] {
    planes(|x, y| 0.5 * (to_gl() * ball(x, y).1 + DVec3::ONE))
}

/// Writes a folder as MoGe does, with normals in colours, 16 bits of each.
fn write_folder(desk: &Desk) {
    fs::create_dir(desk.at("moge")).unwrap();
    let lit = planes(|x, y| DVec3::splat(0.2 + 0.6 * -ball(x, y).1.z));
    desk.write_light("moge/image.png", lit);
    desk.write_codes("moge/normal.png", coded(), 16);
    let points = planes(|x, y| ball(x, y).0);
    write_npy(desk, "moge/depth.npy", &points[2..]);
    write_npy(desk, "moge/points.npy", &points);
    for name in ["moge/mask.png", "moge/depth_vis.png"] {
        desk.write_codes(name, planes(|_, _| DVec3::ONE), 8);
    }
    desk.write("moge/fov.json", r#"{"fov_x": 60.0, "fov_y": 46.826}"#);
    desk.write("moge/mesh.ply", "ply");
}

/// The largest error of normals in an array, in view space.
fn error(desk: &Desk, name: &str) -> f64 {
    let (photo, [width, height]) = (desk.photo(name), SIZE);
    let size = [photo.width, photo.height, photo.channels.len()];
    assert_eq!(size, [width, height, 3]);
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
    let desk = Desk::new();
    write_folder(&desk);
    // Flags overrule the folder. The picture is the image, and {name} the folder's. Nothing is written among what is read.
    let rows = "
        normals moge --depth none -o n.npy => 0: left out: depth.npy, points.npy
        normals moge -o n.npy => 0: image.png as image ... normal.png as normals ... depth.npy as depth ... mask.png as mask ... fov.json as camera ... left out: points.npy
        enhance moge -o {name}_e.png --backend cpu => 0
        inspect moge => 0: focal 83.1 px
        normals moge -o moge/n.png => 2: lies in moge
    ";
    desk.check("{}", rows);
    // A code of 16 bits is 3e-5, and vectors of unit length are off by two.
    assert!(error(&desk, "n.npy") < 1e-4);
    assert_eq!(desk.photo("moge_e.png").width, 96);
    // Two of a kind are told apart by a user alone.
    desk.copy("moge/normal.png", "moge/normal_2.png");
    let rows = "
        normals moge -o n.npy => 1: normal.png, normal_2.png
        normals moge/image.png --normal moge/normal_2.png -o n.npy -q => 0
    ";
    desk.check("{}", rows);
    let remove = |name: &str| fs::remove_file(desk.at(name)).unwrap();
    remove("moge/normal_2.png");
    // OpenCV calls the one channel of an EXR Y. Of two files of one name that of floats is taken.
    remove("moge/depth.npy");
    let [_, _, depth] = planes(|x, y| ball(x, y).0);
    desk.write_exr("moge/depth.exr", &[("Y", &depth)]);
    let [x, y, z] = planes(|x, y| to_gl() * ball(x, y).1);
    desk.write_exr("moge/normal.exr", &[("R", &x), ("G", &y), ("B", &z)]);
    let row = "=> 0: normal.exr as normals ... depth.exr as depth";
    desk.check("normals moge -o n.npy", row);
    assert!(error(&desk, "n.npy") < 1e-5);
    remove("moge/normal.exr");
    // A folder for each frame.
    fs::create_dir(desk.at("shot")).unwrap();
    fs::rename(desk.at("moge"), desk.at("shot/0002")).unwrap();
    desk.make("normals shot/#### --frames 2 -o n.####.npy -q");
    assert!(error(&desk, "n.0002.npy") < 1e-4);
    let row = "=> 2: all of which is read";
    desk.check("normals shot/#### --frames 2 -o shot/####/n.npy", row);
    fs::rename(desk.at("shot/0002"), desk.at("moge")).unwrap();
    // Axes as in OpenCV are found by the depth; so are normals where there are none but points.
    remove("moge/normal.png");
    write_npy(&desk, "moge/normals.npy", &planes(|x, y| ball(x, y).1));
    desk.make("normals moge -o n.npy -q");
    assert!(error(&desk, "n.npy") < 1e-5);
    for name in ["moge/normals.npy", "moge/depth.exr", "moge/image.png"] {
        remove(name);
    }
    desk.make("normals moge -o n.npy -q");
    // Differences of neighbours on a ball of radius 6, a fifteenth apart; at borders to one side alone.
    assert!(error(&desk, "n.npy") < 0.01);
    remove("moge/points.npy");
    desk.check("normals moge -o n.npy", "=> 1: holds no image, normal");
}

/// Arrays of an archive, which NumPy deflated, are the same as files.
#[test]
fn an_archive_is_read_by_the_names_of_its_arrays() {
    let desk = Desk::new();
    desk.copy("fixtures/estimated.npz", "in.npz");
    // The image holds codes of 8 bits, which are shown as they are where nothing is enhanced.
    let rows = "
        normals in.npz -o n.npy => 0: image as image ... normal as normals ... depth as depth ... mask as mask
        enhance in.npz -o e.png --scaling 0 --backend cpu => 0
        normals in.npz/depth --depth in.npz/depth -o d.npy => 0
        normals in.npz/image --normal in.npz/none -o n.npy => 1: found intrinsics, image ... depth
    ";
    desk.check("{}", rows);
    let (own, written) = (desk.photo("in.npz/normal"), desk.photo("n.npy"));
    for (own, written) in own.channels.iter().zip(&written.channels) {
        assert!(apart(own, written) < 1e-6);
    }
    let [shown, image] = ["e.png", "in.npz/image"].map(|name| desk.photo(name).channels);
    assert_eq!(shown, image, "codes");
}

/// Floats of whole numbers up to 240 are the codes of the same picture in 8 bits, as a warning says; the decoded light of it is
/// light.
#[test]
fn whole_numbers_of_a_picture_are_codes() {
    let desk = Desk::new();
    desk.write_codes("normal.png", coded(), 16);
    let codes = planes(|x, y| DVec3::new((x + y) as f64, 2.0 * y as f64, 240.0 - x as f64));
    write_npy(&desk, "codes.npy", &codes);
    let shares = codes.map(|plane| plane.map(|v| v / 255.0));
    write_npy(&desk, "shares.npy", &shares);
    let rows = "
        codes.npy => 0: codes of 8 bits
        shares.npy --colorspace srgb => 0: !codes of 8 bits
    ";
    for row in rows.trim().lines() {
        let words = "--normal normal.png --scaling 0 --backend cpu -o out.png";
        desk.check(&format!("enhance {{}} {words}"), row);
        let read = desk.photo("out.png").channels;
        let code = |i: usize| (255.0 * read[i].at(70, 50)).round();
        assert_eq!([0, 1, 2].map(code), [120.0, 100.0, 170.0]);
    }
}

/// Numbers of maps are those of an EXR, in NumPy arrays and in TIFF, and are read again.
#[test]
fn maps_are_written_as_numbers() {
    let desk = Desk::new();
    desk.write_codes("in.png", coded(), 16);
    let run = |words: &str| desk.make(format!("{words} --backend cpu -q"));
    let same = |file: &str, planes: &[Plane]| {
        let read = desk.photo(file);
        assert!(read.is_float, "{file}");
        for (own, read) in planes.iter().zip(&read.channels) {
            assert!(bits(own) == bits(read), "{file}");
        }
    };
    let in_exr = |file: &str, names: &[&str]| -> Vec<Plane> {
        let planes = names.iter().map(|name| desk.channel(file, name));
        planes.collect()
    };
    const NORMAL: &[&str] = &["normal.x", "normal.y", "normal.z"];
    run("normals in.png -o n.exr");
    run("map in.png --map height,curvature -o m.exr");
    run("shape in.png -o s.exr --write curvature.mean --depth-of-output float");
    let normals = in_exr("n.exr", NORMAL);
    for end in ["npy", "tif"] {
        run(&format!("normals in.png -o n.{end}"));
        same(&format!("n.{end}"), &normals);
        run(&format!(
            "map in.png --map height,curvature -o {{map}}.{end}"
        ));
        for name in ["height", "curvature"] {
            let expected = in_exr("m.exr", &[&format!("map.{name}")]);
            same(&format!("{name}.{end}"), &expected);
        }
        run(&format!("shape in.png -o s.{end} --write curvature.mean"));
        same(&format!("s.{end}"), &in_exr("s.exr", &["curvature.mean"]));
        // As they were read, but for the rounding of their lengths.
        run(&format!("normals n.{end} -o again.exr --layers results"));
        for (own, again) in normals.iter().zip(in_exr("again.exr", NORMAL)) {
            assert!(apart(own, &again) < 3e-7);
        }
        // x and y alone tell z.
        run(&format!("normals in.png --as xy -o xy.{end}"));
        run(&format!("normals xy.{end} -o xyz.npy"));
        assert!(error(&desk, "xyz.npy") < 1e-4);
    }
    run("map in.png -o codes.tif --bits 16");
    assert_eq!(desk.photo("codes.tif").bits, 16);
    let rows = "
        map in.png --map height,curvature -o m.npy => 2: {map}
        map in.png -o m.npy --bits 8 => 2: --bits
        map in.png -o m.png --bits 32 => 2: --bits
        shape in.png -o s.npy => 2: --write
        shape in.png --normal-flip none -o s.npy --write * => 2: --write
        enhance in.png -o e.npy => 2: .exr
        hatch in.png -o e.npy => 2: .exr
    ";
    desk.check("{}", rows);
}
