//! Drawings: strokes in the directions and the tone requested, independent of the machine.

mod background;
mod drawings;
mod halo;
mod stiff;
mod strokes;

use crate::prelude::*;
use relievo::line::hatching::{Hatching, Pixels};
use relievo::line::tonal_art_map::TonalArtMap;

const STYLES: [Style; 2] = [Style::Pen, Style::Pencil];

fn map(params: &StrokeParams) -> TonalArtMap {
    TonalArtMap::of_strokes(&params.stroke(1.0), params.style, params.seed)
}

/// White left of paper `width` by `height`, hatched along `angle`, in the tone `tone(x, y)`.
fn hatched(
    hatching: &Hatching,
    [width, height]: [usize; 2],
    angle: f32,
    tone: impl Fn(usize, usize) -> f32,
) -> Plane {
    let mut white = Plane::filled(width, height, 0.0);
    let mut pixels = Pixels::default();
    for y in 0..height {
        for (batch, row) in white.row_mut(y).chunks_mut(Pixels::MOST).enumerate() {
            pixels.count = row.len();
            for i in 0..row.len() {
                let x = batch * Pixels::MOST + i;
                pixels.place[0][i] = x as f32 + 0.5;
                pixels.place[1][i] = y as f32 + 0.5;
                pixels.angle[i] = angle;
                pixels.wanted[i] = -tone(x, y).ln();
                pixels.white[i] = 1.0;
            }
            pixels.share(0, 1);
            hatching.draw(&mut pixels);
            row.copy_from_slice(&pixels.white[..row.len()]);
        }
    }
    white
}

/// The direction, in degrees from the right counterclockwise, 0..180, along which a [`blurred`] plane changes least,
/// over the pixels of `part`: strokes run along it. From the sum of squared differences; of a plane that is not blurred
/// those between next neighbours favour some angles of thin lines.
fn stroke_angle(plane: &Plane, part: impl Fn(usize, usize) -> bool) -> f64 {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    // Of fourth order: the plain difference is low by a tenth where lines are six pixels apart.
    let slope =
        |near: [f32; 2], far: [f32; 2]| f64::from(8.0 * (near[1] - near[0]) - (far[1] - far[0]));
    for y in 2..plane.height() - 2 {
        for x in (2..plane.width() - 2).filter(|&x| part(x, y)) {
            let across = |i: usize| plane.at(x + i - 2, y);
            let up = |i: usize| plane.at(x, y + 2 - i);
            let gx = slope([across(1), across(3)], [across(0), across(4)]);
            let gy = slope([up(1), up(3)], [up(0), up(4)]);
            xx += gx * gx;
            xy += gx * gy;
            yy += gy * gy;
        }
    }
    // Most change at half the angle of (xx - yy, 2 xy); strokes across it.
    let most = 0.5 * f64::atan2(2.0 * xy, xx - yy);
    (most.to_degrees() + 90.0).rem_euclid(180.0)
}

/// Averaged over 3 x 3 pixels, six times: about a Gaussian of 2 pixels.
fn blurred(plane: &Plane) -> Plane {
    let (width, height) = (plane.width(), plane.height());
    let mut now = plane.clone();
    for _ in 0..6 {
        now = Plane::from_fn(width, height, |x, y| {
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let around: Vec<f32> = now.rows_within(columns, rows).flatten().copied().collect();
            around.iter().sum::<f32>() / around.len() as f32
        });
    }
    now
}

/// Difference of two directions, in degrees.
fn apart(a: f64, b: f64) -> f64 {
    ((a - b + 90.0).rem_euclid(180.0) - 90.0).abs()
}

/// A drawing of `frame` in the tone of its unprocessed picture.
fn drawing(frame: &Frame, line: LineParams) -> Drawing {
    drawn_by(&Engine::cpu(), frame, line)
}

fn drawn_by(engine: &Engine, frame: &Frame, line: LineParams) -> Drawing {
    let plan = cpu::plan(
        Goal::Hatch(Tone::Picture, line),
        frame,
        ShapeParams::default(),
    );
    let drawn = engine.execute(&plan.unwrap(), frame, PlanInputs::default(), &Run::new());
    let drawing = drawn.unwrap().drawing;
    drawing.expect("a drawing was planned")
}

/// Tone is luminance itself: white 1, no curve; strokes have their own size.
fn straight(mut line: LineParams) -> LineParams {
    line.tone.white_point = Adaptive::Fixed(1.0);
    line.tone.gamma = 1.0;
    if line.strokes.scale == StrokeScale::Auto {
        line.strokes.scale = StrokeScale::Factor(1.0);
    }
    line
}
