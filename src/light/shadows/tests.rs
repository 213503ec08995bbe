use super::horizons::{AZIMUTHS, Horizons};
use super::march::{LampPlace, Relief};
use super::*;
use crate::frame::{Frame, Mask, Vector3Planes};
use crate::light::batch::BATCH;
use crate::light::lights::{DirectionalLight, direction_of};
use crate::params::Adaptive;
use glam::DVec3;
use std::f64::consts::PI;

/// The share of a lamp this wide seen over these heights.
fn seen(height: &Plane, [azimuth, elevation]: [f32; 2], width_deg: f32) -> Plane {
    let light = DirectionalLight::white([azimuth, elevation]);
    assert_eq!(light.to_light, direction_of(azimuth, elevation));
    shares(
        height,
        &Lamp::of(&light, width_deg),
        1.0,
        &Memory::default(),
    )
}

/// The last column of a wall on the left.
const WALL: usize = 4;

/// A wall of this height on the left of a plane.
fn step(width: usize, rows: usize, high: f32) -> Plane {
    Plane::from_fn(width, rows, |x, _| if x <= WALL { high } else { 0.0 })
}

#[test]
fn the_first_pixel_beyond_the_shadow_of_a_step_is_lit() {
    // A wall 30 high darkens 30 / tan(elevation) along the light's azimuth: that times its cosine across columns.
    for elevation in [30.0, 15.0, 5.0_f32] {
        let length = 30.0 / f64::from(elevation).to_radians().tan();
        // Light that meets the middle row comes from inside the picture.
        let (width, rows) = (length as usize + 20, 2 * length as usize + 21);
        let wall = step(width, rows, 30.0);
        // Turned so that no shadow ends within an eighth of a pixel behind the middle of one.
        for turn in [0.0, 7.0, 19.0, 33.0, 44.0, 53.0, 61.0, 68.0, 74.0, 81.0_f32] {
            for azimuth in [180.0 - turn, 180.0 + turn] {
                let end = WALL as f64 + length * f64::from(turn).to_radians().cos();
                let shares = seen(&wall, [azimuth, elevation], 0.0);
                let row = &shares.row(rows / 2)[WALL + 1..];
                let first = row.iter().position(|&share| share > 0.5);
                let expected = end.floor() as usize - WALL;
                assert_eq!(first, Some(expected), "{azimuth} {elevation}: {end}");
                assert!(row[expected..].iter().all(|&share| share > 0.5));
                assert!(
                    shares.row(rows / 2)[..=WALL]
                        .iter()
                        .all(|&share| share > 0.5)
                );
            }
        }
    }
}

#[test]
fn the_penumbra_of_a_step_is_that_of_a_disc() {
    // At a distance d the wall hides the lamp up to atan(h / d): what is left of a disc above a line.
    let exact = |u: f64| {
        let u = u.clamp(-1.0, 1.0);
        (u.acos() - u * (1.0 - u * u).sqrt()) / PI
    };
    for (azimuth, elevation, width_deg) in [
        (180.0, 30.0, 2.0),
        (180.0, 30.0, 4.0),
        (180.0, 15.0, 4.0),
        (180.0, 45.0, 8.0_f64),
    ] {
        // So low that a single azimuth serves.
        let wall = step(60, 3, 5.0);
        let shares = seen(&wall, [azimuth, elevation as f32], width_deg as f32);
        for (x, &share) in shares.row(1).iter().enumerate().skip(WALL + 1) {
            let horizon = 5.0_f64.atan2((x - WALL) as f64).to_degrees();
            let expected = exact((horizon - elevation) / (0.5 * width_deg));
            let error = f64::from(share) - expected;
            assert!(error.abs() < 1e-6, "{elevation} {width_deg} {x}: {error}");
        }
    }
}

