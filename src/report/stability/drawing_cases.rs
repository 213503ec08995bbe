//! The list of cases, continued: everything that could break a drawing.

use super::case::{case, cases};
use super::frames::random;
use super::{Case, Expected, Verdict};
use crate::Result;
use crate::engine::Inputs;
use crate::frame::Frame;
use crate::params::{
    Adaptive, FieldParams, LineParams, ScalingParams, ShapeParams, StrokeDirections, StrokeParams,
    StrokeScale, Style, ToneParams,
};
use crate::plan::{Available, Plan, ToneFrom};
use crate::report::engine;
use crate::report::scenes::Scene;
use crate::report::scenes::frames::{grey, masked};

/// All cases of drawings.
pub(super) fn all() -> Vec<Case> {
    let settings = settings().into_iter().map(Setting::case).collect();
    [surfaces(), tones(), sizes(), settings, refusals()]
        .into_iter()
        .flatten()
        .collect()
}

/// Any ink, for half tones with few strokes on a small picture.
const ANY: [f64; 2] = [0.0, 1.0];
/// Ink of a half tone over many strokes.
const HALF: [f64; 2] = [0.47, 0.53];
const NONE: [f64; 2] = [0.0, 0.0];
const ALL: [f64; 2] = [1.0, 1.0];

fn ball(tone: f32) -> Frame {
    grey(Scene::ball(200, 200).frame, tone)
}

fn plane(tone: f32) -> Frame {
    grey(Scene::plane(200, 200).frame, tone)
}

fn drawn(
    name: &'static str,
    done: &'static str,
    frame: impl Fn() -> Frame + 'static,
    line: LineParams,
    ink: [f64; 2],
) -> Case {
    case(name, done, Expected::Drawn, move || {
        judged(&frame(), line, ink)
    })
}

/// Crossed strokes, since two families can fail in more ways than one; the picture is the tone.
fn crossed() -> LineParams {
    LineParams {
        directions: StrokeDirections::Both,
        tone: ToneParams {
            white_point: Adaptive::Fixed(1.0),
            black_point: 0.0,
            gamma: 1.0,
            ..ToneParams::default()
        },
        ..LineParams::default()
    }
}

fn with(change: impl Fn(&mut LineParams)) -> LineParams {
    let mut line = crossed();
    change(&mut line);
    line
}

fn strokes(change: impl Fn(&mut StrokeParams)) -> LineParams {
    with(|line| change(&mut line.strokes))
}

fn surfaces() -> Vec<Case> {
    cases! {
        drawn("drawing of umbilics", "a ball: no direction anywhere", || ball(0.5), crossed(), HALF);
        drawn("drawing of a plane", "no curvature anywhere", || plane(0.5), crossed(), HALF);
        drawn("drawing of noise", "random unit normals", || grey(random(200, 200)(), 0.5), crossed(), ANY);
        drawn("drawing without passes", "on a ball, nothing averaged", || ball(0.5),
            with(|line| line.field.passes = 0), HALF);
    }
}

fn tones() -> Vec<Case> {
    let named = |name, done, tone: f32, ink| drawn(name, done, move || ball(tone), crossed(), ink);
    cases! {
        named("drawing of black", "tone 0 everywhere", 0.0, ALL);
        named("drawing of white", "tone 1 everywhere", 1.0, NONE);
        named("drawing of light", "a picture of 3e38", 3e38, NONE);
        named("drawing of infinity", "an infinite picture", f32::INFINITY, NONE);
        named("drawing of a debt", "a picture of -1", -1.0, ALL);
        named("drawing of NaN", "a picture of no numbers", f32::NAN, ALL);
        drawn("drawing of auto black", "the white point of a black picture", || ball(0.0),
            with(|line| line.tone.white_point = Adaptive::Auto), ALL);
    }
}

fn sizes() -> Vec<Case> {
    let sized = |width, height| move || grey(Scene::plane(width, height).frame, 0.5);
    cases! {
        drawn("drawing of nothing", "no pixel covered", || masked(ball(0.5), |_, _| false), crossed(), NONE);
        drawn("drawing of one pixel", "of 200x200", || masked(ball(0.5), |x, y| (x, y) == (100, 100)), crossed(),
            ANY);
        drawn("drawing of 1x1", "one pixel in all", sized(1, 1), crossed(), ANY);
        drawn("drawing of 1xN", "a column of 300", sized(1, 300), crossed(), ANY);
        drawn("drawing of Nx1", "a row of 300", sized(300, 1), crossed(), ANY);
    }
}

/// A setting and the surface that exercises it.
struct Setting {
    name: &'static str,
    done: &'static str,
    surface: fn(f32) -> Frame,
    line: LineParams,
    ink: [f64; 2],
}

