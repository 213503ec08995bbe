//! relievo reads the written layers without any flags.

use crate::enhancement::Enhancement;
use crate::layers::{Extras, write_layers};
use crate::path::{Direct, Tracing};
use crate::render::Job;
use crate::stage::{self, Setting};
use crate::urn::urn;
use relievo::engine::{Engine, Inputs as EngineInputs, Run};
use relievo::io::{self, Needs, inputs::Inputs};
use relievo::params::{ScalingParams, ShapeParams};
use relievo::plan::{Available, Goal, Plan};

#[test]
fn a_render_is_read_and_enhanced_without_a_flag() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("render.exr");
    let scene = stage::scene(Setting::Mirrors, urn(200, 160));
    let job = Job {
        scene: &scene,
        camera: stage::camera(Setting::Mirrors, [96, 72]),
        tracing: Tracing {
            enhancement: Enhancement::default(),
            direct: Direct::Both,
            max_bounces: 6,
        },
        samples: 4,
        seed: 1,
    };
    let extras = Extras {
        hit_positions: true,
        ambient_reach: 2.0,
    };
    write_layers(&path, &job, extras).unwrap();

    // Normals are in world space: converting them to view space needs the camera, recovered from the positions.
    let inputs = Inputs {
        picture: path,
        ..Inputs::default()
    };
    let needs = Needs {
        color: true,
        albedo: true,
        ..Needs::default()
    };
    let loaded = io::load(&inputs, needs).unwrap();
    let frame = &loaded.frame;
    let middles = job.middles();
    let camera = frame.camera.as_ref().expect("the camera is recovered");
    for (i, middle) in middles.iter().enumerate() {
        let Some(middle) = middle else { continue };
        let (x, y) = (i % 96, i / 96);
        let expected = camera
            .view_from_world
            .transform_vector3(middle.normal.as_dvec3());
        let found = glam::DVec3::new(
            frame.normal.x.at(x, y).into(),
            frame.normal.y.at(x, y).into(),
            frame.normal.z.at(x, y).into(),
        );
        assert!(
            (found - expected).length() < 1e-4,
            "{x}, {y}: {found}, not {expected}"
        );
        // Depth and position agree: both are of the middle.
        let depth = -camera
            .view_from_world
            .transform_point3(middle.position.as_dvec3())
            .z;
        assert!(
            (depth / f64::from(middle.depth) - 1.0).abs() < 1e-4,
            "{depth} {}",
            middle.depth
        );
    }
    let seen_by_way = middles.iter().flatten().filter(|m| m.seen_by_way.is_some());
    assert!(
        seen_by_way.count() > 100,
        "mirrors show the urn and the table"
    );
    let plan = Plan::new(
        Goal::Enhance,
        Available::in_frame(frame),
        ShapeParams::default(),
        ScalingParams::default(),
    )
    .unwrap();
    let color = Engine::cpu()
        .execute(&plan, frame, EngineInputs::default(), &Run::new())
        .unwrap()
        .color
        .expect("enhancing gives a picture");
    assert!(color.r.samples().iter().all(|v| v.is_finite()));
}
