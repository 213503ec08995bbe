//! Lines of forms whose lines are known.

use crate::frame::memory::Memory;
use crate::frame::{ColorPlanes, Frame, Mask, Plane, Vector3Planes};
use crate::line::contours::{Contour, ContourKind};
use crate::line::drawing::Drawn;
use crate::line::interior::cpu::interior;
use crate::params::{InteriorParams, LineLevels, RunOptions};
use glam::{DVec3, Vec2};
use std::f64::consts::TAU;

const WIDTH: usize = 320;
const HEIGHT: usize = 240;

/// The lines of these normals: a surface where they are not 0, with its border as silhouette.
fn lines_of(width: usize, height: usize, normal: impl Fn(f64, f64) -> DVec3) -> Vec<Contour> {
    let at = |x: usize, y: usize| normal(x as f64 + 0.5, y as f64 + 0.5).normalize_or_zero();
    lines(&Vector3Planes::from_fn(width, height, at))
}

fn lines(normals: &Vector3Planes) -> Vec<Contour> {
    lines_of_frame(&frame_of(normals), &InteriorParams::default())
}

fn frame_of(normals: &Vector3Planes) -> Frame {
    let (width, height) = (normals.x.width(), normals.x.height());
    let covered = Plane::from_fn(width, height, |x, y| normals.at(x, y) != DVec3::ZERO);
    Frame::of_normals(normals.clone(), Mask::new(covered))
}

fn drawn<'a>(frame: &'a Frame, silhouette: &'a Plane) -> Drawn<'a> {
    Drawn {
        frame,
        silhouette: Some(silhouette),
        crease: None,
        conductance: None,
    }
}

fn lines_of_frame(frame: &Frame, params: &InteriorParams) -> Vec<Contour> {
    let silhouette = Plane::filled(frame.mask.width(), frame.mask.height(), 0.0);
    interior(
        &drawn(frame, &silhouette),
        (&[], None),
        params,
        false,
        &RunOptions::default(),
        &Memory::default(),
    )
    .0
}

#[test]
fn in_a_sequence_a_groove_that_deepens_comes_little_by_little() {
    // Every groove is 1.04 times as steep as the one before, and its strength and worth grow by as much at the most. From
    // 1 to 1.5 times the threshold the share of the width by strength then rises by up to 0.06/0.5 of a smooth step whose
    // slope is 1.5 at the most: by 0.18; that by worth, from 1 to 2 times, by 0.08 * 1.5 = 0.12. Both together: less than
    // 0.3. A single picture draws all of it at once, as widths are fit to the upper threshold itself.
    let params = InteriorParams {
        levels: LineLevels::Given([22.0, 0.0, 0.0]),
        light_emphasis: 0.0,
        ..InteriorParams::default()
    };
    let ink = |slope: f64, fades: bool| {
        let normals = Vector3Planes::from_fn(WIDTH, HEIGHT, |_, y| {
            let slope = slope * (y as f64 + 0.5 - 120.3).signum();
            DVec3::new(0.0, slope, 1.0).normalize()
        });
        let frame = Frame::of_normals(normals, Mask::new(Plane::filled(WIDTH, HEIGHT, true)));
        let silhouette = Plane::filled(WIDTH, HEIGHT, 0.0);
        let options = RunOptions::default();
        let (lines, _) = interior(
            &drawn(&frame, &silhouette),
            (&[], None),
            &params,
            fades,
            &options,
            &Memory::default(),
        );
        lines.iter().flat_map(|line| &line.widths).sum::<f32>()
    };
    let largest_step = |fades: bool| {
        let inks: Vec<f32> = (0..70)
            .map(|k| ink(0.05 * 1.04_f64.powi(k), fades))
            .collect();
        let steps = inks.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        steps.fold(0.0, f32::max) / inks[69]
    };
    let [single, sequence] = [false, true].map(largest_step);
    assert!(single > 0.9, "{single}");
    assert!(sequence < 0.3, "{sequence}");
}

/// Three degrees of noise and 8 bits.
fn noisy(normals: &Vector3Planes) -> Vector3Planes {
    let mut state = 1_u64;
    let mut noise = || {
        // The sum of four even numbers, with a variance of a third: as good as normal here.
        let even = |state: &mut u64| {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*state >> 40) as f64 / f64::from(1 << 24) - 0.5
        };
        let sum: f64 = (0..4).map(|_| even(&mut state)).sum();
        3.0_f64.to_radians() * 3.0_f64.sqrt() * sum
    };
    Vector3Planes::from_fn(normals.x.width(), normals.x.height(), |x, y| {
        let normal = normals.at(x, y);
        let moved = (normal + DVec3::new(noise(), noise(), noise())).normalize();
        let stored = ((0.5 * moved + 0.5) * 255.0).round() / 255.0;
        if normal == DVec3::ZERO {
            normal
        } else {
            (2.0 * stored - 1.0).normalize()
        }
    })
}