/// The share of wrong pixels on the ground, in pixels of the border of the shadow of a solid `high` by the distance from its
/// axis; `radius` is its largest.
fn wrong_beside_border(high: impl Fn(f64) -> f64, radius: f64, light: [f32; 2]) -> f64 {
    let size = 201;
    let [azimuth, elevation] = light.map(|deg| f64::from(deg).to_radians());
    let middle = (size / 2) as f64;
    // Away from pixels, so that none is on a border.
    let at = |x: usize, y: usize| [x as f64 - middle - 0.23, y as f64 - middle + 0.41];
    let solid = Plane::from_fn(size, size, |x, y| {
        let [x, y] = at(x, y);
        high(x.hypot(y)) as f32
    });
    let shares = seen(&solid, light, 0.0);
    let tallest = high(0.0);
    let dark = Plane::from_fn(size, size, |x, y| {
        let [x, y] = at(x, y);
        let steps = (tallest / elevation.tan() / 0.1) as usize;
        (0..steps).any(|i| {
            let t = 0.1 * i as f64;
            let beside = (x + t * azimuth.cos()).hypot(y - t * azimuth.sin());
            beside < radius && t * elevation.tan() < high(beside)
        })
    });
    let on_ground = |x: usize, y: usize| {
        let [x, y] = at(x, y);
        x.hypot(y) > radius + 1.0
    };
    let (mut wrong, mut border) = (0, 0);
    for y in 1..size - 1 {
        for x in (1..size - 1).filter(|&x| on_ground(x, y)) {
            let is_dark = dark.at(x, y);
            wrong += usize::from(is_dark != (shares.at(x, y) < 0.5));
            border += usize::from([dark.at(x + 1, y), dark.at(x, y + 1)].contains(&!is_dark));
        }
    }
    assert!(border > 50, "there is a shadow");
    wrong as f64 / border as f64
}

#[test]
fn shadows_of_a_cylinder_and_a_sphere_end_within_half_a_pixel() {
    let cylinder = |r: f64| if r < 14.0 { 28.0 } else { 0.0 };
    // What is under a sphere is hidden from the eye, and taken for filled.
    let sphere = |r: f64| {
        if r < 20.0 {
            20.0 + (400.0 - r * r).sqrt()
        } else {
            0.0
        }
    };
    for light in [[180.0, 30.0], [135.0, 25.0], [300.0, 40.0], [20.0, 30.0]] {
        let wrong = wrong_beside_border(cylinder, 14.0, light);
        assert!(wrong < 0.5, "cylinder, {light:?}: {wrong}");
        let wrong = wrong_beside_border(sphere, 20.0, light);
        assert!(wrong < 0.5, "sphere, {light:?}: {wrong}");
    }
}

#[test]
fn a_slope_that_faces_the_lamp_is_free_of_its_own_shadow() {
    // No bias is needed: the horizon of a plane is the plane.
    for azimuth in [0.0, 12.0, 45.0, 77.0, 200.0, 301.0_f32] {
        let (sine, cosine) = azimuth.to_radians().sin_cos();
        for (slope, aside) in [(-0.3, 0.0), (0.3, 0.0), (0.3, 0.5), (0.1, -0.4_f32)] {
            let [x_slope, y_slope] = [
                slope * cosine - aside * sine,
                -slope * sine - aside * cosine,
            ];
            let tilted = Plane::from_fn(90, 70, |x, y| x_slope * x as f32 + y_slope * y as f32);
            let elevation = (slope.atan().to_degrees() + 1.0).max(1.0);
            let shares = seen(&tilted, [azimuth, elevation], 0.0);
            assert!(shares.samples().iter().all(|&share| share > 0.999));
        }
    }
}

