//! Pictures whose opposite borders continue each other.

use crate::common::files::load;
use crate::prelude::*;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

const SIZE: [usize; 2] = [40, 28];

/// The normal and the brightness at a pixel of an endless pavement: waves, and a step in slope that makes a crease.
fn pavement(x: i64, y: i64) -> ([f32; 3], f32) {
    let [u, v] = [
        x.rem_euclid(40) as f64 / 40.0,
        y.rem_euclid(28) as f64 / 28.0,
    ];
    let edge = if (0.3..0.5).contains(&u) { 1.5 } else { 0.0 };
    let slope = [
        0.5 * (TAU * u).cos() + 0.2 * (TAU * (3.0 * u + v)).sin() + edge,
        0.4 * (TAU * 2.0 * v).sin() - 0.1 * (TAU * (u - 5.0 * v)).cos(),
    ];
    let n = glam::DVec3::new(-slope[0], -slope[1], 1.0).normalize();
    let light = 0.5 + 0.3 * (TAU * (u + 2.0 * v)).sin();
    (n.as_vec3().to_array(), light as f32)
}

/// Saves normals as a map in codes of 8 bits.
fn save(path: &Path, [width, height]: [usize; 2], normal: impl Fn(u32, u32) -> DVec3) {
    let code = |v: f64| ((0.5 * v + 0.5) * 255.0).round() as u8;
    let pixel = |x, y| image::Rgb(normal(x, y).normalize().to_array().map(code));
    let picture = image::RgbImage::from_fn(width as u32, height as u32, pixel);
    picture.save(path).unwrap();
}

/// A window of it.
fn part(window: Window, wraps: [bool; 2]) -> Frame {
    let (mut normals, mut rgb) = (Vec::new(), Vec::new());
    for y in window.y0..window.y1 {
        for x in window.x0..window.x1 {
            let (n, light) = pavement(x.into(), y.into());
            normals.extend(n);
            rgb.extend([light, 0.8 * light, 0.5 * light]);
        }
    }
    let frame = Frame::builder(window.width(), window.height())
        .normals(Normals::view(&normals))
        .color(&rgb)
        .build();
    Frame {
        wraps,
        ..frame.unwrap()
    }
}

fn tile(wraps: [bool; 2]) -> Frame {
    part(Window::from_size(SIZE[0], SIZE[1]), wraps)
}

/// A tile of normals that wraps in both directions.
fn endless(width: usize, height: usize, normal: impl Fn(usize, usize) -> DVec3) -> Frame {
    let normals = places(width, height).map(|(x, y)| normal(x, y).normalize().as_vec3());
    let normals: Vec<f32> = normals.flat_map(|n| n.to_array()).collect();
    let frame = Frame::builder(width, height).normals(Normals::view(&normals));
    Frame {
        wraps: [true; 2],
        ..frame.build().unwrap()
    }
}

/// What a request makes of a frame.
fn run(request: &Request, frame: &Frame) -> Outcome {
    Engine::cpu().run(request, frame, &Run::new()).unwrap()
}

/// Shape at this scale.
fn at_scale(sigma: f32) -> ShapeParams {
    default_but(|shape: &mut ShapeParams| shape.scale = Scale::Sigma(sigma))
}

/// All products, of light and of shape.
fn made(frame: &Frame, scaling: ScalingParams) -> [Outcome; 2] {
    let params = Params::of(at_scale(3.0), scaling);
    let layers = Goal::Layers {
        and: &[],
        more_px: &[9.0],
    };
    [Request::new(layers, params), Request::enhance(params)].map(|request| run(&request, frame))
}

/// Expects the samples of one outcome in a window of another.
#[track_caller]
fn are_cut(parts: &Outcome, wholes: &Outcome, window: Window, what: impl std::fmt::Debug) {
    assert!(parts.products().count() > 0);
    for ((product, part), (_, whole)) in parts.products().zip(wholes.products()) {
        for (part, whole) in part.iter().zip(whole) {
            let all = Window::from_size(whole.width(), whole.height());
            assert_eq!(**part, whole.crop(all, window), "{product:?} {what:?}");
        }
    }
}

