//! Directions through mirrors and lenses, against exact ones.

use super::exact::{Scene, Thing};
use crate::prelude::*;
use relievo::line::propagation::{Beside, external_camera};
use relievo::trace::Tracer;
use std::sync::Arc;

/// Errors of direction in degrees, sorted, with the share of pixels that had one.
struct Errors {
    sorted: Vec<f64>,
    share: f64,
}

impl Errors {
    fn at(&self, share: f64) -> f64 {
        self.sorted[((self.sorted.len() - 1) as f64 * share) as usize]
    }
}

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (median, p95) = (self.at(0.5), self.at(0.95));
        write!(
            f,
            "median {median:.5}, p95 {p95:.5} degrees, {:.2} %",
            100.0 * self.share
        )
    }
}

fn bend_of(scene: &Scene) -> Bend {
    match scene.thing {
        Thing::GlassBall => Bend::Glass {
            ior: super::exact::IOR as f32,
        },
        _ => Bend::Mirror,
    }
}

/// Directions by the pipeline, in the surroundings or on the surface behind, against exact ones.
fn errors(scene: &Scene, beyond: SpecularScene) -> Errors {
    let frame = scene.frame();
    let beyond = SpecularScene {
        back: (scene.thing == Thing::GlassBall).then(|| scene.back()),
        ..beyond
    };
    let params = SpecularParams {
        bend: bend_of(scene),
        search: SearchParams::default(),
    };
    let tracer = Tracer::new(&frame, &beyond, &params).expect("depth and a camera");
    let (mut sorted, mut all) = (Vec::new(), 0);
    for y in 1..scene.size - 1 {
        for x in 1..scene.size - 1 {
            let at = DVec2::new(x as f64, y as f64) + 0.5;
            let Some((expected, tangent)) = scene.seen(at) else {
                continue;
            };
            all += 1;
            let found = || {
                let here = tracer.path(x, y)?;
                let [left, right] = [x - 1, x + 1].map(|x| tracer.path(x, y));
                let [below, above] = [y + 1, y - 1].map(|y| tracer.path(x, y));
                let beside = Beside {
                    across: [left.as_ref(), right.as_ref()],
                    up: [below.as_ref(), above.as_ref()],
                };
                let external = external_camera(&here, &beside)?;
                let hit = tracer.hit(&here.leaving())?;
                external.seen(hit.point, tangent).try_normalize()
            };
            if let Some(found) = found() {
                let sine = found.perp_dot(expected).abs();
                sorted.push(sine.atan2(found.dot(expected).abs()).to_degrees());
            }
        }
    }
    sorted.sort_by(f64::total_cmp);
    let share = sorted.len() as f64 / f64::from(all);
    Errors { sorted, share }
}

fn around(scene: &Scene) -> SpecularScene {
    SpecularScene {
        surroundings: Some(Arc::new(scene.surroundings(256))),
        ..SpecularScene::default()
    }
}

#[test]
fn a_flat_mirror_is_exact() {
    // Rays mirrored by a plane are those of a pinhole behind it: the linear camera is exact, and the map's walls are
    // planes. Only the rounding of f32 samples remains.
    let scene = Scene {
        thing: Thing::FlatMirror(DVec3::new(0.3, 0.4, 1.0).normalize()),
        size: 128,
        focal: 150.0,
    };
    let errors = errors(&scene, around(&scene));
    println!("flat mirror: {errors}");
    assert!(errors.share > 0.99 && errors.at(0.95) < 1e-3);
}

#[test]
fn a_mirror_ball_is_of_second_order() {
    let at = |size: usize| {
        let scene = Scene {
            thing: Thing::MirrorBall,
            size,
            focal: 1.5 * size as f64,
        };
        let errors = errors(&scene, around(&scene));
        println!("mirror ball, {size} px: {errors}");
        assert!(errors.share > 0.98);
        errors
    };
    let (coarse, fine) = (at(128), at(256));
    assert!(coarse.at(0.5) / fine.at(0.5) > 2.0_f64.powf(1.7));
    let largest = at(512);
    assert!(largest.at(0.5) <= 0.25 && largest.at(0.95) <= 2.0);
}

#[test]
fn a_glass_ball_is_of_first_order_or_better() {
    let at = |size: usize| {
        let scene = Scene {
            thing: Thing::GlassBall,
            size,
            focal: 500.0 * size as f64 / 320.0,
        };
        let errors = errors(&scene, around(&scene));
        println!("glass ball, {size} px: {errors}");
        assert!(errors.share > 0.97);
        errors
    };
    // At half the pixels the error is at least twice as large.
    let (coarse, fine) = (at(160), at(320));
    assert!(coarse.at(0.5) / fine.at(0.5) > 1.9);
    assert!(coarse.at(0.95) / fine.at(0.95) > 1.9);
    assert!(fine.at(0.95) < 0.8);
}