#[test]
fn any_size_of_picture_and_any_lamp_give_shares() {
    for (width, rows) in [(1, 1), (1, 9), (9, 1), (2, 2), (3, 40)] {
        let mask = Mask::full(width, rows);
        for height in [0.0, NOTHING] {
            let flat = Plane::filled(mask.width(), mask.height(), height);
            for elevation in [-90.0, -20.0, 0.0, 10.0, 90.0] {
                for azimuth in [0.0, 45.0, 90.0, 200.0, 271.0] {
                    let shares = seen(&flat, [azimuth, elevation], 4.0);
                    let are_shares = |s: &f32| (-1e-6..=1.000_001).contains(s);
                    assert!(shares.samples().iter().all(are_shares));
                    // A plane hides no lamp that is wholly above it.
                    let is_lit = |&s: &f32| s > 0.999;
                    assert!(elevation < 10.0 || shares.samples().iter().all(is_lit));
                }
            }
        }
    }
}

#[test]
fn what_is_outside_the_surface_casts_nothing() {
    // A hole as deep as a pit, and a border: next to both the ground is lit from a lamp far down.
    let with_hole = Plane::from_fn(40, 40, |x, y| match (x, y) {
        (10..20, 10..20) => NOTHING,
        _ => 5.0,
    });
    for azimuth in [0.0, 30.0, 100.0, 225.0] {
        let shares = seen(&with_hole, [azimuth, 3.0], 0.0);
        let mut ground = (0..40).flat_map(|y| (0..40).map(move |x| [x, y]));
        assert!(ground.all(|[x, y]| with_hole.at(x, y) == NOTHING || shares.at(x, y) > 0.999));
    }
}

#[test]
fn light_passes_behind_a_slab_as_thick_as_it_is_said_to_be() {
    // A slab 20 pixels wide, its front 40 above the ground and its back 30, under light from the left at 45 degrees: the ray
    // to a pixel d beyond it passes over it at heights d to d + 20.
    let (width, rows, edge) = (140, 3, 60);
    let depth = Plane::from_fn(width, rows, |x, _| {
        if (40..=edge).contains(&x) {
            60.0
        } else {
            100.0
        }
    });
    let normal = Vector3Planes::from_fn(width, rows, |_, _| DVec3::Z);
    let away = Vector3Planes::from_fn(width, rows, |_, _| DVec3::NEG_Z);
    let mut frame = Frame::of_normals(normal.clone(), Mask::full(width, rows));
    frame.depth = Some(depth);
    let lamp = Lamp::of(&DirectionalLight::white([180.0, 45.0]), 0.0);
    let near = DVec3::new(-1e6, -1.5, 1e6);
    for (thickness, from) in [(10.0, 10), (1e6, 1)] {
        let relief = Relief::new(&frame, Adaptive::Fixed(thickness));
        for place in [LampPlace::Far(lamp), LampPlace::Near(near, 0.0)] {
            let shares = relief.shares(&place, Some(&normal), &Memory::default());
            // Pixels that face away are not asked for, unless light is turned to them.
            let all = relief.shares(&place, None, &Memory::default());
            assert_eq!(shares.samples(), all.samples());
            let dark = relief.shares(&place, Some(&away), &Memory::default());
            assert!(dark.samples().iter().all(|&share| share == 1.0));
            for d in 1..width - 1 - edge {
                let is_lit = shares.at(edge + d, 1) > 0.5;
                // At the ends of the shadow the ray touches an edge.
                let expected = d < from || d > 40;
                assert!(
                    d == from || d == 40 || is_lit == expected,
                    "{thickness}, {d}"
                );
            }
            assert!((0..=edge).all(|x| shares.at(x, 1) > 0.5));
        }
    }
}

/// The share of a light in each of these directions that a pixel sees over these heights, and of the sky.
fn seen_from(heights: &Plane, [x, y]: [usize; 2], directions: &[[f32; 3]]) -> (Vec<f32>, f32) {
    let horizons = Horizons::of(heights, 1.0, |plane| plane);
    let mut lanes = [[0.0; BATCH]; AZIMUTHS];
    horizons.copy_to(&mut lanes, 0, (y, x..x + 1));
    let seen = directions.iter().map(|direction| {
        let mut light = [1.0; BATCH];
        horizons::Bearing::of(*direction).hide(&lanes, &mut light);
        light[0]
    });
    let normals = [[0.0; BATCH], [0.0; BATCH], [1.0; BATCH]];
    let mut sky = [0.0; BATCH];
    horizons::see_sky(&lanes, &normals, &mut sky);
    (seen.collect(), sky[0])
}

