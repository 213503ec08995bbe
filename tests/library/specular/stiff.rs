//! Mirrors and lenses at their extremes: a drawing, never a NaN, and the same one for any number of threads.

use super::exact::{Scene, Thing};
use super::*;

const GLASS: Scene = Scene {
    thing: Thing::GlassBall,
    size: 64,
    focal: 100.0,
};

fn both() -> LineParams {
    default_but(|line: &mut LineParams| line.directions = StrokeDirections::Both)
}

fn drawn(frame: &Frame, scene: &SpecularScene, params: LineParams, bend: Bend) -> Drawing {
    let light = lamp(0.0, 90.0);
    let inputs = PlanInputs {
        specular: Some(scene),
        ..PlanInputs::lit_by(&light)
    };
    let plan = drawing(frame, params, bend);
    cpu::execute(&plan, frame, inputs).unwrap().drawing.unwrap()
}

fn glass() -> SpecularScene {
    SpecularScene {
        back: Some(GLASS.back()),
        behind: Some(GLASS.behind()),
        ..within(GLASS.surroundings(32))
    }
}

#[test]
fn every_scene_gives_a_drawing() {
    let frame = GLASS.frame();
    let mut void = GLASS.surroundings(16);
    void.points = Vector3Planes::from_fn(void.width(), void.height(), |_, _| DVec3::ZERO);
    let void = within(void);
    let empty = SpecularScene {
        mask: Some(Mask::new(Plane::filled(64, 64, false))),
        ..glass()
    };
    let mut nowhere = GLASS.behind();
    nowhere.mask = Mask::new(Plane::filled(64, 64, false));
    let nowhere = default_but(|scene: &mut SpecularScene| scene.behind = Some(nowhere));
    let given = |value: DVec3| {
        let hits = Vector3Planes::from_fn(64, 64, |_, _| value);
        default_but(|scene: &mut SpecularScene| scene.hit_position = Some(hits))
    };
    let scenes = [
        ("glass", glass(), REFRACTED),
        ("mirror", glass(), Bend::Mirror),
        ("a thin sheet", glass(), Bend::Straight),
        // From a denser outside every steep sight line is totally reflected.
        ("all light mirrored", glass(), Bend::Glass { ior: 0.1 }),
        ("a very dense lens", glass(), Bend::Glass { ior: 10.0 }),
        ("no surroundings at all", void, Bend::Mirror),
        ("nothing behind", nowhere, Bend::Mirror),
        ("no mirror", empty, Bend::Mirror),
        ("hits that are no number", given(DVec3::NAN), Bend::Mirror),
        ("hits that are all one", given(DVec3::NEG_Z), Bend::Mirror),
        ("hits without end", given(DVec3::splat(1e30)), Bend::Mirror),
    ];
    for (name, scene, bend) in &scenes {
        assert!(is_a_drawing(&drawn(&frame, scene, both(), *bend)), "{name}");
    }
}

#[test]
fn a_lens_partly_outside_the_frame_is_drawn_as_in_the_whole() {
    let (frame, scene) = (GLASS.frame(), glass());
    let part = Window::at(0, 0, 34, 64);
    let cut = SpecularScene {
        back: scene.back.as_ref().map(|back| back.crop(part)),
        ..scene.clone()
    };
    let whole = &fields(&frame, &scene, both(), REFRACTED)[0];
    let half = &fields(&frame.crop(part), &cut, both(), REFRACTED)[0];
    let drawing = drawn(&frame.crop(part), &cut, both(), REFRACTED);
    assert!(is_a_drawing(&drawing));
    // Away from the cut, where steps are one-sided, patches are the same.
    let left = covered(&frame.mask).filter(|&(x, _)| x < 16);
    let cosines = left.map(|(x, y)| direction_at(whole, x, y).dot(direction_at(half, x, y)));
    let cosines = sorted(cosines.map(f64::abs));
    assert!(cosines.len() > 100 && quantile(&cosines, 0.1) > 0.999);
    for [x, y, width, height] in [[32, 32, 1, 1], [32, 0, 1, 64], [0, 32, 64, 1]] {
        let window = Window::at(x, y, width as usize, height as usize);
        let sliver = SpecularScene {
            back: scene.back.as_ref().map(|back| back.crop(window)),
            ..scene.clone()
        };
        let frame = frame.crop(window);
        assert!(is_a_drawing(&drawn(&frame, &sliver, both(), REFRACTED)));
    }
}

#[test]
fn threads_change_no_bit() {
    let (frame, scene) = (GLASS.frame(), glass());
    let by = |threads: usize| {
        on_threads(threads, || {
            drawn(&frame, &scene, both(), REFRACTED).hatching
        })
    };
    assert_eq!(by(1), by(3));
}

#[test]
fn a_scene_that_shows_nothing_is_drawn_as_without_it() {
    let frame = GLASS.frame();
    let params = default_but(|line: &mut LineParams| line.field.fallback = Fallback::Angle(20.0));
    let none = SpecularScene {
        mask: Some(Mask::new(Plane::filled(64, 64, false))),
        ..glass()
    };
    let plan = cpu::plan(Goal::LAYERS, &frame, ShapeParams::default()).unwrap();
    let alone = Engine::cpu().stroke_fields(&plan, &frame, PlanInputs::default(), &params);
    let alone = alone.unwrap();
    assert_eq!(fields(&frame, &none, params, Bend::Mirror), alone);
}
