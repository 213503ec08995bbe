use super::*;
use crate::frame::Mask;
use crate::light::lights::{DirectionalLight, direction_of};
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