#[test]
fn a_trench_hides_the_sky_but_for_its_opening() {
    // From the middle of the floor of a trench 41 pixels wide and h deep an even sky is seen as far as sin(atan(20.5 / h)), and
    // lights at right angles to it from just over the elevation of its edge, lights along it from just over the ground.
    let side = 301;
    for (depth, opening) in [(20.5_f32, 0.5_f32.sqrt()), (41.0, 0.2_f32.sqrt())] {
        let is_floor = |x: usize| x.abs_diff(side / 2) <= 20;
        let heights = Plane::from_fn(side, side, |x, _| if is_floor(x) { 0.0 } else { depth });
        let edge = (depth / 20.5).atan();
        let toward = |azimuth: f32, elevation: f32| {
            let (sine, cosine) = elevation.sin_cos();
            [cosine * azimuth.cos(), cosine * azimuth.sin(), sine]
        };
        let apart = 0.15;
        let directions = [
            toward(0.0, edge + apart),
            toward(0.0, edge - apart),
            toward(PI as f32, edge - apart),
            toward(0.5 * PI as f32, apart),
        ];
        let (seen, sky) = seen_from(&heights, [side / 2; 2], &directions);
        // The azimuth of a light is rounded by a ten-millionth of a step.
        let off = seen
            .iter()
            .zip([1.0_f32, 0.0, 0.0, 1.0])
            .map(|(a, b)| a - b);
        assert!(off.into_iter().all(|off| off.abs() < 1e-6), "{seen:?}");
        assert!(
            (sky - opening).abs() < 0.02,
            "{depth}: {sky}, not {opening}"
        );
    }
}

#[test]
fn a_light_of_its_own_in_each_pixel_is_hidden_as_one_of_all() {
    let heights = Plane::from_fn(BATCH + 40, 47, |x, y| ((x * 7 + y * 5) % 23) as f32);
    let horizons = Horizons::of(&heights, 1.0, |plane| plane);
    let mut lanes = [[0.0; BATCH]; AZIMUTHS];
    horizons.copy_to(&mut lanes, 0, (20, 10..10 + BATCH));
    let (mut partly, golden) = (0, 2.399_963_f32);
    for first in 0..200 {
        let directions: [[f32; 3]; BATCH] = std::array::from_fn(|i| {
            let (turn, z) = (golden * (first * BATCH + i) as f32, 0.005 * first as f32);
            let across = (1.0 - z * z).sqrt();
            [across * turn.cos(), across * turn.sin(), z]
        });
        let toward = std::array::from_fn(|k| directions.map(|direction| direction[k]));
        let mut each = [1.0; BATCH];
        horizons::hide_each(&lanes, &toward, &mut each);
        for (i, direction) in directions.iter().enumerate() {
            let mut all = [1.0; BATCH];
            horizons::Bearing::of(*direction).hide(&lanes, &mut all);
            assert!((each[i] - all[i]).abs() < 1e-4, "{direction:?}");
            partly += usize::from(all[i] > 0.1 && all[i] < 0.9);
        }
    }
    assert!(partly > 100, "{partly}");
}

#[test]
fn flat_ground_sees_all_of_the_sky() {
    let (seen, sky) = seen_from(
        &Plane::filled(64, 48, 3.0),
        [20, 30],
        &[[0.0, 0.0, 1.0], [0.9, 0.0, 0.2]],
    );
    assert_eq!(seen, [1.0; 2]);
    assert!((sky - 1.0).abs() < 1e-3, "{sky}");
}
