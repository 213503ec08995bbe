//! Hostile values: for any input from a file or a caller, no panic, and no NaN or infinity in a result.

use crate::common::cpu;
use crate::common::exr::Stored;
use crate::common::planes::planes;
use crate::common::{default_but, places, poisoned, through_a_file, without_depth};
use glam::Vec3;
use relievo::frame::{ColorPlanes, Frame, Mask, Plane, Vector3Planes};
use relievo::io::Loaded;
use relievo::params::{Adaptive, Scale, ScalingParams, ShapeParams, SoftThreshold};
use relievo::plan::{Available, Goal, Plan};
use relievo::scenes::frames::{masked, noise, normals};
use relievo::scenes::{ExactScene, Surface};

const GOALS: [Goal; 3] = [Goal::LAYERS, Goal::Display, Goal::Enhance];

/// Settings at the ends of their ranges, and usual ones.
fn settings() -> Vec<(&'static str, ShapeParams, ScalingParams)> {
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let step = |at| SoftThreshold { lo: at, hi: at };
    let shaped = |change: &dyn Fn(&mut ShapeParams)| default_but(|shape| change(shape));
    let scaled = |change: &dyn Fn(&mut ScalingParams)| default_but(|scaling| change(scaling));
    let iterations = |n| shaped(&|shape| shape.scale = Scale::Iterations(n));
    let foreshortening = |power| shaped(&|shape| shape.foreshortening = power);
    let referring = |height| shaped(&|shape| shape.reference_height = Some(height));
    let magnitude = |magnitude, invariant_point| ScalingParams {
        scaling: magnitude,
        invariant_point,
        ..scaling
    };
    let gain = |gain| ScalingParams {
        curvature_gain: Adaptive::Fixed(gain),
        ..magnitude(1e3, 0.5)
    };
    let white = |level| scaled(&|scaling| scaling.white_level = Adaptive::Fixed(level));
    let everything_an_edge = ShapeParams {
        silhouette: step(0.0),
        occlusion_silhouette: step(0.0),
        crease: step(0.0),
        ..shape
    };
    let nothing_an_edge = ShapeParams {
        silhouette: step(1e30),
        occlusion_silhouette: step(1e30),
        crease: step(1e30),
        time_step: 0.25,
        ..iterations(40)
    };
    #[rustfmt::skip]
    let all = vec![
        ("usual", shape, scaling),
        ("no diffusion, scaled by 0", iterations(0), magnitude(0.0, 0.25)),
        ("scaled by 1000 about 0", foreshortening(1.0), magnitude(1e3, 0.0)),
        ("scaled by 1000 about 1", foreshortening(4.0), magnitude(1e3, 1.0)),
        ("gain 1e30", foreshortening(4.0), gain(1e30)),
        ("gain 1e-30", foreshortening(0.4), gain(1e-30)),
        ("white level 1e-30", iterations(0), white(1e-30)),
        ("white level 1e30", iterations(1), white(1e30)),
        ("the least reference", referring(1), scaling),
        ("the greatest reference", referring(u32::MAX), scaling),
        ("everything an edge", everything_an_edge, scaling),
        ("nothing an edge", nothing_an_edge, scaling),
    ];
    all
}

fn plan(goal: Goal, frame: &Frame, shape: ShapeParams, scaling: ScalingParams) -> Plan {
    Plan::new(goal, Available::in_frame(frame), shape, scaling).unwrap()
}

/// Least number of planes for a goal: an outcome without planes has no NaN either.
fn least_planes(goal: Goal, scaling: &ScalingParams) -> usize {
    match goal {
        Goal::LAYERS => 16,
        Goal::Display => 3,
        Goal::Enhance if scaling.scaling == 0.0 => 0,
        _ => 3,
    }
}

/// Runs every goal and setting, and expects finite planes of the frame's size.
fn assert_finite_under(frame: &Frame, name: &str, settings: &[(&str, ShapeParams, ScalingParams)]) {
    for (setting, shape, scaling) in settings {
        for goal in GOALS {
            let case = format!("{name}, {setting}, {goal:?}");
            let outcome = cpu::run(&plan(goal, frame, *shape, *scaling), frame).unwrap();
            let planes = planes(&outcome);
            assert!(planes.len() >= least_planes(goal, scaling), "{case}");
            for (quantity, plane) in planes {
                let size = (plane.width(), plane.height());
                assert_eq!(size, (frame.mask.width(), frame.mask.height()), "{case}");
                let wrong = plane.samples().iter().position(|v| !v.is_finite());
                assert_eq!(wrong, None, "{case}: {quantity}");
            }
            let chosen = [outcome.gain, outcome.white_level];
            assert!(chosen.iter().flatten().all(|v| v.is_finite()), "{case}");
        }
    }
}

