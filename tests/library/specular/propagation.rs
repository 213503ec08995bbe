//! Directions through mirrors and lenses, against exact ones.

use super::exact::{Scene, Thing};
use super::*;
use relievo::line::propagation::{Beside, external_camera};
use relievo::trace::Tracer;

/// Errors of direction in degrees, sorted, with the share of pixels that had one.
struct Errors {
    sorted: Vec<f64>,
    share: f64,
}

impl Errors {
    fn at(&self, share: f64) -> f64 {
        quantile(&self.sorted, share)
    }
}

/// Directions by the pipeline, in the surroundings or on the surface behind, against exact ones.
fn errors(scene: &Scene, beyond: SpecularScene) -> Errors {
    let frame = scene.frame();
    let beyond = SpecularScene {
        back: (scene.thing == Thing::GlassBall).then(|| scene.back()),
        ..beyond
    };
    let bend = match scene.thing {
        Thing::GlassBall => REFRACTED,
        _ => Bend::Mirror,
    };
    let tracer = Tracer::new(&frame, &beyond, &traced(bend)).expect("depth and a camera");
    let (mut errors, mut all) = (Vec::new(), 0);
    let inner = places(scene.size - 2, scene.size - 2).map(|(x, y)| (x + 1, y + 1));
    for (x, y) in inner {
        let Some((expected, tangent)) = scene.seen(middle(x, y)) else {
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
            errors.push(sine.atan2(found.dot(expected).abs()).to_degrees());
        }
    }
    let share = errors.len() as f64 / f64::from(all);
    Errors {
        sorted: sorted(errors),
        share,
    }
}

fn around(scene: &Scene) -> SpecularScene {
    within(scene.surroundings(256))
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
    assert!(errors.share > 0.99 && errors.at(0.95) < 1e-3);
}

/// The errors in a picture of a ball of this size and focal length, of which this share is found.
fn of_ball(thing: Thing, size: usize, focal: f64, share: f64) -> Errors {
    let scene = Scene { thing, size, focal };
    let errors = errors(&scene, around(&scene));
    assert!(
        errors.share > share,
        "{thing:?}, {size} px: {}",
        errors.share
    );
    errors
}

#[test]
fn a_mirror_ball_is_of_second_order() {
    let at = |size: usize| of_ball(Thing::MirrorBall, size, 1.5 * size as f64, 0.98);
    let (coarse, fine) = (at(128), at(256));
    assert!(coarse.at(0.5) / fine.at(0.5) > 2.0_f64.powf(1.7));
    let largest = at(512);
    assert!(largest.at(0.5) <= 0.25 && largest.at(0.95) <= 2.0);
}

#[test]
fn a_glass_ball_is_of_first_order_or_better() {
    let at = |size: usize| of_ball(Thing::GlassBall, size, 500.0 * size as f64 / 320.0, 0.97);
    // At half the pixels the error is at least twice as large.
    let (coarse, fine) = (at(160), at(320));
    assert!(coarse.at(0.5) / fine.at(0.5) > 1.9);
    assert!(coarse.at(0.95) / fine.at(0.95) > 1.9);
    assert!(fine.at(0.95) < 0.8);
}
