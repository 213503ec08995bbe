//! Normal maps in the ways that people have them: short, with a rim that faces away, without z, bare in an EXR.

use crate::common::exr::Part;
use crate::common::files::{load, read, try_load, try_read};
use crate::prelude::*;
use image::{Rgba, RgbaImage};
use relievo::io::srgb;
use std::path::Path;

const SIDE: u32 = 128;
const CENTER: f64 = 63.5;
/// A code of 8 bits is 2 / 255 of a component. Code and truth round to the same code, so they are apart by no more.
const CODE: f64 = 2.0 / 255.0;

/// The normal of a bump h = 9 exp(-r^2 / 2 s^2), s = 16 pixels: dh/dx = -h x / s^2, up to 9 / 16 exp(-1/2) = .34. The ground
/// around it is flat: at the border h < .004 and its slope < .001.
fn bump(x: u32, y: u32) -> DVec3 {
    let (x, y) = (f64::from(x) - CENTER, CENTER - f64::from(y));
    let h = 9.0 * (-(x * x + y * y) / 512.0).exp();
    DVec3::new(h * x / 256.0, h * y / 256.0, 1.0).normalize()
}

fn code(v: f64) -> u8 {
    (127.5 + 127.5 * v).round() as u8
}

fn save(path: &Path, pixel: impl Fn(u32, u32) -> [u8; 4]) {
    let map = RgbaImage::from_fn(SIDE, SIDE, |x, y| Rgba(pixel(x, y)));
    let is_opaque = map.pixels().all(|p| p[3] == 255);
    let map = image::DynamicImage::ImageRgba8(map);
    let saved = if is_opaque {
        map.to_rgb8().save(path)
    } else {
        map.save(path)
    };
    saved.unwrap();
}

/// Saves opaque codes of a map.
fn save_rgb(path: &Path, pixel: impl Fn(u32, u32) -> [u8; 3]) {
    save(path, |x, y| {
        let [r, g, b] = pixel(x, y);
        [r, g, b, 255]
    });
}

/// A photograph of one colour.
fn save_photo(path: &Path) {
    save_rgb(path, |_, _| [200, 150, 120]);
}

/// The codes of a normal.
fn codes(normal: DVec3) -> [u8; 3] {
    normal.to_array().map(code)
}

/// A picture with a map of its normals.
fn load_with(picture: &Path, map: &Path) -> Loaded {
    load(picture, |inputs, _| inputs.normal = Some(text(map)))
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().into()
}

/// The largest error of a component of the normals that are covered, which are `count`.
fn error(loaded: &Loaded, count: usize, truth: impl Fn(u32, u32) -> DVec3) -> f64 {
    let frame = &loaded.frame;
    assert_eq!(frame.mask.count(), count);
    let errors = covered(&frame.mask).map(|(x, y)| {
        let off = frame.normal.at(x, y) - truth(x as u32, y as u32);
        off.abs().max_element()
    });
    largest(errors)
}

const ALL: usize = (SIDE * SIDE) as usize;

#[test]
fn short_vectors_are_used_where_alpha_covers_them() {
    let folder = tempfile::tempdir().unwrap();
    let [photo, map] = ["photo.png", "map.png"].map(|name| folder.path().join(name));
    let is_inside = |x: u32, y: u32| (f64::from(x) - CENTER).hypot(f64::from(y) - CENTER) < 50.0;
    let alpha = |x, y| 255 * u8::from(is_inside(x, y));
    // Outside of the sprite lies what no normal map holds.
    save(&map, |x, y| match is_inside(x, y) {
        true => {
            let [r, g, b] = codes(0.65 * bump(x, y));
            [r, g, b, alpha(x, y)]
        }
        false => [143, 115, 84, 0],
    });
    save(&photo, |x, y| [200, 150, 120, alpha(x, y)]);
    let loaded = load(photo, |inputs, needs| {
        inputs.normal = Some(text(&map));
        needs.color = true;
    });
    let all = places(SIDE as usize, SIDE as usize);
    let count = all.filter(|&(x, y)| is_inside(x as u32, y as u32)).count();
    // Two components are off by a code each, of vectors .65 long; the third follows.
    assert!(error(&loaded, count, bump) < 1.5 * CODE / 0.65);
    let said = loaded.warnings.concat();
    assert!(said.contains("0.65 long"), "{said}");
}

#[test]
fn an_integer_picture_is_in_view_space_though_a_tenth_of_it_faces_away() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    // Every n-th column leans over to z = -.28.
    let map = |n: u32| {
        save_rgb(&path, |x, y| match x % n {
            0 => codes(DVec3::new(0.96, 0.0, -0.28)),
            _ => codes(bump(x, y)),
        });
        try_load(&path, |_, _| ())
    };
    // 7 of 128 columns are 5.5 %, 26 are 20 %.
    let loaded = map(20).unwrap();
    assert!((loaded.frame.normal.z.at(20, 64) + 0.28).abs() < 0.01);
    let said = loaded.warnings.concat();
    let reason = "view, as in any picture of integers";
    assert!(said.contains(reason), "{said}");
    assert!(map(5).is_err());
}

