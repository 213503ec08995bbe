//! Mirrors and glass in new light: they show the hits of their sight lines, scaled and warped like other light.

use super::exact::{CENTER, IOR, Scene, Thing};
use super::*;
use relievo::light::brdf::fresnel;

/// A smooth colour of the room, by the point from its middle.
fn paint(p: DVec3) -> [f32; 3] {
    let wave = |v: f64| (0.5 + 0.3 * (0.7 * v).sin()) as f32;
    [wave(p.x + p.y), wave(p.y - p.z), wave(p.z + 0.5 * p.x)]
}

fn around(scene: &Scene, height: usize) -> SpecularScene {
    let mut map = scene.surroundings(height);
    let world = scene.camera().view_from_world;
    map.color = Some(colors([map.width(), map.height()], |k, x, y| {
        paint(world.transform_vector3(map.point_at(x, y)))[k]
    }));
    within(map)
}

/// Parameters, changed so, of a material lit by nothing but what it shows.
fn params(material: Material, method: Method, change: impl FnOnce(&mut Params)) -> Params {
    default_but(|params: &mut Params| {
        params.relight.method = method;
        params.relight.material.material = material;
        params.relight.material.ior = IOR as f32;
        change(params);
    })
}

fn relit(frame: &Frame, scene: &SpecularScene, params: Params, run: &Run) -> ColorPlanes {
    let bend = match params.relight.material.material {
        Material::Glass => REFRACTED,
        _ => Bend::Mirror,
    };
    let light = Illumination::default();
    let request = Request::relight(params, &light).specular(scene, traced(bend));
    let outcome = Engine::cpu().run(&request, frame, run).unwrap();
    outcome.color.unwrap()
}

/// A mirror, as it is.
fn mirrored(frame: &Frame, scene: &SpecularScene, run: &Run) -> ColorPlanes {
    let plain = params(Material::Mirror, Method::Plain, |_| ());
    relit(frame, scene, plain, run)
}

fn of(color: &ColorPlanes, x: usize, y: usize) -> [f32; 3] {
    channels(color).map(|plane| plane.at(x, y))
}

const BALL: Scene = Scene {
    thing: Thing::MirrorBall,
    size: 96,
    focal: 140.0,
};

/// A mirror over half of a ball's picture, in a region across its border: the samples of the whole.
#[test]
fn a_region_of_a_mirror_is_that_part_of_the_whole() {
    let (frame, window) = (BALL.frame(), BALL.frame().data_window);
    let scene = SpecularScene {
        mask: Some(Mask::new(Plane::from_fn(96, 96, |x, y| x + y < 96))),
        ..around(&BALL, 64)
    };
    let whole = mirrored(&frame, &scene, &Run::new());
    let region = Window::at(window.x0 + 31, window.y0 + 26, 37, 29);
    let part = mirrored(&frame, &scene, &Run::new().region(region));
    for (part, whole) in channels(&part).into_iter().zip(channels(&whole)) {
        assert_eq!(bits(part), bits(&whole.crop(window, region)));
    }
    assert!(part.r.samples().iter().any(|&red| red > 0.3));
}

#[test]
fn a_mirror_shows_the_room() {
    let frame = BALL.frame();
    let errors_at = |height: usize| {
        let color = mirrored(&frame, &around(&BALL, height), &Run::new());
        let errors = covered(&frame.mask).map(|(x, y)| {
            let (point, _) = BALL.hit(middle(x, y)).unwrap();
            let pairs = of(&color, x, y).into_iter().zip(paint(point - CENTER));
            largest(pairs.map(|(found, expected)| (found - expected).abs().into()))
        });
        let errors = sorted(errors);
        (quantile(&errors, 0.5), quantile(&errors, 1.0))
    };
    // Colour is linear between texels: of second order in their size.
    let (coarse, fine) = (errors_at(128), errors_at(256));
    assert!(
        coarse.0 / fine.0 > 3.0 && fine.1 < 0.02,
        "{coarse:?} {fine:?}"
    );
}

#[test]
fn glass_shows_what_it_lets_through_and_what_it_mirrors() {
    let glass = Scene {
        thing: Thing::GlassBall,
        ..BALL
    };
    let frame = glass.frame();
    let scene = SpecularScene {
        back: Some(glass.back()),
        ..around(&glass, 256)
    };
    let plain = params(Material::Glass, Method::Plain, |_| ());
    let color = relit(&frame, &scene, plain, &Run::new());
    let mut errors = Vec::new();
    for (x, y) in covered(&frame.mask) {
        let at = middle(x, y);
        let [through, mirrored] = [glass, BALL].map(|scene| scene.hit(at).unwrap().0);
        let sight = glass.sight().line(at.x, at.y).1.normalize();
        let share = fresnel(-frame.normal.at(x, y).dot(sight) as f32, IOR as f32);
        let [a, b] = [through, mirrored].map(|point| paint(point - CENTER));
        for (k, found) in of(&color, x, y).into_iter().enumerate() {
            let expected = share * b[k] + (1.0 - share) * a[k];
            errors.push(f64::from((found - expected).abs()));
        }
    }
    // At the rim, where rays turn fast, the back is known only by texels a pixel apart.
    let p99 = quantile(&sorted(errors), 0.99);
    assert!(p99 < 0.02, "{p99}");
}

#[test]
fn strengths_of_0_are_plain_and_others_are_not() {
    let (frame, scene) = (BALL.frame(), around(&BALL, 256));
    let plain = mirrored(&frame, &scene, &Run::new());
    let idle = params(Material::Mirror, Method::Both, |params| {
        (params.relight.warping.warp, params.relight.warping.contrast) = (0.0, 0.0);
        params.scaling.scaling = 0.0;
    });
    assert_eq!(relit(&frame, &scene, idle, &Run::new()), plain);
    for method in [Method::Warp, Method::Scale, Method::Both] {
        let params = params(Material::Mirror, method, |_| ());
        let altered = relit(&frame, &scene, params, &Run::new());
        let most = apart(&altered.r, &plain.r);
        assert!(most > 0.02, "{method:?}: {most}");
        assert!(altered.r.samples().iter().all(|v| v.is_finite()));
    }
}

#[test]
fn what_is_no_mirror_keeps_its_picture() {
    let frame = grey(BALL.frame(), 0.25);
    let mut scene = around(&BALL, 256);
    scene.mask = Some(Mask::new(Plane::from_fn(96, 96, |x, _| x < 48)));
    let color = mirrored(&frame, &scene, &Run::new());
    for (x, y) in places(96, 96) {
        let is_mirror = x < 48 && frame.mask.at(x, y);
        let kept = of(&color, x, y) == [0.25; 3];
        assert!(kept != is_mirror, "{x} {y}");
    }
}