fn assert_finite(frame: &Frame, name: &str) {
    assert_finite_under(frame, name, &settings());
}

fn ball(width: usize, height: usize) -> Frame {
    let radius = 0.4 * width.max(height) as f64;
    let (cx, cy) = (0.5 * width as f64 + 0.3, 0.5 * height as f64 - 0.2);
    ExactScene::orthographic(Surface::ball(radius), cx, cy).frame(width, height)
}

/// Everything covered, everything rough: normals all ways and none at all, depth over twelve orders of
/// magnitude, colours far out of range.
fn rough(width: usize, height: usize) -> Frame {
    let normal = normals(width, height, |x, y| {
        let n = Vec3::from_array([1, 2, 3].map(|c| 2.0 * noise(x, y, c) - 1.0));
        let length = 0.98 + 0.04 * noise(x, y, 4);
        match (x + 3 * y) % 8 {
            0 => Vec3::new(n.x, n.y, 0.0).normalize_or_zero() * length,
            1 => Vec3::ZERO,
            2 => Vec3::NEG_Z,
            3 => Vec3::Z,
            4 => Vec3::new(1.0, 0.0, 1e-30),
            _ => n.normalize_or_zero() * length,
        }
    });
    let colors = [-3.0, 0.0, 50.0, 65504.0, -65504.0, 1e-38, 0.5, 1.0];
    let plane = |at: &dyn Fn(usize, usize) -> f32| Plane::from_fn(width, height, at);
    let color = |c| plane(&|x, y| colors[(noise(x, y, c) * 7.99) as usize]);
    Frame {
        mask: Mask::full(width, height),
        normal,
        normal_length: Some(plane(&|x, y| 1.02 * noise(x, y, 5))),
        depth: Some(plane(&|x, y| 10.0_f32.powf(12.0 * noise(x, y, 6) - 6.0))),
        occlusion: Some(plane(&|x, y| noise(x, y, 7))),
        color: Some(ColorPlanes {
            r: color(8),
            g: color(9),
            b: color(10),
        }),
        camera: None,
        ..ball(width, height)
    }
}

fn depth_of(frame: Frame, depth: impl FnMut(usize, usize) -> f32) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    Frame {
        depth: Some(Plane::from_fn(width, height, depth)),
        ..frame
    }
}

fn hostile_frames() -> Vec<(&'static str, Frame)> {
    let (w, h) = (29, 23);
    let perspective = ExactScene::orthographic(Surface::ball(10.0), 14.3, 11.2).in_perspective();
    let part = |mask: fn(usize, usize) -> bool| masked(rough(w, h), mask);
    let bare = Frame {
        occlusion: None,
        importance: None,
        normal_length: None,
        ..without_depth(rough(w, h))
    };
    let wide = depth_of(ball(w, h), |x, _| if x % 2 == 0 { 1e-6 } else { 1e6 });
    vec![
        ("ball", ball(w, h)),
        ("ball in perspective", perspective.frame(w, h)),
        ("rough", rough(w, h)),
        ("rough, no depth", without_depth(rough(w, h))),
        ("rough, neither depth nor occlusion", bare),
        ("no surface", part(|_, _| false)),
        ("one pixel", part(|x, y| (x, y) == (14, 11))),
        ("one corner pixel", part(|x, y| x + y == 0)),
        ("checkerboard", part(|x, y| (x + y) % 2 == 0)),
        ("one row", part(|_, y| y == 5)),
        ("scattered", part(|x, y| noise(x, y, 11) > 0.3)),
        ("constant depth", depth_of(ball(w, h), |_, _| 7.0)),
        ("tiny depth", depth_of(rough(w, h), |_, _| 1e-6)),
        ("depth from 1e-6 to 1e6", wide),
        ("1x1", rough(1, 1)),
        ("1x1, no surface", masked(rough(1, 1), |_, _| false)),
        ("2x2", rough(2, 2)),
        ("1xN", rough(1, 37)),
        ("Nx1", rough(37, 1)),
    ]
}

#[test]
fn no_setting_makes_a_hostile_frame_give_anything_but_numbers() {
    for (name, frame) in hostile_frames() {
        assert_finite(&frame, name);
    }
}

#[test]
fn very_wide_and_very_tall_frames_pass() {
    let settings = settings();
    let some = [settings[0], settings[3]];
    assert_finite_under(&rough(65535, 3), "65535x3", &some);
    assert_finite_under(&rough(3, 65535), "3x65535", &some);
    assert_finite_under(&rough(65535, 1), "65535x1", &some);
}

