//! Renders and a photo drawn by `relievo hatch`: the contact sheet in the README.
//!
//! `cargo run --release -p examples --example drawing_sheet -- OUT.png`, from the folder that holds `fixtures`.

mod common;

use common::{light_from, load};
use relievo::engine::{Engine, Request, Run};
use relievo::frame::{Frame, Plane};
use relievo::light::lights::Illumination;
use relievo::line::paper::on_paper;
use relievo::params::{
    AlbedoSource, LineParams, Method, RelightParams, ScalingParams, ShapeParams, Style,
};
use relievo::plan::Tone;
use std::error::Error;
use std::process::ExitCode;

/// Size of a drawing on the sheet; larger ones are cropped around their centre.
const CELL: [usize; 2] = [480, 360];

fn main() -> ExitCode {
    common::exit(run())
}

fn run() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1);
    let output = output.ok_or("usage: drawing_sheet OUT.png")?;
    let bust = load("fixtures/bust.exr", None)?;
    let gears = load("fixtures/gears.exr", None)?;
    let tablet = load(
        "fixtures/tablet.color.jpg",
        Some("fixtures/tablet.normal.png"),
    )?;
    let pen = LineParams::default();
    let mut pencil = pen;
    pencil.strokes.style = Style::Pencil;
    let lamp = light_from(135.0, 35.0);
    let drawings = [
        drawn(&bust, pen, None)?,
        drawn(&bust, pencil, None)?,
        drawn(&gears, pen, Some(&lamp))?,
        drawn(&tablet, pen, Some(&lamp))?,
    ];
    let [width, height] = CELL;
    let sheet = Plane::from_fn(2 * width, 2 * height, |x, y| {
        let drawing = &drawings[x / width + 2 * (y / height)];
        within(drawing, x % width, y % height)
    });
    common::write(&output, &on_paper(&[&sheet]))?;
    Ok(())
}

/// The ink of a drawing in a tone that shows the shape, with the picture's light or with new light that warps.
fn drawn(
    frame: &Frame,
    line: LineParams,
    light: Option<&Illumination>,
) -> Result<Plane, Box<dyn Error>> {
    let relight = RelightParams {
        method: Method::Both,
        albedo: AlbedoSource::White,
        ..RelightParams::default()
    };
    let tone = Tone::Shape(light.map(|_| relight));
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let mut request = Request::hatch(shape, scaling, tone, line);
    request.inputs.illumination = light;
    let drawing = Engine::cpu().run(&request, frame, &Run::new())?.drawing;
    let drawing = drawing.ok_or("no drawing was made")?;
    let white = on_paper(&[
        &drawing.hatching,
        drawing.contours.as_ref().ok_or("no lines")?,
    ]);
    Ok(white.r.map(|white| 1.0 - white))
}

/// A pixel of the middle of a picture; nothing beyond it.
fn within(ink: &Plane, x: usize, y: usize) -> f32 {
    let at = |i: usize, cell: usize, size: usize| (i + size / 2).checked_sub(cell / 2);
    let x = at(x, CELL[0], ink.width()).filter(|&x| x < ink.width());
    let y = at(y, CELL[1], ink.height()).filter(|&y| y < ink.height());
    match (x, y) {
        (Some(x), Some(y)) => ink.at(x, y),
        _ => 0.0,
    }
}