/// A tile is the middle of the repetition, bit for bit; along an axis that does not wrap, of one row of it.
#[test]
fn a_tile_is_the_middle_of_its_repetition() {
    let [w, h] = SIZE.map(|length| length as i32);
    // Sigma 9 reaches beyond one repetition of 28 rows: five of them are the truth.
    let repetitions = [
        ([true, true], [-2 * w, -2 * h, 3 * w, 3 * h]),
        ([true, false], [-2 * w, 0, 3 * w, h]),
        ([false, true], [0, -2 * h, w, 3 * h]),
    ];
    for (wraps, [x0, y0, x1, y1]) in repetitions {
        let around = Window { x0, y0, x1, y1 };
        let whole = part(around, [false; 2]);
        let middle = Window::at(-x0, -y0, SIZE[0], SIZE[1]);
        let [tiles, wholes] = [&tile(wraps), &whole].map(|frame| made(frame, given(3.0, 0.8)));
        for (tile, whole) in tiles.iter().zip(&wholes) {
            are_cut(tile, whole, middle, wraps);
        }
    }
    // A part of it is no tile across a border that it does not reach.
    let rows = tile([true; 2]).crop(Window::at(0, 5, SIZE[0], 10));
    assert_eq!(rows.wraps, [true, false]);
    // It matters: at the border a tile is another than the same pixels alone.
    let [alone, wrapped] = [[false; 2], [true; 2]].map(|wraps| {
        let [shape, _] = made(&tile(wraps), given(3.0, 0.8));
        shape.shape.kappa.unwrap()
    });
    assert!((alone.at(0, 10) - wrapped.at(0, 10)).abs() > 0.01);
}

/// Slopes 0.1 cos(k x), k = TAU / 40 (-n_x: the default takes no foreshortening), are an eigenvector of diffusion with joined borders, of the eigenvalue
/// 2 cos k - 2: after the time sigma^2 / 2 exp(-sigma^2 (1 - cos k)) of them is left, however far the scale reaches.
#[test]
fn a_wave_fades_by_its_eigenvalue_at_every_scale() {
    let [width, height] = SIZE;
    let k = TAU / width as f64;
    let slope = |x: usize| 0.1 * (k * x as f64).cos();
    let frame = endless(width, height, |x, _| {
        let p = slope(x);
        DVec3::new(-p, 0.0, (1.0 - p * p).sqrt())
    });
    for sigma in [2.0_f32, 8.0, 30.0, 300.0, 1000.0] {
        let mut shape = at_scale(sigma);
        shape.tolerance = 1e-6;
        let request = Request::layers(Params::of(shape, given(3.0, 0.8)));
        let gradient = run(&request, &frame).shape.gradient.unwrap();
        let left = (-f64::from(sigma * sigma) * (1.0 - k.cos())).exp();
        for (x, y) in [(0, 0), (7, 27), (20, 13), (39, 1)] {
            let apart = (f64::from(gradient.x.at(x, y)) - left * slope(x)).abs();
            assert!(apart < 2e-6, "sigma {sigma} at {x}, {y}: {apart:e}");
        }
    }
}

/// A region of a tile has the samples of all of it.
#[test]
fn a_region_of_a_tile_is_cut_from_the_whole() {
    let tile = tile([true; 2]);
    let request = Request::layers(Params::of(at_scale(3.0), ScalingParams::default()));
    let whole = run(&request, &tile);
    let region = Window::at(31, 5, 9, 12);
    let part = Engine::cpu().run(&request, &tile, &Run::new().region(region));
    let part = part.unwrap();
    assert_eq!(part.gain, whole.gain);
    are_cut(&part, &whole, region, "");
}