#[test]
fn z_is_rebuilt_where_blue_says_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [path, photo] = ["map.png", "photo.png"].map(|name| folder.path().join(name));
    save_photo(&photo);
    // z of the bump, constants, and occlusion that darkens the bump's foot.
    let occlusion = |x, y| (255.0 - 2000.0 * (1.0 - bump(x, y).z)) as u8;
    type Blue<'a> = (&'a dyn Fn(u32, u32) -> u8, bool);
    let blues: [Blue; 5] = [
        (&|x, y| code(bump(x, y).z), false),
        (&|_, _| 0, true),
        (&|_, _| 128, true),
        (&|_, _| 255, true),
        (&occlusion, true),
    ];
    for (i, (blue, is_rebuilt)) in blues.into_iter().enumerate() {
        save_rgb(&path, |x, y| {
            let [r, g, _] = codes(bump(x, y));
            [r, g, blue(x, y)]
        });
        let loaded = load_with(&photo, &path);
        let error = error(&loaded, ALL, bump);
        // z changes by x / z = .32 of x and y together.
        assert!(error < 1.5 * CODE, "{i}: {error}");
        let said = loaded.warnings.concat();
        assert_eq!(said.contains("z is rebuilt"), is_rebuilt, "{i}: {said}");
        let found = loaded.conventions.normal_encoding;
        assert_eq!(found == NormalEncoding::Xy, is_rebuilt, "{i}");
    }
    // x in alpha, y in green, as DXT5nm: told without a flag, whether the map is named or the picture itself.
    save(&path, |x, y| {
        let [r, g, _] = codes(bump(x, y));
        [255, g, 255, r]
    });
    for loaded in [load_with(&photo, &path), load(&path, |_, _| ())] {
        assert!(error(&loaded, ALL, bump) < 1.5 * CODE);
        assert_eq!(loaded.conventions.normal_encoding, NormalEncoding::Ag);
    }
    // A photograph of one colour is none.
    let photo_alone = try_load(&photo, |inputs, _| inputs.normal = Some(text(&photo)));
    assert!(photo_alone.is_err());
}

/// What a program does to a map that it takes for a picture is undone, unless a user says that the codes are those of normals.
/// Near z = 1 the curve of sRGB makes 1 / 2.4 codes of one, so half a code of rounding is up to 1.2.
#[test]
fn mistakes_in_saving_a_map_are_undone() {
    let folder = tempfile::tempdir().unwrap();
    let [path, photo] = ["map.png", "photo.png"].map(|name| folder.path().join(name));
    save_photo(&photo);
    let share = |v: f64| 0.5 + 0.5 * v;
    let round = |share: f64| (255.0 * share).round() as u8;
    let as_light = |v| round(srgb::encoded(share(v)));
    let as_linear = |v| round(srgb::decoded(share(v)));
    type Saved<'a> = &'a dyn Fn(DVec3) -> [u8; 3];
    let saved: [(Saved, &str); 4] = [
        (&codes, ""),
        (&|n| n.to_array().map(as_light), "saved as sRGB light"),
        (&|n| n.to_array().map(as_linear), "made linear"),
        (&|n| [n.y, n.x, n.z].map(code), "red and green exchanged"),
    ];
    for (saved, mistake) in saved {
        save_rgb(&path, |x, y| saved(bump(x, y)));
        let loaded = load_with(&photo, &path);
        let said = loaded.warnings.concat();
        let is_said = said.contains("takes them as they are");
        assert_eq!(is_said, !mistake.is_empty(), "{mistake}: {said}");
        assert!(said.contains(mistake), "{mistake}: {said}");
        let off = error(&loaded, ALL, bump);
        assert!(off < 1.5 * CODE, "{mistake}: {off}");
        let loaded = load(&photo, |inputs, _| {
            inputs.normal = Some(text(&path));
            inputs.normal_encoding = Some(NormalEncoding::Unsigned);
        });
        let said = loaded.warnings.concat();
        let is_said = said.contains("takes them as they are");
        assert!(!is_said, "{mistake}: {said}");
        let is_kept = error(&loaded, ALL, bump) > 0.1;
        assert_eq!(is_kept, !mistake.is_empty(), "{mistake}");
    }
}

#[test]
fn a_flat_code_of_128_is_flat() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.png");
    // h = 4 (1 - r^2 / 20^2)^3 within r < 20, dh/dr = -24 r / 20^2 (1 - r^2 / 20^2)^2; flat around it.
    let truth = |x: u32, y: u32| {
        let (x, y) = (f64::from(x) - CENTER, CENTER - f64::from(y));
        let inside = (1.0 - (x * x + y * y) / 400.0).max(0.0);
        let steepness = 24.0 / 400.0 * inside * inside;
        DVec3::new(steepness * x, steepness * y, 1.0).normalize()
    };
    // 127.5 rounds to 128 where it is flat: 128 / 127.5 - 1 = .0039 of slope, half a pixel of height over 128. Less than
    // a tenth of it is left, 65 pixels from the bump.
    save_rgb(&path, |x, y| codes(truth(x, y)));
    let loaded = load(path, |_, _| ());
    assert!(error(&loaded, ALL, truth) < CODE);
    for (x, y) in [(3, 3), (124, 3), (3, 124), (124, 124)] {
        let corner = loaded.frame.normal.at(x, y);
        assert!(corner.truncate().abs().max_element() < 0.0004, "{corner}");
    }
}

