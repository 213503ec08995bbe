//! A mirror in a hall, rendered, relit and drawn without and with its reflections: the sheet in the guide.
//!
//! `cargo run --release -p examples --example mirror_sheet -- OUT.png`, from the folder that holds `fixtures`.

mod common;

use relievo::engine::{Engine, Request, Run};
use relievo::frame::{ColorPlanes, Frame, SpecularScene};
use relievo::io::inputs::Inputs;
use relievo::io::{self, Needs, SpecularInputs, load_specular};
use relievo::light::lights::Illumination;
use relievo::line::paper::on_paper;
use relievo::params::{
    Bend, LineParams, Material, Params, RelightParams, ScalingParams, SearchParams, ShapeParams,
    SpecularParams, StrokeDirections, StrokeScale,
};
use relievo::plan::{Goal, Tone};
use std::error::Error;
use std::process::ExitCode;

fn main() -> ExitCode {
    common::exit(run())
}

fn run() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1);
    let output = output.ok_or("usage: mirror_sheet OUT.png")?;
    let inputs = Inputs {
        picture: "fixtures/mirror.exr".into(),
        ..Inputs::default()
    };
    let needs = Needs {
        color: true,
        projection: true,
        ..Needs::default()
    };
    let loaded = io::load(&inputs, needs)?;
    let mirror = SpecularInputs {
        mask: Some("Mirror".into()),
        surroundings: Some("fixtures/mirror.surroundings.exr".into()),
        ..SpecularInputs::default()
    };
    let scene = load_specular(&mirror, &loaded, None)?;
    let frame = loaded.frame;
    let rendered = frame.color.clone().ok_or("no picture")?;
    let pictures = [
        rendered,
        relit(&frame, &scene)?,
        drawn(&frame, None)?,
        drawn(&frame, Some(&scene))?,
    ];
    common::write(&output, &common::grid(&pictures, 2))?;
    Ok(())
}

/// Settings for following sight lines.
fn traced() -> SpecularParams {
    SpecularParams {
        bend: Bend::Mirror,
        search: SearchParams::default(),
    }
}

/// The mirror in the light of its surroundings, warped and scaled.
fn relit(frame: &Frame, scene: &SpecularScene) -> relievo::Result<ColorPlanes> {
    let mut params = RelightParams::default();
    params.material.material = Material::Mirror;
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let light = Illumination::default();
    let request = Request::relight(
        Params {
            relight: params,
            ..Params::of(shape, scaling)
        },
        &light,
    )
    .specular(scene, traced());
    let outcome = Engine::cpu().run(&request, frame, &Run::new())?;
    Ok(outcome.color.expect("light makes a picture"))
}

fn drawn(frame: &Frame, scene: Option<&SpecularScene>) -> relievo::Result<ColorPlanes> {
    let mut line = LineParams {
        directions: StrokeDirections::Max,
        interior: None,
        ..LineParams::default()
    };
    line.strokes.scale = StrokeScale::Factor(0.5);
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let mut request = Request::new(
        Goal::Hatch(Tone::Enhanced, line),
        Params::of(shape, scaling),
    );
    if let Some(scene) = scene {
        request = request.specular(scene, traced());
    }
    let drawing = Engine::cpu().run(&request, frame, &Run::new())?.drawing;
    let drawing = drawing.expect("a drawing is planned");
    let layers: Vec<_> = std::iter::once(&drawing.hatching)
        .chain(&drawing.contours)
        .collect();
    Ok(on_paper(&layers))
}