/// The sky is hidden by what lies around a tile, as far as the radius reaches: nine tiles laid out are a tile that sees
/// the same, but for the tolerance of the height, which is 1e-4 of the slopes.
#[test]
fn the_sky_is_that_over_an_endless_surface() {
    let sky = |frame: &Frame| {
        let goal = Goal::Layers {
            and: &[Product::Sky],
            more_px: &[],
        };
        let shape = default_but(|shape: &mut ShapeParams| shape.occlusion_radius = 100.0);
        let request = Request::new(goal, Params::of(shape, given(3.0, 0.8)));
        run(&request, frame).shape.sky.unwrap()
    };
    let waves = |width: usize, height: usize| {
        endless(width, height, |x, y| {
            let [u, v] = [x as f64 / 40.0, y as f64 / 28.0];
            DVec3::new(-0.9 * (TAU * u).cos(), 0.6 * (TAU * v).sin(), 1.0)
        })
    };
    let [width, height] = SIZE;
    let [one, nine] = [1, 3].map(|times| sky(&waves(times * width, times * height)));
    let mut least = 1.0_f32;
    for (x, y) in places(width, height) {
        let (here, there) = (one.at(x, y), nine.at(width + x, height + y));
        assert!((here - there).abs() < 1e-3, "{x}, {y}: {here} {there}");
        least = least.min(there);
    }
    assert!(least < 0.8, "{least}");
}

/// Where a tile is cut changes nothing but where its results begin, automatic choices included.
#[test]
fn a_rolled_tile_gives_rolled_results() {
    let rolled = part(Window::at(13, 9, SIZE[0], SIZE[1]), [true; 2]);
    let auto = ScalingParams::default();
    let [straight, moved] = [tile([true; 2]), rolled];
    for (straight, rolled) in made(&straight, auto).iter().zip(made(&moved, auto)) {
        assert_eq!(straight.gain, rolled.gain);
        assert_eq!(straight.white_level, rolled.white_level);
        for ((product, straight), (_, rolled)) in straight.products().zip(rolled.products()) {
            for (straight, rolled) in straight.iter().zip(rolled) {
                for (x, y) in SPOTS {
                    let there = straight.at((x + 13) % SIZE[0], (y + 9) % SIZE[1]);
                    assert_eq!(rolled.at(x, y), there, "{product:?} at {x}, {y}");
                }
            }
        }
    }
    // An albedo that is estimated is that of the tile.
    let illumination = lamp(135.0, 40.0);
    let params = default_but(|params: &mut Params| params.relight.albedo = AlbedoSource::Estimate);
    let request = Request::relight(params, &illumination);
    let [straight, rolled] = [straight, moved].map(|frame| run(&request, &frame).color.unwrap().r);
    for (x, y) in SPOTS {
        let there = straight.at((x + 13) % SIZE[0], (y + 9) % SIZE[1]);
        // The sums of the fit are added in another order.
        near(rolled.at(x, y) / there, 1.0, 1e-5, format_args!("{x}, {y}"));
    }
}

const SPOTS: [(usize, usize); 5] = [(0, 0), (39, 27), (26, 18), (27, 19), (5, 20)];

/// The tile as an 8-bit normal map, in which steps between codes are removed across borders too.
fn written(folder: &Path, window: Window) -> PathBuf {
    let from = |start: i32, at: u32| i64::from(start) + i64::from(at);
    let path = folder.join(format!("{window}.png").replace(' ', "_"));
    save(&path, [window.width(), window.height()], |x, y| {
        let (n, _) = pavement(from(window.x0, x), from(window.y0, y));
        DVec3::from(n.map(f64::from))
    });
    path
}

/// Opposite borders are compared: waves continue, a part of one does not; a normal map is read without a second mention.
#[test]
fn borders_that_continue_each_other_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let [w, h] = SIZE;
    let cases = [
        (Window::at(0, 0, w, h), [true, true]),
        (Window::at(0, 0, w - 5, h), [false, true]),
        (Window::at(0, 0, w, h - 10), [true, false]),
        (Window::at(0, 0, w - 5, h - 10), [false, false]),
    ];
    for (window, expected) in cases {
        let loaded = load(written(folder.path(), window), |inputs, _| {
            inputs.wrap = Wrap::Auto;
        });
        assert_eq!(loaded.frame.wraps, expected, "{window}");
        assert!(loaded.frame.color.is_none());
        let mut findings = loaded.findings.iter();
        let said = findings.any(|found| found.subject == "borders");
        assert_eq!(said, expected != [false; 2], "{window}");
    }
}

