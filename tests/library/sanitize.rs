//! Hostile values: for any input from a file or a caller, no panic, and no NaN or infinity in a result.

use crate::common::exr::Stored;
use crate::prelude::*;

const GOALS: [Goal; 3] = [Goal::LAYERS, Goal::Display, Goal::Enhance];

/// Settings at the ends of their ranges, and usual ones.
fn settings() -> Vec<(&'static str, ShapeParams, ScalingParams)> {
    type Change = (&'static str, fn(&mut ShapeParams, &mut ScalingParams));
    #[rustfmt::skip]
    let all: [Change; 12] = [
        ("usual", |_, _| ()),
        ("no diffusion, scaled by 0", |s, l| (s.scale, l.scaling) = (Scale::Iterations(0), 0.0)),
        ("scaled by 1000 about 0", |s, l| (s.foreshortening, l.scaling, l.invariant_point) = (1.0, 1e3, 0.0)),
        ("scaled by 1000 about 1", |s, l| (s.foreshortening, l.scaling, l.invariant_point) = (4.0, 1e3, 1.0)),
        ("gain 1e30", |s, l| {
            (s.foreshortening, l.curvature_gain) = (4.0, Adaptive::Fixed(1e30));
            (l.scaling, l.invariant_point) = (1e3, 0.5);
        }),
        ("gain 1e-30", |s, l| {
            (s.foreshortening, l.curvature_gain) = (0.4, Adaptive::Fixed(1e-30));
            (l.scaling, l.invariant_point) = (1e3, 0.5);
        }),
        ("white level 1e-30", |s, l| (s.scale, l.white_level) = (Scale::Iterations(0), Adaptive::Fixed(1e-30))),
        ("white level 1e30", |s, l| (s.scale, l.white_level) = (Scale::Iterations(1), Adaptive::Fixed(1e30))),
        ("the least reference", |s, _| s.reference_height = Some(1)),
        ("the greatest reference", |s, _| s.reference_height = Some(u32::MAX)),
        ("everything an edge", |s, _| edges_at(s, 0.0)),
        ("nothing an edge", |s, _| {
            edges_at(s, 1e30);
            (s.time_step, s.scale) = (0.25, Scale::Iterations(40));
        }),
    ];
    let changed = all.map(|(name, change)| {
        let (mut shape, mut scaling) = Default::default();
        change(&mut shape, &mut scaling);
        (name, shape, scaling)
    });
    changed.into()
}

fn edges_at(shape: &mut ShapeParams, at: f32) {
    let step = SoftThreshold { lo: at, hi: at };
    (shape.silhouette, shape.occlusion_silhouette, shape.crease) = (step, step, step);
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
    let extremes = [-3.0, 0.0, 50.0, 65504.0, -65504.0, 1e-38, 0.5, 1.0];
    let plane = |at: &dyn Fn(usize, usize) -> f32| Plane::from_fn(width, height, at);
    Frame {
        mask: Mask::full(width, height),
        normal,
        normal_length: Some(plane(&|x, y| 1.02 * noise(x, y, 5))),
        depth: Some(plane(&|x, y| 10.0_f32.powf(12.0 * noise(x, y, 6) - 6.0))),
        occlusion: Some(plane(&|x, y| noise(x, y, 7))),
        color: Some(colors([width, height], |i, x, y| {
            extremes[(noise(x, y, 8 + i as u32) * 7.99) as usize]
        })),
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

/// Colours far beyond any display, and beyond the range that most settings can scale within a float: the largest scaling, e^60 or
/// 1e26, would overflow for these.
fn enormous() -> Frame {
    let bright = |x: usize, y: usize| [1e30, -1e30, 0.5][(x + y) % 3];
    let color = colors([29, 23], |i, x, y| [1.0, 0.1, 1.0][i] * bright(x, y));
    Frame {
        color: Some(color),
        ..ball(29, 23)
    }
}

#[test]
fn no_setting_makes_a_hostile_frame_give_anything_but_numbers() {
    for (name, frame) in hostile_frames() {
        assert_finite(&frame, name);
    }
    assert_finite(&enormous(), "colours of 1e30");
    let settings = settings();
    let some = [settings[0], settings[3]];
    for (width, height) in [(65535, 3), (3, 65535), (65535, 1)] {
        assert_finite_under(&rough(width, height), &format!("{width}x{height}"), &some);
    }
    // Long diffusion settles.
    let many = default_but(|shape: &mut ShapeParams| shape.scale = Scale::Iterations(20_000));
    let many = [("20000 steps", many, ScalingParams::default())];
    assert_finite_under(&rough(13, 11), "rough", &many);
    assert_finite_under(&ball(13, 11), "ball", &many);
}

#[test]
fn poison_outside_the_mask_changes_no_bit_inside() {
    let (w, h) = (29, 23);
    let scattered = || masked(rough(w, h), |x, y| noise(x, y, 11) > 0.3);
    let balls = ExactScene::two_balls(6.0, 9.0, 14.3, 11.6).in_perspective();
    let axis = glam::DVec3::new(0.6, 0.5, 0.45);
    let cylinder = ExactScene::orthographic(Surface::cylinder(7.0, axis), 14.0, 11.0);
    let frames = [
        ("ball", ball(w, h)),
        ("ball, no depth", without_depth(ball(w, h))),
        ("two balls in perspective", balls.frame(w, h)),
        ("cylinder", cylinder.frame(w, h)),
        ("one pixel", masked(rough(w, h), |x, y| (x, y) == (14, 11))),
        ("checkerboard", masked(rough(w, h), |x, y| (x + y) % 2 == 0)),
        ("scattered", scattered()),
        ("scattered, no depth", without_depth(scattered())),
    ];
    for (name, frame) in frames {
        let inside = frame.mask.plane().samples();
        assert!(inside.contains(&true) && inside.contains(&false), "{name}");
        let spoilt = [f32::NAN, f32::INFINITY, -1e30].map(|poison| spoilt(&frame, poison));
        for (setting, shape, scaling) in settings() {
            for goal in GOALS {
                let run = |frame| inside_of(&plan(goal, frame, shape, scaling), frame);
                let clean = run(&frame);
                for (i, spoilt) in spoilt.iter().enumerate() {
                    assert!(run(spoilt) == clean, "{name}, {setting}, {goal:?}, {i}");
                }
            }
        }
    }
}

/// The bits that a run chooses, and those of all planes where there is a surface.
fn inside_of(plan: &Plan, frame: &Frame) -> Vec<(&'static str, Vec<u32>)> {
    let outcome = cpu::run(plan, frame).unwrap();
    let chosen = [outcome.gain, outcome.white_level].into_iter().flatten();
    let chosen = ("chosen", chosen.map(f32::to_bits).collect());
    let planes = planes(&outcome).into_iter().map(|(name, plane)| {
        let inside = covered(&frame.mask).map(|(x, y)| plane.at(x, y).to_bits());
        (name, inside.collect())
    });
    std::iter::once(chosen).chain(planes).collect()
}

/// The frame with every plane poisoned outside the mask, the picture and its coverage too.
fn spoilt(frame: &Frame, poison: f32) -> Frame {
    let spoil = |plane: &Plane| {
        Plane::from_fn(plane.width(), plane.height(), |x, y| {
            match frame.mask.at(x, y) {
                true => plane.at(x, y),
                false => poison,
            }
        })
    };
    let spoilt = |c: &ColorPlanes| {
        let [r, g, b] = channels(c).map(spoil);
        ColorPlanes { r, g, b }
    };
    Frame {
        color: frame.color.as_ref().map(spoilt),
        alpha: frame.alpha.as_ref().map(spoil),
        // An occlusion map has no mask of its own: its values beside the surface belong to the border.
        ..poisoned(frame, poison)
    }
}

// Through files.

/// A gentle relief that fills the picture, of which a test spoils some samples.
fn relief(width: usize, height: usize) -> Frame {
    let normal = normals(width, height, |x, y| {
        Vec3::new(0.3 * (x as f32).sin(), 0.2 * (y as f32).cos(), 1.0).normalize()
    });
    let color = |i: usize, x: usize, y: usize| 0.1 * (i + 1) as f32 + 0.01 * [x, y, 0][i] as f32;
    let depth = |x, y| 5.0 + 0.01 * (x + y) as f32;
    Frame {
        depth: Some(Plane::from_fn(width, height, depth)),
        color: Some(colors([width, height], color)),
        alpha: Some(Plane::filled(width, height, 1.0)),
        ..Frame::of_normals(normal, Mask::full(width, height))
    }
}

/// The frame from a file with samples of `stored`.
fn read(frame: &Frame, stored: Stored) -> Loaded {
    let (n, color) = (&frame.normal, frame.color.as_ref().unwrap());
    let mut layers = vec![("R", &color.r), ("G", &color.g), ("B", &color.b)];
    layers.extend([("N.x", &n.x), ("N.y", &n.y), ("N.z", &n.z)]);
    layers.extend(frame.alpha.iter().map(|plane| ("A", plane)));
    layers.extend(frame.depth.iter().map(|plane| ("Z", plane)));
    through_a_file(&layers, stored)
}

/// Expects a frame without NaN, infinity or sentinel, and results to match.
fn assert_clean(frame: &Frame, name: &str) {
    let (normal, color) = (&frame.normal, frame.color.as_ref().unwrap());
    let planes = [
        &normal.x, &normal.y, &normal.z, &color.r, &color.g, &color.b,
    ];
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

const NAN: f32 = f32::NAN;
const INF: f32 = f32::INFINITY;

#[rustfmt::skip]
const NO_NORMALS: [[f32; 3]; 10] = [
    [NAN, 0.0, 1.0], [0.0, NAN, 1.0], [0.0, 0.0, NAN], [NAN; 3], [INF, 0.0, 0.0], [0.0, -INF, 1.0], [0.0, 0.0, INF],
    [0.0; 3], [0.0, -0.0, 1e-30], [3e38; 3],
];
#[rustfmt::skip]
const NORMALS: [[f32; 3]; 7] = [
    [1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.6, 0.0, -0.8], [0.0, 0.0, -1.0], [0.588, 0.0, 0.784], [0.0, 0.612, 0.816],
    [0.0, 0.0, 0.2],
];

#[test]
fn normals_without_direction_and_colours_that_are_no_numbers_are_replaced() {
    let (none, some) = (NO_NORMALS.map(|n| (n, false)), NORMALS.map(|n| (n, true)));
    let cases = [&none[..], &some].concat();
    let (width, height) = (2 * cases.len() + 1, 7);
    for (with_depth, stored) in [
        (true, Stored::Float),
        (true, Stored::Half),
        (false, Stored::Float),
        (false, Stored::Half),
    ] {
        let mut frame = relief(width, height);
        frame.depth = frame.depth.filter(|_| with_depth);
        for (i, (n, _)) in cases.iter().enumerate() {
            set_normal(&mut frame.normal, 2 * i + 1, 3, Vec3::from(*n));
        }
        let hostile = [NAN, INF, -INF, -3.0, 50.0, 60000.0, 1e-7, -0.0];
        let color = frame.color.as_mut().unwrap();
        color.r.row_mut(5)[..8].copy_from_slice(&hostile);
        color.g.row_mut(5)[1..9].copy_from_slice(&hostile);
        let alpha = frame.alpha.as_mut().unwrap();
        alpha.row_mut(5)[..3].copy_from_slice(&[NAN, INF, -1.0]);
        let Loaded {
            frame, warnings, ..
        } = read(&frame, stored);
        for (i, (n, covered)) in cases.iter().enumerate() {
            // Half floats cannot hold 3e38: it becomes 65504 and so a normal of some direction.
            if stored == Stored::Float || *n != [3e38; 3] {
                assert_eq!(frame.mask.at(2 * i + 1, 3), *covered, "{n:?}");
            }
            assert!(frame.mask.at(2 * i, 3), "the neighbour of {n:?}");
        }
        // Two pixels of no coverage.
        assert!(frame.mask.count() >= width * height - cases.len() - 2);
        let is_told = warnings.iter().any(|text| text.starts_with("8 colour"));
        assert!(is_told, "{warnings:?}");
        let red = &frame.color.as_ref().unwrap().r;
        assert_eq!(red.row(5)[..5], [0.0, 65504.0, -65504.0, -3.0, 50.0]);
        assert_clean(&frame, &format!("{stored:?}, depth {with_depth}"));
    }
}

#[test]
fn depth_that_is_no_distance_is_left_out_and_no_other() {
    let none = [NAN, INF, -INF, 1e10, 1e30, f32::MAX, 65504.0, 0.0];
    let none = [&none[..], &[-0.0, -5.0]].concat();
    let none: Vec<_> = none.into_iter().map(|z| (z, false)).collect();
    let some = [1e-6, 1e-3, 1.0, 1e3, 1e6].map(|z| (z, true));
    let cases = [&none[..], &some].concat();
    // Three columns wide: single samples that are missing are filled.
    let mut relief = relief(4 * cases.len() + 1, 7);
    let depth = relief.depth.as_mut().unwrap();
    for (i, (value, _)) in cases.iter().enumerate() {
        (0..7).for_each(|y| depth.row_mut(y)[4 * i + 1..][..3].fill(*value));
    }
    let frame = read(&relief, Stored::Float).frame;
    for (i, (value, covered)) in cases.iter().enumerate() {
        let row = [0, 1, 2, 3].map(|x| frame.mask.at(4 * i + x, 3));
        assert_eq!(row, [true, *covered, *covered, *covered], "{value}");
    }
    assert_clean(&frame, "depths in one frame");
    for (value, covered) in cases {
        let everywhere = depth_of(self::relief(9, 7), |_, _| value);
        let loaded = read(&everywhere, Stored::Float);
        let expected = if covered { 9 * 7 } else { 0 };
        assert_eq!(loaded.frame.mask.count(), expected, "{value}");
        let warned = loaded.warnings.iter().any(|w| w.contains("no pixel shows"));
        assert_eq!(warned, !covered, "{value}: {:?}", loaded.warnings);
        assert_clean(&loaded.frame, &format!("depth {value} everywhere"));
    }
}

#[test]
fn files_of_any_size_pass() {
    for (width, height) in [(1, 1), (1, 33), (33, 1), (2, 2), (3, 65535), (65535, 3)] {
        let loaded = read(&relief(width, height), Stored::Float);
        let name = format!("{width}x{height}");
        assert_eq!(loaded.frame.mask.count(), width * height, "{name}");
        match width.max(height) < 1000 {
            true => assert_clean(&loaded.frame, &name),
            false => assert_finite_under(&loaded.frame, &name, &[settings()[0]]),
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
