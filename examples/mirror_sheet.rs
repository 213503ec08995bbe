//! A mirror in a hall, rendered, relit and drawn without and with its reflections: the sheet in the guide.
//!
//! `cargo run --release -p examples --example mirror_sheet -- OUT.png`, from the folder that holds `fixtures`.

mod common;

use common::Outcome;
use relievo::engine::{Engine, Request, Run};
use relievo::frame::{ColorPlanes, SpecularScene};
use relievo::io::inputs::Inputs;
use relievo::io::{self, Needs, SpecularInputs, load_specular};
use relievo::light::lights::Illumination;
use relievo::line::paper::on_paper;
use relievo::params::{
    Bend, LineParams, Material, Params, SearchParams, SpecularParams, StrokeDirections,
    StrokeScale, Style,
};
use relievo::plan::{Goal, Tone};
use std::process::ExitCode;

fn main() -> ExitCode {
    common::run(|arguments| match arguments {
        [output] => sheet(output),
        _ => Err("usage: mirror_sheet OUT.png".into()),
    })
}

fn sheet(output: &str) -> Outcome<()> {
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
    let made = |request: &Request| Engine::cpu().run(request, &frame, &Run::new());
    let light = Illumination::default();
    let mut params = Params::default();
    params.relight.material.material = Material::Mirror;
    let relit = made(&traced(Request::relight(params, &light), &scene))?;
    let mut line = LineParams {
        directions: StrokeDirections::Max,
        interior: None,
        ..LineParams::default()
    };
    line.strokes.style = Style::Pen;
    line.strokes.scale = StrokeScale::Factor(0.5);
    let drawing = Request::new(Goal::Hatch(Tone::Enhanced, line), Params::default());
    let drawn = |request: &Request| -> relievo::Result<ColorPlanes> {
        let drawing = made(request)?.drawing.expect("a drawing is planned");
        Ok(on_paper(&drawing.layers()))
    };
    let pictures = [
        frame.color.clone().ok_or("no picture")?,
        relit.color.expect("light makes a picture"),
        drawn(&drawing)?,
        drawn(&traced(drawing.clone(), &scene))?,
    ];
    common::write(output, &common::grid(&pictures, 2))?;
    Ok(())
}

/// The request, with sight lines followed.
fn traced<'a>(request: Request<'a>, scene: &'a SpecularScene) -> Request<'a> {
    let bend = Bend::Mirror;
    let search = SearchParams::default();
    request.specular(scene, SpecularParams { bend, search })
}
