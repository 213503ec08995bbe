//! Mirrors and glass in new light: they show the hits of their sight lines, scaled and warped like other light.

use super::exact::{CENTER, IOR, Scene, Thing};
use super::traced;
use crate::prelude::*;
use relievo::light::brdf::fresnel;
use relievo::light::lights::LightKinds;
use std::sync::Arc;

/// A smooth colour of the room, by the point from its middle.
fn paint(p: DVec3) -> [f32; 3] {
    let wave = |v: f64| (0.5 + 0.3 * (0.7 * v).sin()) as f32;
    [wave(p.x + p.y), wave(p.y - p.z), wave(p.z + 0.5 * p.x)]
}

fn around(scene: &Scene, height: usize) -> SpecularScene {
    let mut map = scene.surroundings(height);
    let view_from_world = scene.camera().view_from_world;
    let plane = |k: usize| {
        Plane::from_fn(map.width(), map.height(), |x, y| {
            paint(view_from_world.transform_vector3(map.point_at(x, y)))[k]
        })
    };
    map.color = Some(ColorPlanes {
        r: plane(0),
        g: plane(1),
        b: plane(2),
    });
    SpecularScene {
        surroundings: Some(Arc::new(map)),
        ..SpecularScene::default()
    }
}

/// A mirror over half of a ball's picture, in a region across its border: the samples of the whole.
#[test]
fn a_region_of_a_mirror_is_that_part_of_the_whole() {
    let (frame, window) = (BALL.frame(), BALL.frame().data_window);
    let scene = SpecularScene {
        mask: Some(Mask::new(Plane::from_fn(96, 96, |x, y| x + y < 96))),
        ..around(&BALL, 64)
    };
    let light = Illumination::default();
    let request = Request::relight(
        Params {
            relight: params(Material::Mirror, Method::Plain),
            ..Params::default()
        },
        &light,
    );
    let request = request.specular(&scene, traced(Bend::Mirror));
    let engine = Engine::cpu();
    let whole = engine.run(&request, &frame, &Run::new()).unwrap();
    let region = Window::at(window.x0 + 31, window.y0 + 26, 37, 29);
    let part = engine.run(&request, &frame, &Run::new().region(region));
    let (part, whole) = (part.unwrap().color.unwrap(), whole.color.unwrap());
    for (part, whole) in [
        (&part.r, &whole.r),
        (&part.g, &whole.g),
        (&part.b, &whole.b),
    ] {
        assert_eq!(bits(part), bits(&whole.crop(window, region)));
    }
    assert!(part.r.samples().iter().any(|&red| red > 0.3));
}

fn relit(
    frame: &Frame,
    scene: &SpecularScene,
    params: RelightParams,
    scaling: ScalingParams,
) -> ColorPlanes {
    let bend = match params.material.material {
        Material::Glass => Bend::Glass {
            ior: params.material.ior,
        },
        _ => Bend::Mirror,
    };
    let available = Available {
        specular: Some(traced(bend)),
        ..Available::in_frame(frame)
    };
    let kinds = LightKinds::default();
    let plan = Plan::new(
        Goal::Relight(params),
        Available {
            new_light: kinds,
            ..available
        },
        ShapeParams::default(),
        scaling,
    )
    .unwrap();
    let light = Illumination::default();
    let inputs = PlanInputs {
        specular: Some(scene),
        ..PlanInputs::lit_by(&light)
    };
    let outcome = cpu::execute(&plan, frame, inputs).unwrap();
    outcome.color.unwrap()
}

fn params(material: Material, method: Method) -> RelightParams {
    let mut params = RelightParams {
        method,
        ..RelightParams::default()
    };
    params.material.material = material;
    params.material.ior = IOR as f32;
    params
}

fn of(color: &ColorPlanes, x: usize, y: usize) -> [f32; 3] {
    [&color.r, &color.g, &color.b].map(|plane| plane.at(x, y))
}

const BALL: Scene = Scene {
    thing: Thing::MirrorBall,
    size: 96,
    focal: 140.0,
};

