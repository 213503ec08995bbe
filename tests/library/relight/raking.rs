//! Raking light from the azimuth that shows each region best.

use super::{Asked, bits, facing};
use crate::prelude::*;

/// Banks in 18 directions, 10 degrees apart, on ground that rolls by 3 m in 150 px of 1 m.
const BANKS: usize = 18;
const CELL: f64 = 110.0;
const COLUMNS: usize = 6;
const WIDTH: usize = CELL as usize * COLUMNS;
const HEIGHT: usize = CELL as usize * BANKS / COLUMNS;

/// Height of a bank, its sigma across and half its length.
const BANK: [f64; 3] = [0.15, 2.5, 35.0];

/// Standard deviation of the slopes' noise.
const NOISE: f64 = 0.006;

/// The middle of a bank and the direction across it.
fn bank(i: usize) -> (DVec2, DVec2) {
    let place = DVec2::new((i % COLUMNS) as f64, (i / COLUMNS) as f64);
    let across = DVec2::from_angle((10.0 * i as f64).to_radians());
    (CELL * (place + 0.5), across)
}

/// Normals by pixel; y of the picture runs down.
pub(super) fn ground() -> Frame {
    let mut random = 1_u64;
    let mut uniform = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005);
        random = random.wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
    };
    facing(WIDTH, HEIGHT, |x, y| {
        let at = DVec2::new(x as f64, y as f64);
        let turn = std::f64::consts::TAU / 150.0;
        let rolling = DVec2::new((turn * at.x).cos(), (turn * at.y + 1.0).cos());
        let mut slope = 3.0 * turn * rolling * 0.5;
        let i = (at.x / CELL) as usize + COLUMNS * (at.y / CELL) as usize;
        let (middle, across) = bank(i);
        let (off, along) = ((at - middle).dot(across), (at - middle).dot(across.perp()));
        let [height, sigma, half] = BANK;
        if along.abs() < half {
            let bell = height * (-0.5 * (off / sigma).powi(2)).exp();
            slope -= bell * off / (sigma * sigma) * across;
        }
        // The sum of twelve has a variance of 1.
        let mut noise = || NOISE * (0..12).map(|_| uniform()).sum::<f64>();
        slope += DVec2::new(noise(), noise());
        Vec3::new(-slope.x as f32, slope.y as f32, 1.0)
    })
}

/// How much brighter one flank of each bank is than the other, in the mean along it, beyond the trend of the ground, over
/// the noise of a pixel.
fn shown(asked: &Asked, frame: &Frame) -> [f64; BANKS] {
    let color = asked.color(frame).g;
    let at = |p: DVec2| f64::from(color.at(p.x.round() as usize, p.y.round() as usize));
    let [_, sigma, half] = BANK;
    std::array::from_fn(|i| {
        let (middle, across) = bank(i);
        let spots = |off: f64| {
            let steps = (-(half as i32) + 5)..(half as i32 - 5);
            let (start, count) = (middle + off * across, steps.len() as f64);
            let spots = steps.map(|along| at(start + f64::from(along) * across.perp()));
            spots.sum::<f64>() / count
        };
        let flanks = spots(sigma) - spots(-sigma);
        let trend = (spots(4.0 * sigma) - spots(-4.0 * sigma)) / 4.0;
        // Light at 30 degrees changes by its cosine with the slope that it meets.
        (flanks - trend).abs() / (NOISE * 30.0_f64.to_radians().cos())
    })
}

pub(super) fn raking(raking: Raking) -> Asked {
    Asked::of(Material::Lambert, Method::Plain).with(|asked| {
        asked.relight.raking = raking;
        asked.light = Illumination::default();
        let lamp = DirectionalLight::white([135.0, 30.0]);
        asked.light.directional.push(lamp);
    })
}

#[test]
fn banks_of_all_directions_are_shown_alike() {
    let frame = ground();
    let of = |asked: &Asked| {
        let shown = shown(asked, &frame);
        let least = shown.iter().copied().fold(f64::INFINITY, f64::min);
        (least, least / shown.iter().copied().fold(0.0, f64::max))
    };
    let (least, share) = of(&raking(Raking::Best));
    assert!(least > 8.5 && share > 0.8, "{least} {share}");
    // A bank along the light is lost.
    let (least, share) = of(&raking(Raking::Given));
    assert!(least < 3.0 && share < 0.3, "{least} {share}");
}

/// Without detail the light stays.
#[test]
fn flat_ground_is_lit_as_given() {
    let frame = facing(80, 60, |_, _| Vec3::new(0.1, -0.05, 1.0));
    let [best, given] = [Raking::Best, Raking::Given].map(|how| raking(how).color(&frame));
    assert!(apart(&best.g, &given.g) < 1e-4);
}

/// Highlights, warping and alignment follow lamps that rake.
#[test]
fn every_method_takes_lamps_that_rake() {
    let frame = ground();
    for method in [Method::Both, Method::Align] {
        let of = |how| {
            let asked = raking(how).with(|asked| asked.relight.method = method);
            bits(&asked.color(&frame))
        };
        assert!(of(Raking::Best) != of(Raking::Given), "{method:?}");
    }
}