#[test]
fn vectors_of_an_exr_need_neither_name_nor_z() {
    let plane = |at: &dyn Fn(DVec3) -> f64| {
        let side = SIDE as usize;
        Plane::from_fn(side, side, |x, y| at(bump(x as u32, y as u32)) as f32)
    };
    let [x, y, z] = [plane(&|n| n.x), plane(&|n| n.y), plane(&|n| n.z)];
    let rgb = read(Part::of([("B", &z), ("G", &y), ("R", &x)]), |_, _| ());
    assert!(error(&rgb, ALL, bump) < 1e-6);
    let xyz = read(Part::of([("X", &x), ("Y", &y), ("Z", &z)]), |_, _| ());
    assert_eq!(rgb.frame.normal, xyz.frame.normal);
    assert!(xyz.frame.depth.is_none() && xyz.frame.color.is_none());
    let pair = read(Part::of([("N.X", &x), ("N.Y", &y)]), |_, _| ());
    assert!(error(&pair, ALL, bump) < 1e-6);
    assert_eq!(pair.conventions.normal_encoding, NormalEncoding::Xy);
    // The octahedron |x| + |y| + |z| = 1 seen along z.
    let sum = |n: DVec3| n.abs().element_sum();
    let [u, v] = [plane(&|n| n.x / sum(n)), plane(&|n| n.y / sum(n))];
    let oct = Part::of([("M.X", &u), ("M.Y", &v)]);
    let loaded = read(oct, |inputs, _| {
        inputs.normal = Some("M".into());
        inputs.normal_encoding = Some(NormalEncoding::Oct);
    });
    assert!(error(&loaded, ALL, bump) < 1e-6);
}

#[test]
fn axes_have_the_names_of_those_who_reverse_them() {
    for (name, [x, y, z]) in [
        ("opengl", [false; 3]),
        ("DirectX", [false, true, false]),
        ("opencv", [false, true, true]),
        ("stablenormal", [true, false, false]),
    ] {
        assert_eq!(name.parse(), Ok(Flip { x, y, z }), "{name}");
    }
    assert!("open".parse::<Flip>().is_err());
}

#[test]
fn a_layer_of_light_is_no_normal_map() {
    // From .1 to 9 in all channels: lengths from .17 to 16, of which few are near 1.
    let light = Plane::from_fn(64, 64, |x, y| 0.1 + 0.14 * x.min(y) as f32);
    let part = Part::of(["L.R", "L.G", "L.B"].map(|name| (name, &light)));
    let found = try_read(part, |inputs, _| inputs.normal = Some("L".into()));
    let said = found.err().unwrap().to_string();
    assert!(said.contains("is no normal map"), "{said}");
}

/// JPEG moves the samples of gentle forms by a code or two, in blocks: the smoothest normals that near bend as the form does.
#[test]
fn gentle_forms_are_read_from_jpeg_without_its_blocks() {
    const WIDE: u32 = 320;
    let folder = tempfile::tempdir().unwrap();
    // The slopes of 3 sin(x / 40) sin(y / 55).
    let exact = |x: u32, y: u32| {
        let (sx, cx) = (f64::from(x) / 40.0).sin_cos();
        let (sy, cy) = (f64::from(y) / 55.0).sin_cos();
        DVec3::new(-cx * sy * 3.0 / 40.0, sx * cy * 3.0 / 55.0, 1.0).normalize()
    };
    let in_codes = |x, y| image::Rgb(codes(exact(x, y)));
    let map = image::RgbImage::from_fn(WIDE, WIDE, in_codes);
    // Root mean square error of the change of x over 8 pixels, where blocks show.
    let error = |x_of: &dyn Fn(u32, u32) -> f64| {
        let bend = |of: &dyn Fn(u32, u32) -> f64, x, y| of(x + 8, y) - of(x, y);
        let side = WIDE as usize - 40;
        let squares = places(side, side).map(|(x, y)| {
            let [x, y] = [x as u32 + 16, y as u32 + 16];
            (bend(x_of, x, y) - bend(&|x, y| exact(x, y).x, x, y)).powi(2)
        });
        let squares: Vec<f64> = squares.collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    for quality in [95, 75] {
        let path = folder.path().join(format!("{quality}.jpg"));
        let file = std::fs::File::create(&path).unwrap();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(file, quality);
        map.write_with_encoder(encoder).unwrap();
        let stored = image::open(&path).unwrap().to_rgb8();
        let before = error(&|x, y| f64::from(stored.get_pixel(x, y).0[0]) / 127.5 - 1.0);
        let normal = load(path, |_, _| ()).frame.normal;
        let after = error(&|x, y| normal.at(x as usize, y as usize).x);
        let case = format!("{quality}: {before:.1e} to {after:.1e}");
        assert!(3.0 * after < before, "{case}");
    }
}