#[test]
fn long_diffusion_settles() {
    let many = default_but(|shape: &mut ShapeParams| shape.scale = Scale::Iterations(20_000));
    let settings = [("20000 steps", many, ScalingParams::default())];
    assert_finite_under(&rough(13, 11), "rough", &settings);
    assert_finite_under(&ball(13, 11), "ball", &settings);
}

/// Colours far beyond any display, and beyond the range that most settings can scale within a float.
#[test]
fn enormous_colours_stay_finite() {
    let lit = |peak: f32| {
        let bright = Plane::from_fn(29, 23, |x, y| match (x + y) % 3 {
            0 => peak,
            1 => -peak,
            _ => 0.5,
        });
        Frame {
            color: Some(ColorPlanes {
                r: bright.clone(),
                g: bright.map(|v| 0.1 * v),
                b: bright,
            }),
            ..ball(29, 23)
        }
    };
    // The largest scaling, e^60 or 1e26, would overflow for these.
    assert_finite(&lit(1e30), "colours of 1e30");
}

#[test]
fn poison_outside_the_mask_changes_no_bit_inside() {
    let (w, h) = (29, 23);
    let scattered = || masked(rough(w, h), |x, y| noise(x, y, 11) > 0.3);
    let frames = [
        ("ball", ball(w, h)),
        ("ball, no depth", without_depth(ball(w, h))),
        ("one pixel", masked(rough(w, h), |x, y| (x, y) == (14, 11))),
        ("checkerboard", masked(rough(w, h), |x, y| (x + y) % 2 == 0)),
        ("scattered", scattered()),
        ("scattered, no depth", without_depth(scattered())),
    ];
    for (name, frame) in frames {
        let inside = frame.mask.plane().samples().to_vec();
        assert!(inside.contains(&true) && inside.contains(&false), "{name}");
        for poison in [f32::NAN, f32::INFINITY, -1e30] {
            let spoilt = spoilt(&frame, poison);
            for (setting, shape, scaling) in settings() {
                for goal in GOALS {
                    let case = format!("{name}, {setting}, {goal:?}, {poison}");
                    let clean = cpu::run(&plan(goal, &frame, shape, scaling), &frame).unwrap();
                    let other = cpu::run(&plan(goal, &spoilt, shape, scaling), &spoilt).unwrap();
                    let bits = |v: Option<f32>| v.map(f32::to_bits);
                    assert_eq!(bits(clean.gain), bits(other.gain), "{case}");
                    assert_eq!(bits(clean.white_level), bits(other.white_level), "{case}");
                    let (clean, other) = (planes(&clean), planes(&other));
                    assert_eq!(clean.len(), other.len(), "{case}");
                    for ((quantity, a), (_, b)) in clean.into_iter().zip(other) {
                        let samples = a.samples().iter().zip(b.samples()).zip(&inside);
                        let differ = |((a, b), inside): ((&f32, &f32), &bool)| {
                            *inside && a.to_bits() != b.to_bits()
                        };
                        assert_eq!(
                            samples.filter(|s| differ(*s)).count(),
                            0,
                            "{case}: {quantity}"
                        );
                    }
                }
            }
        }
    }
}

/// The frame with every plane poisoned outside the mask, the picture and its coverage too.
fn spoilt(frame: &Frame, poison: f32) -> Frame {
    let spoil = |plane: &Plane| {
        let at = |x, y| {
            if frame.mask.at(x, y) {
                plane.at(x, y)
            } else {
                poison
            }
        };
        Plane::from_fn(plane.width(), plane.height(), at)
    };
    let colors = |c: &ColorPlanes| {
        let [r, g, b] = [&c.r, &c.g, &c.b].map(spoil);
        ColorPlanes { r, g, b }
    };
    Frame {
        color: frame.color.as_ref().map(colors),
        alpha: frame.alpha.as_ref().map(spoil),
        // An occlusion map has no mask of its own: its values beside the surface belong to the border.
        ..poisoned(frame, poison)
    }
}

// Through files.

/// The layers of a small render, to be spoilt and written.
#[derive(Clone)]
struct Render {
    normal: Vector3Planes,
    depth: Option<Plane>,
    color: ColorPlanes,
    alpha: Option<Plane>,
}

