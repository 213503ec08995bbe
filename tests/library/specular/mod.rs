//! Mirrors and lenses: hits of bent sight lines, apparent stroke directions, and relighting.

mod exact;
mod lens;
mod light;
mod propagation;
mod rendered;
mod stiff;

use crate::prelude::*;
use relievo::light::lights::LightKinds;
use std::sync::Arc;

const REFRACTED: Bend = Bend::Glass { ior: 1.5 };

/// The middle of a pixel.
fn middle(x: usize, y: usize) -> DVec2 {
    DVec2::new(x as f64, y as f64) + 0.5
}

/// A scene of surroundings alone.
fn within(surroundings: Surroundings) -> SpecularScene {
    default_but(|scene: &mut SpecularScene| scene.surroundings = Some(Arc::new(surroundings)))
}

/// The default search.
fn traced(bend: Bend) -> SpecularParams {
    SpecularParams {
        bend,
        search: SearchParams::default(),
    }
}

/// The plan of a drawing of `frame` under a lamp.
fn drawing(frame: &Frame, params: LineParams, bend: Bend) -> Plan {
    let available = Available {
        specular: Some(traced(bend)),
        new_light: LightKinds {
            directional: true,
            ..LightKinds::NONE
        },
        ..Available::in_frame(frame)
    };
    let tone = Tone::Relit(RelightParams::default());
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    Plan::new(Goal::Hatch(tone, params), available, shape, scaling).unwrap()
}

/// The stroke directions on the surfaces seen in a frame's specular pixels.
fn fields(
    frame: &Frame,
    scene: &SpecularScene,
    params: LineParams,
    bend: Bend,
) -> Vec<Vector2Planes> {
    let plan = drawing(frame, params, bend);
    let inputs = PlanInputs {
        specular: Some(scene),
        ..PlanInputs::default()
    };
    let fields = Engine::cpu().stroke_fields(&plan, frame, inputs, &params);
    fields.unwrap()
}
