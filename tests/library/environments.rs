//! Environments and lit spheres, from their files to the light they give.

use crate::common::exr::{Part, Stored, write};
use crate::prelude::*;
use relievo::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
use relievo::io::{read_environment, read_lit_sphere};
use relievo::light::irradiance::irradiance;
use relievo::light::light_samples::{uniform_directions, uniform_lights};
use relievo::light::median_cut::median_cut;
use std::io::Cursor;
use std::path::Path;

/// The sum over lights that a white Lambertian surface with normal `n` shows.
fn shaded(lights: &[DirectionalLight], n: Vec3) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for light in lights {
        let cosine = f64::from(n.dot(light.to_light).max(0.0));
        for (sum, &intensity) in sum.iter_mut().zip(&light.intensity) {
            *sum += cosine * f64::from(intensity);
        }
    }
    sum
}

/// E(n) / pi by summing all pixels of the map.
fn summed(map: &Environment, normals: &[Vec3]) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; normals.len()];
    for (x, y) in places(map.width(), map.height()) {
        let share = map.solid_angle(y) / std::f64::consts::PI;
        let (direction, radiance) = (map.direction(x, y), map.pixel(x, y));
        for (sum, n) in sums.iter_mut().zip(normals) {
            let cosine = f64::from(n.dot(direction).max(0.0));
            let shares = radiance.map(|radiance| cosine * share * f64::from(radiance));
            sum.iter_mut()
                .zip(shares)
                .for_each(|(sum, own)| *sum += own);
        }
    }
    sums
}

/// Root mean square difference over all normals and colours, as a share of the mean.
fn error(found: &[[f64; 3]], truth: &[[f64; 3]]) -> f64 {
    let pairs = || found.iter().flatten().zip(truth.iter().flatten());
    let squares: f64 = pairs().map(|(a, b)| (a - b) * (a - b)).sum();
    let count = pairs().count() as f64;
    let mean = truth.iter().flatten().sum::<f64>() / count;
    (squares / count).sqrt() / mean
}

/// A sky, a ground of checks, a sun of 20 pixels and a lamp.
fn made_up() -> Environment {
    let grid = Environment::from_fn(512, 256, |_, _| [0.0; 3]);
    let sun = Vec3::new(0.5, 0.7, -0.5).normalize();
    Environment::from_fn(512, 256, |x, y| {
        let d = grid.direction(x, y);
        if d.dot(sun) > 0.9995 {
            return [4000.0, 3600.0, 3000.0];
        }
        match (d.y > 0.0, (x / 32 + y / 32) % 2) {
            (true, _) if (40..60).contains(&x) && y > 100 => [8.0, 6.0, 3.0],
            (true, _) => [0.3 + 0.4 * d.y, 0.5 + 0.4 * d.y, 1.0],
            (false, 0) => [0.3, 0.25, 0.2],
            (false, _) => [0.1, 0.12, 0.1],
        }
    })
}

/// All maps: the synthetic one, and the real ones if present.
fn maps() -> Vec<(&'static str, Environment)> {
    let files = "courtyard_512.hdr interior_1k_dwab.exr studio_1k_dwab.exr sunset_1k_dwab.exr";
    let real = files.split(' ').filter_map(|name| {
        let path = real(&format!("env/{name}"))?;
        Some((name, read_environment(&path).unwrap()))
    });
    std::iter::once(("made up", made_up()))
        .chain(real)
        .collect()
}

#[test]
fn more_lights_err_less() {
    let normals = uniform_directions(200);
    for (name, map) in maps() {
        let truth = summed(&map, &normals);
        let of = |lights: &[DirectionalLight]| {
            let found: Vec<_> = normals.iter().map(|&n| shaded(lights, n)).collect();
            error(&found, &truth)
        };
        let counts = [16, 64, 256, 1024];
        let cut = counts.map(|n| of(&median_cut(&map, n)));
        // Four times the lights halve the size of regions; half of the corresponding gain is required.
        for pair in cut.windows(2) {
            assert!(pair[1] < 0.7 * pair[0], "{name}: {cut:?}");
        }
        assert!(cut[3] < 0.01, "{name}: {cut:?}");
    }
}

#[test]
fn the_map_of_irradiance_is_the_sum_over_all_pixels() {
    let normals = uniform_directions(500);
    for (name, map) in maps() {
        let truth = summed(&map, &normals);
        let filtered = irradiance(&map);
        let read = |n: &Vec3| filtered.radiance(n.to_array()).map(f64::from);
        let found: Vec<_> = normals.iter().map(read).collect();
        let of_map = error(&found, &truth);
        // Bilinear look-ups between 128 columns: 3e-4 where irradiance is smooth, 1.2e-2 of a sun's
        // share on the seam of its shadow, which a twentieth of all normals touch.
        assert!(of_map < 3e-3, "{name}: {of_map}");
    }
}