impl Render {
    /// A gentle relief that fills the picture.
    fn new(width: usize, height: usize) -> Self {
        let normal = normals(width, height, |x, y| {
            Vec3::new(0.3 * (x as f32).sin(), 0.2 * (y as f32).cos(), 1.0).normalize()
        });
        let plane = |f: fn(usize, usize) -> f32| Plane::from_fn(width, height, f);
        Self {
            normal,
            depth: Some(plane(|x, y| 5.0 + 0.01 * (x + y) as f32)),
            color: ColorPlanes {
                r: plane(|x, _| 0.1 + 0.01 * x as f32),
                g: plane(|_, y| 0.2 + 0.01 * y as f32),
                b: plane(|_, _| 0.3),
            },
            alpha: Some(plane(|_, _| 1.0)),
        }
    }

    /// Writes it with samples of `stored`, and loads it.
    fn through_a_file(&self, stored: Stored) -> Loaded {
        let (normal, color) = (&self.normal, &self.color);
        let layers = [
            ("R", Some(&color.r)),
            ("G", Some(&color.g)),
            ("B", Some(&color.b)),
            ("A", self.alpha.as_ref()),
            ("N.x", Some(&normal.x)),
            ("N.y", Some(&normal.y)),
            ("N.z", Some(&normal.z)),
            ("Z", self.depth.as_ref()),
        ];
        let there = layers.into_iter();
        let there = there.filter_map(|(name, plane)| Some((name, plane?)));
        let there: Vec<_> = there.collect();
        through_a_file(&there, stored)
    }
}

/// Expects a frame without NaN, infinity or sentinel, and results to match.
fn assert_clean(frame: &Frame, name: &str) {
    let (normal, color) = (&frame.normal, frame.color.as_ref().unwrap());
    #[rustfmt::skip]
    let planes = [&normal.x, &normal.y, &normal.z, &color.r, &color.g, &color.b];
    let others = [
        &frame.normal_length,
        &frame.depth,
        &frame.occlusion,
        &frame.alpha,
    ];
    for plane in planes.into_iter().chain(others.into_iter().flatten()) {
        assert!(plane.samples().iter().all(|v| v.is_finite()), "{name}");
    }
    for (x, y) in places(frame.mask.width(), frame.mask.height()) {
        let n = normal.at(x, y);
        if frame.mask.at(x, y) {
            assert!((n.length() - 1.0).abs() < 1e-5, "{name}: {n} at {x}, {y}");
            let depth = frame.depth.as_ref().map(|d| d.at(x, y));
            assert!(depth.is_none_or(|d| d > 0.0), "{name}");
        } else {
            assert_eq!(n.length(), 0.0, "{name}: outside at {x}, {y}");
        }
    }
    assert_finite(frame, name);
}

#[test]
fn normals_without_direction_are_left_out_and_no_others() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let cases = [
        (Vec3::new(nan, 0.0, 1.0), false),
        (Vec3::new(0.0, nan, 1.0), false),
        (Vec3::new(0.0, 0.0, nan), false),
        (Vec3::splat(nan), false),
        (Vec3::new(inf, 0.0, 0.0), false),
        (Vec3::new(0.0, -inf, 1.0), false),
        (Vec3::new(0.0, 0.0, inf), false),
        (Vec3::ZERO, false),
        (Vec3::new(0.0, -0.0, 1e-30), false),
        (Vec3::splat(3e38), false),
        (Vec3::new(1.0, 0.0, 0.0), true),
        (Vec3::new(0.6, 0.8, 0.0), true),
        (Vec3::new(0.6, 0.0, -0.8), true),
        (Vec3::NEG_Z, true),
        (0.98 * Vec3::new(0.6, 0.0, 0.8), true),
        (1.02 * Vec3::new(0.0, 0.6, 0.8), true),
        (0.2 * Vec3::Z, true),
    ];
    for with_depth in [true, false] {
        for stored in [Stored::Float, Stored::Half] {
            let (width, height) = (2 * cases.len() + 1, 7);
            let mut render = Render::new(width, height);
            render.depth = render.depth.filter(|_| with_depth);
            for (i, (n, _)) in cases.iter().enumerate() {
                render.normal.x.row_mut(3)[2 * i + 1] = n.x;
                render.normal.y.row_mut(3)[2 * i + 1] = n.y;
                render.normal.z.row_mut(3)[2 * i + 1] = n.z;
            }
            let frame = render.through_a_file(stored).frame;
            for (i, (n, covered)) in cases.iter().enumerate() {
                // Half floats cannot hold 3e38: it becomes 65504 and so a normal of some direction.
                if stored == Stored::Float || n.max_element() < 1e5 || !n.is_finite() {
                    assert_eq!(frame.mask.at(2 * i + 1, 3), *covered, "{n}");
                }
                assert!(frame.mask.at(2 * i, 3), "the neighbour of {n}");
            }
            assert!(frame.mask.count() >= width * height - cases.len());
            assert_clean(&frame, &format!("normals, {stored:?}"));
        }
    }
}

