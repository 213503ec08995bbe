//! Mirrors and lenses at their extremes: a drawing, never a NaN, and the same one for any number of threads.

use super::exact::{Scene, Thing};
use super::{drawing, fields};
use crate::prelude::*;
use relievo::engine;
use std::sync::Arc;

const GLASS: Scene = Scene {
    thing: Thing::GlassBall,
    size: 64,
    focal: 100.0,
};

fn both() -> LineParams {
    LineParams {
        directions: StrokeDirections::Both,
        ..LineParams::default()
    }
}

fn drawn(frame: &Frame, scene: &SpecularScene, params: LineParams, bend: Bend) -> Drawing {
    let light = Illumination {
        directional: vec![DirectionalLight {
            to_light: glam::Vec3::Z,
            intensity: [1.0; 3],
        }],
        ..Illumination::default()
    };
    let inputs = PlanInputs {
        illumination: Some(&light),
        specular: Some(scene),
        ..PlanInputs::default()
    };
    let plan = drawing(frame, params, bend);
    cpu::execute(&plan, frame, inputs).unwrap().drawing.unwrap()
}

fn glass() -> SpecularScene {
    SpecularScene {
        back: Some(GLASS.back()),
        behind: Some(GLASS.behind()),
        surroundings: Some(Arc::new(GLASS.surroundings(32))),
        ..SpecularScene::default()
    }
}

const REFRACTED: Bend = Bend::Glass { ior: 1.5 };

#[test]
fn every_scene_gives_a_drawing() {
    let frame = GLASS.frame();
    let nothing = |plane: &Plane| plane.map(|_| 0.0);
    let mut void = GLASS.surroundings(16);
    void.points = Vector3Planes {
        x: nothing(&void.points.x),
        y: nothing(&void.points.y),
        z: nothing(&void.points.z),
    };
    let void = SpecularScene {
        surroundings: Some(Arc::new(void)),
        ..SpecularScene::default()
    };
    let empty = SpecularScene {
        mask: Some(Mask::new(Plane::filled(64, 64, false))),
        ..glass()
    };
    let mut nowhere = GLASS.behind();
    nowhere.mask = Mask::new(Plane::filled(64, 64, false));
    let nowhere = SpecularScene {
        behind: Some(nowhere),
        ..SpecularScene::default()
    };
    let given = |value: DVec3| SpecularScene {
        hit_position: Some(Vector3Planes {
            x: Plane::filled(64, 64, value.x as f32),
            y: Plane::filled(64, 64, value.y as f32),
            z: Plane::filled(64, 64, value.z as f32),
        }),
        ..SpecularScene::default()
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
    assert!(is_a_drawing(&drawn(
        &frame.crop(part),
        &cut,
        both(),
        REFRACTED
    )));
    // Away from the cut, where steps are one-sided, patches are the same.
    let mut same = (0, 0);
    for y in 0..64 {
        for x in (0..16).filter(|&x| frame.mask.at(x, y)) {
            let dot = whole.x.at(x, y) * half.x.at(x, y) + whole.y.at(x, y) * half.y.at(x, y);
            same.0 += u32::from(dot.abs() > 0.999);
            same.1 += 1;
        }
    }
    assert!(
        same.1 > 100 && f64::from(same.0) > 0.9 * f64::from(same.1),
        "{same:?}"
    );
    for [width, height] in [[1, 1], [1, 64], [64, 1]] {
        let middle = Window::at(32, 32, 1, 1);
        let window = Window::at(
            if width == 1 { middle.x0 } else { 0 },
            if height == 1 { middle.y0 } else { 0 },
            width,
            height,
        );
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
    let params = LineParams {
        field: FieldParams {
            fallback: Fallback::Angle(20.0),
            ..FieldParams::default()
        },
        ..LineParams::default()
    };
    let none = SpecularScene {
        mask: Some(Mask::new(Plane::filled(64, 64, false))),
        ..glass()
    };
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let available = Available::in_frame(&frame);
    let plan = Plan::new(Goal::LAYERS, available, shape, scaling).unwrap();
    let inputs = engine::PlanInputs::default();
    let alone = Engine::cpu().stroke_fields(&plan, &frame, inputs, &params);
    let alone = alone.unwrap();
    assert_eq!(fields(&frame, &none, params, Bend::Mirror), alone);
}