/// An ellipsoid of these half axes, in pixels, in the middle of the picture.
fn ellipsoid(axes: DVec3) -> Vector3Planes {
    Vector3Planes::from_fn(WIDTH, HEIGHT, |x, y| {
        let (x, y) = (x as f64 + 0.5 - 160.0, 120.0 - (y as f64 + 0.5));
        let left = 1.0 - (x / axes.x).powi(2) - (y / axes.y).powi(2);
        let normal = DVec3::new(
            x / axes.x.powi(2),
            y / axes.y.powi(2),
            left.max(0.0).sqrt() / axes.z,
        );
        if left > 0.0 {
            normal.normalize()
        } else {
            DVec3::ZERO
        }
    })
}

#[test]
fn smooth_forms_have_no_lines() {
    let plane =
        Vector3Planes::from_fn(WIDTH, HEIGHT, |_, _| DVec3::new(-0.3, 0.2, 0.9).normalize());
    let cylinder = Vector3Planes::from_fn(WIDTH, HEIGHT, |x, _| {
        let x = (x as f64 + 0.5 - 160.0) / 100.0;
        if x.abs() < 1.0 {
            DVec3::new(x, 0.0, (1.0 - x * x).sqrt())
        } else {
            DVec3::ZERO
        }
    });
    let forms = [
        plane,
        cylinder,
        ellipsoid(DVec3::splat(100.0)),
        ellipsoid(DVec3::splat(30.0)),
        ellipsoid(DVec3::splat(9.0)),
        ellipsoid(DVec3::new(140.0, 60.0, 80.0)),
    ];
    for (i, form) in forms.iter().enumerate() {
        assert_eq!(lines(form), [], "form {i}");
        assert_eq!(lines(&noisy(form)), [], "form {i}, noisy");
    }
}

/// The points of lines of a kind, at least 20 pixels from the border of a picture.
fn points(lines: &[Contour], kind: ContourKind, width: usize, height: usize) -> Vec<Vec2> {
    let inside = |p: &&Vec2| {
        let room = p.min(Vec2::new(width as f32, height as f32) - **p);
        room.min_element() > 20.0
    };
    let own = lines.iter().filter(|line| line.kind == kind);
    own.flat_map(|line| line.points.iter().filter(inside).copied())
        .collect()
}

#[test]
fn a_groove_is_a_valley_where_its_walls_meet() {
    // Two planes of slope 0.5 that meet in the line through (160.3, 120) at 20 degrees to the vertical.
    let across = 20.0_f64.to_radians();
    let (cos, sin) = (across.cos(), across.sin());
    let offset = |x: f64, y: f64| (x - 160.3) * cos + (y - 120.0) * sin;
    for inward in [true, false] {
        let found = lines_of(WIDTH, HEIGHT, |x, y| {
            let slope = 0.5 * offset(x, y).signum() * if inward { 1.0 } else { -1.0 };
            // The height grows along (cos, -sin), y up.
            DVec3::new(-slope * cos, slope * sin, 1.0)
        });
        let kind = if inward {
            ContourKind::Valley
        } else {
            ContourKind::Ridge
        };
        let points = points(&found, kind, WIDTH, HEIGHT);
        assert!(points.len() > 150, "{} points", points.len());
        for p in points {
            let off = offset(f64::from(p.x), f64::from(p.y));
            assert!(off.abs() < 0.3, "{p} is {off} off");
        }
        assert!(found.iter().all(|line| line.kind == kind));
    }
}

/// Three periods of a cosine wave across the picture seen from 45 degrees above: height `amplitude cos(2 pi y/length)`
/// over a plane leaning back by 45 degrees.
const LENGTH: f64 = 20.0;
const AMPLITUDE: f64 = 0.9 * LENGTH / TAU;

#[test]
fn a_suggestive_contour_runs_where_a_wave_is_steepest() {
    // z = -y tan 45 + A cos(k y), slope s = -1 - A k sin(k y) with A k = 0.9. n.v = 1/sqrt(1 + s^2) is least where |s| is
    // largest: sin(k y) = 1, y = LENGTH/4 + any whole LENGTH. There the surface leans by atan 1.9 = 62 degrees.
    let k = TAU / LENGTH;
    let found = lines_of(640, 480, |_, y| {
        let up = 240.0 - y;
        let wave = if up.abs() < 1.5 * LENGTH {
            (k * up).sin()
        } else {
            0.0
        };
        let slope = -1.0 - AMPLITUDE * k * wave;
        DVec3::new(0.0, -slope, 1.0)
    });
    let points = points(&found, ContourKind::Suggestive, 640, 480);
    assert!(points.len() > 400, "{} points", points.len());
    for p in points {
        let from_crest = (240.0 - f64::from(p.y) - 0.25 * LENGTH).rem_euclid(LENGTH);
        let off = from_crest.min(LENGTH - from_crest);
        assert!(off < 0.5, "{p} is {off} off");
    }
}