/// Waves of 2.5 pixels, each row at another phase, whose height falls from right to left: beside the right border they change
/// by 2 sin 72 degrees = 1.9 of their height, and across to the calm left one by 1, which is 1.05 of the mean of both sides.
#[test]
fn a_calm_border_does_not_continue_a_busy_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("calm.png");
    save(&path, [96, 64], |x, y| {
        let phase = TAU * (f64::from(x) / 2.5 + 0.618 * f64::from(y));
        DVec3::new(-0.3 * f64::from(x) / 95.0 * phase.sin(), 0.0, 1.0)
    });
    let loaded = load(path, |inputs, _| inputs.wrap = Wrap::Auto);
    assert!(!loaded.frame.wraps[0]);
}

/// Steps between codes are removed on a tile as on its repetition: both are multiples of 16 pixels, at which the removal
/// begins anew.
#[test]
fn rounding_is_undone_across_borders() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, side: usize, wrap: Wrap| {
        let path = folder.path().join(name);
        save(&path, [side; 2], |x, _| {
            let slope = 0.02 * (TAU * f64::from(x % 64) / 64.0).cos();
            DVec3::new(-slope, 0.0, 1.0)
        });
        load(path, |inputs, _| inputs.wrap = wrap).frame.normal
    };
    // Rounding is undone within 269 pixels: five repetitions on each side.
    let tile = read("tile.png", 64, Wrap::Xy);
    let whole = read("whole.png", 64 * 11, Wrap::None);
    let alone = read("alone.png", 64, Wrap::None);
    for i in 0..64 {
        assert_eq!(tile.at(i, 0), whole.at(320 + i, 320), "{i}");
        assert_eq!(tile.at(0, i), whole.at(320, 320 + i), "{i}");
    }
    assert!((0..64).any(|x| alone.at(x, 30) != tile.at(x, 30)));
}

/// Height and sky of a tile in memory, by name: as the waves that it was made of, and repeated by its borders.
#[test]
fn height_is_made_where_it_is_named() {
    let (width, height) = (60, 48);
    // Across a face the height changes by the mean of the slopes beside it, which is of second order: a wave of angular
    // frequencies k and l keeps (k sin k + l sin l) / (4 - 2 cos k - 2 cos l) of its height, here 0.9988.
    let (k, l) = (TAU / 60.0, TAU / 48.0);
    let kept = (k * k.sin() + l * l.sin()) / (4.0 - 2.0 * k.cos() - 2.0 * l.cos());
    let wave = |x: usize, y: usize| 3.0 * (k * x as f64).sin() * (l * y as f64).cos();
    let frame = endless(width, height, |x, y| {
        let [(su, cu), (sv, cv)] = [k * x as f64, l * y as f64].map(f64::sin_cos);
        DVec3::new(-3.0 * k * cu * cv, -3.0 * l * su * sv, 1.0)
    });
    let mut params = Params::default();
    params.shape.height_tolerance = 1e-6;
    let shape = run(&Request::layers(params), &frame).shape;
    assert!(shape.height.is_none() && shape.sky.is_none());
    let goal = Goal::Layers {
        and: &[Product::Height, Product::Sky, Product::BentNormal],
        more_px: &[],
    };
    let shape = run(&Request::new(goal, params), &frame).shape;
    let (found, sky) = (shape.height.unwrap(), shape.sky.unwrap());
    for (x, y) in [(0, 0), (59, 47), (15, 0), (40, 30)] {
        let (found, expected) = (found.at(x, y), (kept * wave(x, y)) as f32);
        near(found, expected, 1e-4, format_args!("{x}, {y}"));
    }
    // A crest sees all of its sky, a trough less.
    let [crest, trough] = [15, 45].map(|x| sky.at(x, 0));
    assert!(crest > 0.999 && trough < 0.99, "{crest} {trough}");
    assert!((shape.bent.unwrap().at(15, 0).length() - 1.0).abs() < 1e-5);
}