#[test]
fn depth_that_is_no_distance_is_left_out_and_no_other() {
    let cases = [
        (f32::NAN, false),
        (f32::INFINITY, false),
        (f32::NEG_INFINITY, false),
        (1e10, false),
        (1e30, false),
        (f32::MAX, false),
        (65504.0, false),
        (0.0, false),
        (-0.0, false),
        (-5.0, false),
        (1e-6, true),
        (1e-3, true),
        (1.0, true),
        (1e3, true),
        (1e6, true),
    ];
    // Three columns wide: single samples that are missing are filled.
    let mut render = Render::new(4 * cases.len() + 1, 7);
    let depth = render.depth.as_mut().unwrap();
    for (i, (value, _)) in cases.iter().enumerate() {
        (0..7).for_each(|y| depth.row_mut(y)[4 * i + 1..][..3].fill(*value));
    }
    let frame = render.through_a_file(Stored::Float).frame;
    for (i, (value, covered)) in cases.iter().enumerate() {
        for x in 1..4 {
            assert_eq!(frame.mask.at(4 * i + x, 3), *covered, "{value}");
        }
        assert!(frame.mask.at(4 * i, 3), "the neighbour of {value}");
    }
    assert_clean(&frame, "depths in one frame");

    for (value, covered) in cases {
        let mut render = Render::new(9, 7);
        render.depth = Some(Plane::filled(9, 7, value));
        let loaded = render.through_a_file(Stored::Float);
        let expected = if covered { 9 * 7 } else { 0 };
        assert_eq!(loaded.frame.mask.count(), expected, "{value}");
        let warned = loaded.warnings.iter().any(|w| w.contains("no pixel shows"));
        assert_eq!(warned, !covered, "{value}: {:?}", loaded.warnings);
        assert_clean(&loaded.frame, &format!("depth {value} everywhere"));
    }
}

#[test]
fn colours_that_are_no_numbers_are_told_and_replaced() {
    for stored in [Stored::Float, Stored::Half] {
        let mut render = Render::new(11, 9);
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let hostile = [nan, inf, -inf, -3.0, 50.0, 60000.0, 1e-7, -0.0];
        render.color.r.row_mut(4)[..8].copy_from_slice(&hostile);
        render.color.g.row_mut(4)[1..9].copy_from_slice(&hostile);
        render.alpha.as_mut().unwrap().row_mut(4)[..3].copy_from_slice(&[nan, inf, -1.0]);
        let loaded = render.through_a_file(stored);
        let is_told = loaded.warnings.iter().any(|w| w.starts_with("8 colour"));
        assert!(is_told, "{:?}", loaded.warnings);
        let red = &loaded.frame.color.as_ref().unwrap().r;
        assert_eq!(red.row(4)[..5], [0.0, 65504.0, -65504.0, -3.0, 50.0]);
        assert_clean(&loaded.frame, &format!("colours, {stored:?}"));
    }
}

#[test]
fn files_of_any_size_pass() {
    for (width, height) in [(1, 1), (1, 33), (33, 1), (2, 2), (3, 65535), (65535, 3)] {
        let loaded = Render::new(width, height).through_a_file(Stored::Float);
        let name = format!("{width}x{height}");
        assert_eq!(loaded.frame.mask.count(), width * height, "{name}");
        if width.max(height) < 1000 {
            assert_clean(&loaded.frame, &name);
        } else {
            assert_finite_under(&loaded.frame, &name, &[settings()[0]]);
        }
    }
}

/// Noise evenly within .1 / 2 of each component: a deviation of .1 / sqrt(12) = .029 of the slopes.
#[test]
fn noise_of_normals_is_told() {
    let [x, y] = [0, 1].map(|i| Plane::from_fn(192, 192, |x, y| 0.1 * (noise(x, y, i) - 0.5)));
    for (share, is_told) in [(1.0, true), (0.0, false)] {
        let [x, y] = [&x, &y].map(|plane| plane.map(|value| share * value));
        let [z, grey] = [0.99, 0.5].map(|value| Plane::filled(192, 192, value));
        let normal = [("N.x", &x), ("N.y", &y), ("N.z", &z)];
        let layers = [normal, [("R", &grey), ("G", &grey), ("B", &grey)]].concat();
        let warnings = through_a_file(&layers, Stored::Float).warnings;
        let told = warnings.iter().any(|text| text.contains("noise of 0.0"));
        assert_eq!(told, is_told, "{warnings:?}");
    }
}