#[test]
fn a_furnace_is_white() {
    let furnace = Environment::from_fn(256, 128, |_, _| [1.0; 3]);
    let normals = uniform_directions(100);
    for lights in [median_cut, uniform_lights] {
        let worst = [16, 64, 256, 1024, 4096].map(|count| {
            let lights = lights(&furnace, count);
            let errors = normals.iter().map(|&n| (shaded(&lights, n)[0] - 1.0).abs());
            errors.fold(0.0, f64::max)
        });
        assert!(worst[4] < 2e-3 && worst[4] < worst[0] / 10.0, "{worst:?}");
    }
}

/// `color` written as a picture.
fn written(path: &Path, format: PictureFormat, color: &ColorPlanes) {
    let mut file = Cursor::new(Vec::new());
    let picture = Picture::of(color, ViewTransform::Srgb);
    write_picture(&mut file, path, format, &picture).unwrap();
    std::fs::write(path, file.into_inner()).unwrap();
}

fn grey(width: usize, height: usize, value: f32) -> ColorPlanes {
    ColorPlanes::grey(Plane::filled(width, height, value))
}

#[test]
fn pictures_are_read_as_light() {
    let directory = tempfile::tempdir().unwrap();
    let files = [
        ("sky.png", PictureFormat::Png),
        ("sky.jpg", PictureFormat::Jpeg),
        ("sky.tif", PictureFormat::Tiff),
        ("sky.hdr", PictureFormat::Hdr),
    ];
    for (name, format) in files {
        let path = directory.path().join(name);
        for (width, height) in [(64, 32), (32, 32), (36, 48), (48, 36)] {
            written(&path, format, &grey(width, height, 0.25));
            let map = read_environment(&path).unwrap();
            let [r, ..] = map.radiance([0.3, -0.4, 0.8]);
            // A step of 8-bit sRGB at 0.25 is 0.004.
            assert!((r - 0.25).abs() < 3e-3, "{name}, {width}x{height}: {r}");
            // Twice as wide as high, it is surroundings and no picture of a ball.
            if width != 2 * height {
                let sphere = read_lit_sphere(&path).unwrap();
                assert!((sphere.color([0.9, 0.3])[1] - 0.25).abs() < 3e-3);
            }
        }
    }
}

#[test]
fn what_cannot_light_is_refused_in_one_line() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("upright.png");
    written(&path, PictureFormat::Png, &grey(30, 50, 0.5));
    let message = read_environment(&path).unwrap_err().to_string();
    let is_told = message.contains("upright.png: is 30x50") && message.contains("2:1");
    assert!(is_told, "{message}");
    let text = directory.path().join("notes.png");
    std::fs::write(&text, "no picture").unwrap();
    for path in [&text, &directory.path().join("absent.hdr")] {
        let map = read_environment(path).unwrap_err().to_string();
        let sphere = read_lit_sphere(path).unwrap_err().to_string();
        let name = path.file_name().unwrap().to_str().unwrap();
        for message in [map, sphere] {
            assert!(
                message.contains(name) && !message.contains('\n'),
                "{message}"
            );
        }
    }
}

#[test]
fn layers_of_a_lit_sphere_are_added_up() {
    let planes = [0.25, 0.5].map(|value| Plane::filled(16, 16, value));
    // The lower right quarter of the display window.
    let mut part = Part::new(Window::at(16, 16, 16, 16));
    for (layer, plane) in ["diffuse", "specular"].iter().zip(&planes) {
        for component in ["R", "G", "B"] {
            part = part.channel(&format!("{layer}.{component}"), Stored::Float, plane);
        }
    }
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("matcap.exr");
    write(&path, Window::from_size(32, 32), &[part]);
    let sphere = read_lit_sphere(&path).unwrap();
    assert_eq!(sphere.color([0.4, -0.4]), [0.75; 3]);
    assert_eq!(sphere.color([-0.4, -0.4]), [0.0; 3]);
}

#[test]
fn real_lit_spheres_are_read() {
    // The sum of both layers at the middle, from the files' own samples.
    for name in [
        "blender50_basic_grey.exr",
        "blender34_jade.exr",
        "litsphere_clay.png",
    ] {
        let Some(path) = real(&format!("matcap/{name}")) else {
            continue;
        };
        let sphere = read_lit_sphere(&path).unwrap();
        let largest = sphere.largest_luminance([0.2126, 0.7152, 0.0722]);
        assert!(largest > 0.3 && largest < 100.0, "{name}: {largest}");
    }
}

#[test]
fn one_place_in_two_formats_gives_the_same_light() {
    let files = ["courtyard_512.hdr", "courtyard_512_half_zip.exr"];
    let [Some(hdr), Some(exr)] = files.map(|name| real(&format!("env/{name}"))) else {
        return;
    };
    let [hdr, exr] = [hdr, exr].map(|path| read_environment(&path).unwrap());
    for (a, b) in hdr.power().into_iter().zip(exr.power()) {
        // HDR keeps 8 bits of the brightest channel.
        assert!((a / b - 1.0).abs() < 0.01, "{a}, {b}");
    }
    let mean = |map: &Environment| {
        let lights = median_cut(map, 64);
        let moment = |l: &DirectionalLight| f64::from(l.intensity[1]) * l.to_light.as_dvec3();
        lights.iter().map(moment).sum::<DVec3>().normalize()
    };
    assert!((mean(&hdr) - mean(&exr)).length() < 0.01);
}