impl Setting {
    fn case(self) -> Case {
        let frame = move || (self.surface)(0.5);
        drawn(self.name, self.done, frame, self.line, self.ink)
    }
}

fn settings() -> Vec<Setting> {
    let on = |surface, name, done, line, ink| Setting {
        name,
        done,
        surface,
        line,
        ink,
    };
    let on_plane = |name, done, line, ink| on(plane, name, done, line, ink);
    let on_ball = |name, done, line, ink| on(ball, name, done, line, ink);
    let scale = |factor| strokes(|s| s.scale = StrokeScale::Factor(factor));
    cases! {
        on_ball("strokes of scale 0.1", "a sixth of a pixel wide", scale(0.1), HALF);
        on_ball("strokes of scale 500", "each wider than the picture", scale(500.0), ANY);
        on_ball("lines of scale 0.1", "an eighth of a pixel wide",
            strokes(|s| (s.style, s.scale) = (Style::Lines, StrokeScale::Factor(0.1))), ANY);
        on_ball("lines of scale 500", "each wider than the picture",
            strokes(|s| (s.style, s.scale) = (Style::Lines, StrokeScale::Factor(500.0))), ANY);
        on_ball("1 level", "one angle for all", strokes(|s| s.levels = 1), HALF);
        on_ball("360 levels", "half a degree apart", strokes(|s| s.levels = 360), HALF);
        on_ball("8 sets of 360 levels", "the most there are", strokes(|s| (s.levels, s.sets) = (360, 8)), HALF);
        on_plane("pencil pressed hard", "pressure 1, wobble 1",
            strokes(|s| { (s.style, s.pressure, s.wobble) = (Style::Pencil, Some(1.0), Some(1.0)); }), HALF);
        on_plane("hairs far apart", "0.05 px wide, 1000 px apart",
            strokes(|s| { (s.width_px, s.spacing_px) = (Some(0.05), Some(1000.0)); }), ANY);
        on_plane("dots for strokes", "100 px wide, 1 px long",
            strokes(|s| { (s.width_px, s.length_px) = (Some(100.0), Some(1.0)); }), ANY);
        on_ball("field as fine as the picture", "and 6 passes of 64 px",
            with(|line| { line.field = FieldParams { cell_px: 1, passes: 6, radius_px: 64.0, ..line.field }; }),
            HALF);
    }
}

fn refusals() -> Vec<Case> {
    let refused = |name, done, line: LineParams| {
        case(name, done, Expected::Refused, move || {
            judged(&ball(0.5), line, ANY)
        })
    };
    cases! {
        refused("0 levels", "less than one", strokes(|s| s.levels = 0));
        refused("361 levels", "more than there are", strokes(|s| s.levels = 361));
        refused("strokes of scale 0", "no size", strokes(|s| s.scale = StrokeScale::Factor(0.0)));
        refused("strokes of NaN mm", "no number", strokes(|s| s.scale = StrokeScale::Millimetres(f32::NAN)));
        case("drawing without a picture", "and without light", Expected::Refused,
            || judged(&Scene::ball(40, 40).frame, crossed(), ANY));
    }
}

/// Draws `frame` in the tone of its picture, and checks the ink of its strokes against `bounds`.
fn judged(frame: &Frame, line: LineParams, bounds: [f64; 2]) -> Result<Verdict> {
    let plan = Plan::hatch(
        Available::in_frame(frame),
        ShapeParams::default(),
        ScalingParams::default(),
        ToneFrom::Picture,
        line,
    )?;
    let outcome = engine::run(&plan, frame, Inputs::default())?;
    let drawing = outcome.drawing.expect("a drawing was planned");
    let layers = drawing.layers();
    let mut samples = layers.into_iter().flat_map(|plane| plane.samples());
    if let Some(wrong) = samples.find(|v| !(0.0..=1.0).contains(*v)) {
        return Ok(Verdict::Failed {
            what: format!("ink is {wrong}, which should be 0 to 1"),
        });
    }
    let covered = drawing
        .hatching
        .samples()
        .iter()
        .zip(frame.mask.plane().samples());
    let covered = covered.filter(|(_, covered)| **covered);
    let ink = covered.fold(0.0, |sum, (&ink, _)| sum + f64::from(ink));
    let ink = ink / frame.mask.count().max(1) as f64;
    Ok(if (bounds[0]..=bounds[1]).contains(&ink) {
        Verdict::Drawn { ink, bounds }
    } else {
        Verdict::Failed {
            what: format!(
                "ink is {ink}, which should be {} to {}",
                bounds[0], bounds[1]
            ),
        }
    })
}