#[test]
fn a_mirror_shows_the_room() {
    let frame = BALL.frame();
    let errors_at = |height: usize| {
        let scene = around(&BALL, height);
        let color = relit(
            &frame,
            &scene,
            params(Material::Mirror, Method::Plain),
            ScalingParams::default(),
        );
        let mut errors = Vec::new();
        for y in 0..96 {
            for x in frame.mask.runs(y).flatten() {
                let at = DVec2::new(x as f64, y as f64) + 0.5;
                let (point, _) = BALL.hit(at).unwrap();
                let expected = paint(point - CENTER);
                let off = of(&color, x, y).into_iter().zip(expected);
                errors.push(off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max));
            }
        }
        errors.sort_by(f32::total_cmp);
        let [median, most] = [errors[errors.len() / 2], errors[errors.len() - 1]];
        println!("mirror, a map {height} pixels high: median error {median}, largest {most}");
        (median, most)
    };
    // Colour is linear between texels: of second order in their size.
    let (coarse, fine) = (errors_at(128), errors_at(256));
    assert!(coarse.0 / fine.0 > 3.0 && fine.1 < 0.02);
}

#[test]
fn glass_shows_what_it_lets_through_and_what_it_mirrors() {
    let scene_of = Scene {
        thing: Thing::GlassBall,
        ..BALL
    };
    let frame = scene_of.frame();
    let scene = SpecularScene {
        back: Some(scene_of.back()),
        ..around(&scene_of, 256)
    };
    let color = relit(
        &frame,
        &scene,
        params(Material::Glass, Method::Plain),
        ScalingParams::default(),
    );
    let mut errors = Vec::new();
    for y in 0..96 {
        for x in frame.mask.runs(y).flatten() {
            let at = DVec2::new(x as f64, y as f64) + 0.5;
            let (through, _) = scene_of.hit(at).unwrap();
            let (mirrored, _) = BALL.hit(at).unwrap();
            let n = DVec3::new(
                frame.normal.x.at(x, y).into(),
                frame.normal.y.at(x, y).into(),
                frame.normal.z.at(x, y).into(),
            );
            let sight = scene_of.sight().line(at.x, at.y).1.normalize();
            let share = fresnel(-n.dot(sight) as f32, IOR as f32);
            let (a, b) = (paint(through - CENTER), paint(mirrored - CENTER));
            for (k, found) in of(&color, x, y).into_iter().enumerate() {
                errors.push((found - (share * b[k] + (1.0 - share) * a[k])).abs());
            }
        }
    }
    errors.sort_by(f32::total_cmp);
    let p99 = errors[errors.len() * 99 / 100];
    println!("glass: 99 % within {p99}");
    // At the rim, where rays turn fast, the back is known only by texels a pixel apart.
    assert!(p99 < 0.02);
}

#[test]
fn strengths_of_0_are_plain_and_others_are_not() {
    let (frame, scene) = (BALL.frame(), around(&BALL, 256));
    let plain = relit(
        &frame,
        &scene,
        params(Material::Mirror, Method::Plain),
        ScalingParams::default(),
    );
    let mut idle = params(Material::Mirror, Method::Both);
    idle.warping = WarpingParams {
        warp: 0.0,
        contrast: 0.0,
    };
    let still = ScalingParams {
        scaling: 0.0,
        ..ScalingParams::default()
    };
    assert_eq!(relit(&frame, &scene, idle, still), plain);
    for method in [Method::Warp, Method::Scale, Method::Both] {
        let altered = relit(
            &frame,
            &scene,
            params(Material::Mirror, method),
            ScalingParams::default(),
        );
        let changed = altered.r.samples().iter().zip(plain.r.samples());
        let most = changed.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(most > 0.02, "{method:?}: {most}");
        assert!(altered.r.samples().iter().all(|v| v.is_finite()));
    }
}

#[test]
fn what_is_no_mirror_keeps_its_picture() {
    let mut frame = BALL.frame();
    let grey = Plane::filled(96, 96, 0.25);
    frame.color = Some(ColorPlanes {
        r: grey.clone(),
        g: grey.clone(),
        b: grey,
    });
    let mut scene = around(&BALL, 256);
    let left = Plane::from_fn(96, 96, |x, _| x < 48);
    scene.mask = Some(relievo::frame::Mask::new(left));
    let color = relit(
        &frame,
        &scene,
        params(Material::Mirror, Method::Plain),
        ScalingParams::default(),
    );
    for y in 0..96 {
        for x in 0..96 {
            let is_mirror = x < 48 && frame.mask.at(x, y);
            let kept = of(&color, x, y) == [0.25; 3];
            assert!(kept != is_mirror, "{x} {y}");
        }
    }
}