/// A ball of radius 140 that protrudes from a plane by a cap of 35 degrees, with a rim of radius 140 sin 35 degrees.
fn sunk_ball() -> Vector3Planes {
    Vector3Planes::from_fn(WIDTH, HEIGHT, |x, y| {
        let (x, y) = (x as f64 + 0.5 - 160.0, 120.0 - (y as f64 + 0.5));
        match x.hypot(y) < RIM {
            true => DVec3::new(x, y, (140.0 * 140.0 - x * x - y * y).sqrt()) / 140.0,
            false => DVec3::Z,
        }
    })
}

const RIM: f64 = 140.0 * 0.573_576;

#[test]
fn a_line_runs_where_surfaces_meet_at_one_depth() {
    let found = lines(&sunk_ball());
    let points = points(&found, ContourKind::Valley, WIDTH, HEIGHT);
    let mut degrees = [false; 360];
    for p in &points {
        let from_middle = (*p - Vec2::new(160.0, 120.0)).as_dvec2();
        let off = from_middle.length() - RIM;
        assert!(off.abs() < 0.7, "{p} is {off} off");
        degrees[from_middle.to_angle().to_degrees().rem_euclid(360.0) as usize] = true;
    }
    // A degree is 1.4 pixels long.
    let reached = (0..360).filter(|i| (0..3).any(|j| degrees[(i + j) % 360]));
    assert!(reached.count() > 350);
}

/// F measure of two sets of points: a point agrees if the other set has one within this many pixels.
fn agreement(a: &[Vec2], b: &[Vec2], within: f32) -> f64 {
    let share = |from: &[Vec2], to: &[Vec2]| {
        let is_near = |p: &&Vec2| to.iter().any(|q| p.distance(*q) <= within);
        from.iter().filter(is_near).count() as f64 / from.len() as f64
    };
    let (there, back) = (share(a, b), share(b, a));
    2.0 * there * back / (there + back)
}

#[test]
fn noise_leaves_lines_where_they_are() {
    // Rings 60 pixels apart and waves 40 pixels long, in a picture of 640 by 480. Along the rings the normal turns by
    // 1.2 2 pi/60 554 = 70 over the picture, well over the least of a ridge, 44. F of 0.85, within 0.00375 of its
    // diagonal of 800 pixels.
    let slopes = |slope: fn(f64, f64) -> [f64; 2]| {
        Vector3Planes::from_fn(640, 480, |x, y| {
            let [across, up] = slope(x as f64 + 0.5 - 320.0, 240.0 - (y as f64 + 0.5));
            DVec3::new(-across, -up, 1.0).normalize()
        })
    };
    let rings = slopes(|x, y| {
        let r = x.hypot(y);
        [x, y].map(|along| 1.2 * (TAU * r / 60.0).sin() * along / r)
    });
    let waves = slopes(|x, y| [0.0, 0.6 * (TAU * (y + 0.2 * x) / 40.0).sin()]);
    for (i, form) in [rings, waves].into_iter().enumerate() {
        let [clean, noisy] = [form.clone(), noisy(&form)].map(|normals| {
            let lines = lines(&normals);
            let points = lines.iter().flat_map(|line| line.points.iter().copied());
            points.collect::<Vec<_>>()
        });
        let f = agreement(&clean, &noisy, 3.0);
        assert!(clean.len() > 300 && f >= 0.85, "form {i}: {f}");
    }
}

