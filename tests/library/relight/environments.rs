//! Environments to a stated error.

use super::{Asked, covered, torus, torus_in_perspective};
use crate::common::program::fixture;
use crate::common::relit::surroundings;
use crate::prelude::*;
use relievo::io::read_environment;

/// Grey levels of 255 by which 99 of 100 samples differ.
fn p99(found: &ColorPlanes, truth: &ColorPlanes, frame: &Frame) -> f64 {
    let shown = |v: f32| 255.0 * relievo::io::srgb::encoded(f64::from(v.clamp(0.0, 1.0)));
    let pairs = channels(found).into_iter().zip(channels(truth));
    let each = pairs.flat_map(|(found, truth)| {
        let apart = move |(x, y)| (shown(found.at(x, y)) - shown(truth.at(x, y))).abs();
        covered(&frame.mask).map(apart)
    });
    let each = sorted(each);
    each[(each.len() - 1) * 99 / 100]
}

fn asked(
    material: Material,
    method: Method,
    coat: f32,
    map: &Environment,
    samples: SampleCount,
) -> Asked {
    let mut asked = Asked::of(material, method).in_environment(map.clone(), samples);
    let of = &mut asked.relight.material;
    of.coat = [coat; 2];
    // An albedo of 0.5 with the gains of the defaults.
    (of.diffuse_gain, of.ambient, of.specular_gain) = (0.45, 0.05, None);
    asked.relight.environment_gain = Adaptive::Auto;
    asked
}

/// A sun of half a degree in a blue sky, over a chequered ground.
fn outdoors() -> Environment {
    let sun = Vec3::new(-0.5, 0.6, 0.6).normalize();
    surroundings(256, |d| {
        match (Vec3::from_array(d).dot(sun) > 0.9998, d[1] > 0.0) {
            (true, _) => [9e3, 8e3, 6e3],
            (_, true) => [0.3 + 0.4 * d[1], 0.5 + 0.4 * d[1], 1.0],
            _ if (6.0 * d[0]).sin() * (6.0 * d[2]).sin() > 0.0 => [0.3, 0.25, 0.2],
            _ => [0.05; 3],
        }
    })
}

/// Two soft boxes and a strip light in the dark.
fn studio() -> Environment {
    let boxes = [([-0.8, 0.5, 0.4], 0.85), ([0.7, 0.2, 0.6], 0.93)];
    surroundings(256, |d| {
        let within = |(at, cosine): ([f32; 3], f32)| {
            Vec3::from_array(d).dot(Vec3::from_array(at).normalize()) > cosine
        };
        match () {
            () if boxes.into_iter().any(within) => [12.0, 11.0, 10.0],
            () if d[1].abs() < 0.02 && d[2] > 0.0 => [40.0; 3],
            () => [0.05, 0.06, 0.08],
        }
    })
}

/// Windows of a room by day.
fn indoors() -> Environment {
    let room = read_environment(&fixture("room.hdr"));
    room.unwrap().resized(256)
}

#[test]
fn light_keeps_to_the_error_allowed() {
    use Method::{Both, Plain, Warp};
    let cases = [
        (Material::Lambert, 0.0, vec![Warp], 2.0),
        (Material::Phong, 0.0, vec![Both], 2.0),
        (Material::AshikhminShirley, 80.0, vec![Plain, Both], 4.0),
        (Material::AshikhminShirley, 300.0, vec![Plain], 4.0),
    ];
    for (name, map) in [
        ("outdoors", outdoors()),
        ("studio", studio()),
        ("indoors", indoors()),
    ] {
        for (material, coat, methods, allowed) in &cases {
            for (i, &method) in methods.iter().enumerate() {
                let frame = [torus, torus_in_perspective][i]();
                let asked = |samples| asked(*material, method, *coat, &map, samples);
                // As many lights as the map has texels: the cut ends at each of them.
                let truth = asked(SampleCount::Fixed(256 * 128)).color(&frame);
                let auto = asked(SampleCount::Auto).outcome(&frame);
                let error = p99(auto.color.as_ref().unwrap(), &truth, &frame);
                let choice = auto.light_choice.map(|choice| choice.to_string());
                let case = format!("{name} {material:?} {coat} {method:?} ({choice:?})");
                assert!(error <= *allowed, "{case}: {error}");
            }
        }
    }
}

#[test]
fn a_larger_error_takes_fewer_lights() {
    let frame = torus();
    let choice = |levels| {
        let material = Material::AshikhminShirley;
        let mut asked = asked(material, Method::Both, 80.0, &studio(), SampleCount::Auto);
        asked.relight.light_error = Some(levels);
        asked.outcome(&frame).light_choice.unwrap()
    };
    let [fine, coarse] = [0.5, 40.0].map(choice);
    let errs_less = fine.levels < coarse.levels && coarse.levels <= 40.0;
    let takes_more = fine.lights > coarse.lights || fine.samples > coarse.samples;
    assert!(errs_less && takes_more, "{fine}, {coarse}");
}

#[test]
fn strange_maps_give_light_that_is_finite() {
    let frame = torus();
    let spot = |value: f32| {
        let at = |x, y| if (x, y) == (40, 9) { value } else { 0.2 };
        Environment::from_fn(64, 32, |x, y| [at(x, y); 3])
    };
    let maps = [
        spot(f32::NAN),
        spot(f32::INFINITY),
        spot(1e6),
        spot(1e30),
        Environment::from_fn(64, 32, |_, _| [0.0; 3]),
        Environment::from_fn(1, 1, |_, _| [2.0, 1.0, 0.0]),
        Environment::from_fn(3, 1, |x, _| [x as f32; 3]),
        Environment::from_fn(8, 4, |x, y| [if (x, y) == (4, 1) { 1e6 } else { 0.0 }; 3]),
    ];
    for (i, map) in maps.iter().enumerate() {
        let materials = [
            (Material::Sublambert, 0.0),
            (Material::Phong, 0.0),
            (Material::AshikhminShirley, 0.0),
            (Material::AshikhminShirley, 1e5),
        ];
        for (j, (material, coat)) in materials.into_iter().enumerate() {
            let method = [Method::Plain, Method::Both][(i + j) % 2];
            let outcome = asked(material, method, coat, map, SampleCount::Auto).outcome(&frame);
            let color = outcome.color.unwrap();
            let mut samples = channels(&color)
                .into_iter()
                .flat_map(|plane| plane.samples());
            let is_light = samples.all(|v| v.is_finite() && *v >= 0.0);
            assert!(is_light, "map {i}, {material:?} {coat}, {method:?}");
            let choice = outcome.light_choice;
            assert!(choice.is_none_or(|choice| choice.levels.is_finite()));
        }
    }
}