#[test]
fn cast_shadows_end_in_lines_and_shade_does_not() {
    let params = InteriorParams {
        shadow_share: 0.5,
        ..InteriorParams::default()
    };
    let toward = DVec3::new(-1.0, 1.0, 1.0).normalize();
    let lit = |normals: &Vector3Planes, shadow: &dyn Fn(f64, f64) -> f64| {
        let light = Plane::from_fn(WIDTH, HEIGHT, |x, y| {
            let light = normals.at(x, y).dot(toward).max(0.0);
            (light * shadow(x as f64 + 0.5 - 160.0, y as f64 + 0.5 - 120.0)) as f32
        });
        Frame {
            color: Some(ColorPlanes::grey(light)),
            ..frame_of(normals)
        }
    };
    // Half of a ball faces away from the light.
    let ball = ellipsoid(DVec3::splat(100.0));
    assert_eq!(lines_of_frame(&lit(&ball, &|_, _| 1.0), &params), []);
    // A disk keeps seven tenths of the light from a plane, in an ellipse of axes 80 and 60.
    let plane = Vector3Planes::from_fn(WIDTH, HEIGHT, |_, _| DVec3::Z);
    let place = |x: f64, y: f64| (x / 80.0).hypot(y / 60.0);
    let disk = |x, y| if place(x, y) < 1.0 { 0.3 } else { 1.0 };
    let frame = lit(&plane, &disk);
    let points = points(
        &lines_of_frame(&frame, &params),
        ContourKind::Shadow,
        WIDTH,
        HEIGHT,
    );
    assert!(points.len() > 300, "{} points", points.len());
    for p in points {
        let off = 60.0 * (place(f64::from(p.x) - 160.0, f64::from(p.y) - 120.0) - 1.0);
        assert!(off.abs() < 0.7, "{p} is {off} off");
    }
    // Painted on, it is not a shadow; and unless requested it is not a line.
    let painted = Frame {
        albedo: frame.color.clone(),
        ..frame.clone()
    };
    assert_eq!(lines_of_frame(&painted, &params), []);
    assert_eq!(lines_of_frame(&frame, &InteriorParams::default()), []);
}

#[test]
fn a_picture_of_twice_the_size_has_the_same_lines() {
    // Rings around the middle, 60 pixels apart in the larger one.
    let rings = |scale: f64| {
        let (width, height) = ((320.0 * scale) as usize, (240.0 * scale) as usize);
        lines_of(width, height, |x, y| {
            let (x, y) = (x / scale - 160.0, y / scale - 120.0);
            let r = x.hypot(y);
            let slope = 0.8 * (TAU * r / 30.0).sin();
            if r < 100.0 {
                DVec3::new(-slope * x / r, slope * y / r, 1.0)
            } else {
                DVec3::ZERO
            }
        })
    };
    let [once, twice] = [1.0, 2.0].map(|scale| {
        let lines = rings(scale);
        let points = lines.iter().flat_map(|line| &line.points);
        points.map(|&p| p / scale as f32).collect::<Vec<_>>()
    });
    assert!(once.len() > 300 && agreement(&once, &twice, 1.5) >= 0.9);
}

#[test]
fn frames_without_meaning_have_no_lines() {
    let bad = [f32::NAN, f32::INFINITY, 0.0, 1e30];
    for (width, height) in [(1, 1), (1, 7), (5, 1), (33, 17)] {
        let samples = (0..width * height).map(|i| bad[i % bad.len()]);
        let plane = Plane::from_samples(width, height, samples.collect());
        let normal = Vector3Planes {
            x: plane.clone(),
            y: plane.clone(),
            z: plane,
        };
        for covered in [true, false] {
            let mask = Mask::new(Plane::filled(width, height, covered));
            let frame = Frame::of_normals(normal.clone(), mask);
            let silhouette = Plane::filled(width, height, f32::NAN);
            let (params, options) = (InteriorParams::default(), RunOptions::default());
            let (found, _) = interior(
                &drawn(&frame, &silhouette),
                (&[], None),
                &params,
                true,
                &options,
                &Memory::default(),
            );
            assert!(
                found
                    .iter()
                    .flat_map(|line| &line.points)
                    .all(|p| p.is_finite())
            );
        }
    }
}

#[test]
fn lines_are_heavy_where_they_are_plain() {
    // A groove whose walls steepen from the left to the right, and end 40 pixels from the border.
    let found = lines_of(WIDTH, HEIGHT, |x, y| {
        let is_inside = (40.0..280.0).contains(&x);
        let slope = if is_inside {
            0.1 + 0.8 * (x - 40.0) / 240.0
        } else {
            0.0
        };
        DVec3::new(0.0, slope * (y - 120.0).signum(), 1.0)
    });
    let valley = found
        .iter()
        .find(|line| line.kind == ContourKind::Valley)
        .expect("a groove");
    let at = |x: f32| {
        let nearest = valley.points.iter().zip(&valley.widths);
        let nearest = nearest.min_by(|a, b| (a.0.x - x).abs().total_cmp(&(b.0.x - x).abs()));
        *nearest.expect("a line has points").1
    };
    assert!(at(250.0) > 1.2 * at(100.0), "{} {}", at(250.0), at(100.0));
    // 277 is the root of 320 times 240: nothing is wider than 1.9 of 554 parts of that.
    let widest = InteriorParams::default().width_px * 277.2 / 554.3;
    assert!(valley.widths.iter().all(|&width| width <= widest));
}
