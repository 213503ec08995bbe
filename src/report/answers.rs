//! What the first page says about a frame: what there is to warn of, and how it looks before and after.

use super::asked::Asked;
use super::engine::{self, Inputs};
use super::numbers::scientific;
use super::sweeps::solver::{SceneSweep, SolverRow};
use super::timing;
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, confidence};
use crate::io::picture::{Picture, ViewTransform, pixels, small};
use crate::params::ScalingParams;
use crate::plan::{Available, Goal, Plan};
use crate::product::Product;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde::Serialize;

/// What the first page says.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Answers {
    /// Share of the surface that is brighter than white, before and after enhancing; `None` without a picture.
    pub brighter_than_white: Option<[f64; 2]>,
    /// Share of the surface at edges, where less than half of a slope spreads.
    pub at_edges: f64,
    /// Share of the surface whose pixels blend several surfaces.
    pub blended: f64,
    /// Whether the curvature gain was held for the sake of coarse normals.
    pub holds_gain: bool,
    /// What there is to warn of, each with what helps.
    pub warnings: Vec<String>,
    /// The picture before and after, and the curvature, side by side, as a PNG.
    #[serde(skip)]
    pub sheet: Option<Vec<u8>>,
}

/// Shares of the surface below these are nothing to warn of.
const BRIGHTER: f64 = 1e-3;
const AT_EDGES: f64 = 0.25;
const BLENDED: f64 = 0.01;

/// A picture with more of its surface brighter than white has no shading left there to scale.
const BURNT: f64 = 0.1;

/// Gradients that exceed their range before diffusion by more than this, relative to the steepest, are unstable.
const OVERSHOOT: f64 = 1e-3;

/// The longest side of each picture of the sheet, in pixels.
const LONGEST: usize = 480;

/// Looks at the frame for what there is to warn of. `swept` are the errors of its solvers.
pub(super) fn of(asked: &Asked, swept: &SceneSweep) -> Result<Answers> {
    let (frame, shape) = (asked.frame, asked.shape);
    let scaling = ScalingParams::default();
    let available = Available::in_frame(frame);
    let enhanced = match frame.color.is_some() {
        true => {
            let plan = Plan::new(Goal::Enhance, available, shape, scaling)?;
            engine::run(&plan, frame, Inputs::default())?.color
        }
        false => None,
    };
    let enhanced = enhanced.as_ref().or(frame.color.as_ref());
    let layers = timing::plan(Goal::Layers, frame, shape)?;
    let found = engine::run(&layers, frame, Inputs::default())?;
    let conductance = found.planes(Product::Conductance);
    let is_edge = |x: usize, y: usize| conductance.iter().any(|plane| plane.row(y)[x] < 0.5);
    let confidence = confidence(frame);
    let is_blended = |x: usize, y: usize| confidence.as_ref().is_some_and(|c| c.row(y)[x] < 0.5);
    let pictures = frame.color.as_ref().zip(enhanced);
    let mut answers = Answers {
        brighter_than_white: pictures.map(|(before, after)| {
            [before, after].map(|color| share(frame, |x, y| brightest(color, x, y) > 1.0))
        }),
        at_edges: share(frame, is_edge),
        blended: share(frame, is_blended),
        holds_gain: layers.holds_gain(found.gain),
        warnings: Vec::new(),
        sheet: None,
    };
    answers.warnings = warnings(&answers, frame, swept);
    if let Some((before, after)) = pictures {
        let plan = timing::plan(Goal::Display, frame, shape)?;
        let shown = engine::run(&plan, frame, Inputs::default())?;
        let curvature = shown.color.expect("a display was planned");
        answers.sheet = Some(sheet(&[
            (before, ViewTransform::Srgb),
            (after, ViewTransform::Srgb),
            (&curvature, ViewTransform::None),
        ]));
    }
    Ok(answers)
}

fn brightest(color: &ColorPlanes, x: usize, y: usize) -> f32 {
    let [r, g, b] = [&color.r, &color.g, &color.b].map(|plane| plane.row(y)[x]);
    r.max(g).max(b)
}

/// The share of the surface for which `holds` is true of a column and a row.
fn share(frame: &Frame, holds: impl Fn(usize, usize) -> bool) -> f64 {
    let mask = &frame.mask;
    let rows = 0..mask.height();
    let count: usize = rows
        .map(|y| mask.runs(y).flatten().filter(|&x| holds(x, y)).count())
        .sum();
    count as f64 / mask.count().max(1) as f64
}

fn warnings(answers: &Answers, frame: &Frame, swept: &SceneSweep) -> Vec<String> {
    let mut found = Vec::new();
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    if frame.mask.count() == 0 {
        found.push("no surface is seen: nothing below says anything".into());
    }
    if let Some([before, after]) = answers.brighter_than_white
        && (after > before + BRIGHTER || before > BURNT)
    {
        found.push(format!(
            "clipping: {} of the surface are brighter than white after `enhance`, {} before; pictures roll it off, and \
             `--exposure -0.5` or a lower `--scaling` avoids it",
            percent(after),
            percent(before)
        ));
    }
    if answers.at_edges > AT_EDGES {
        found.push(format!(
            "edges: {} of the surface are silhouettes or creases, across which no slope spreads; noise looks like that, and \
             higher `--crease` or `--silhouette` sees less of it",
            percent(answers.at_edges)
        ));
    }
    if answers.blended > BLENDED {
        found.push(format!(
            "blended samples: {} of the surface show several surfaces at once (blur, fog, fur); changes fade there, and \
             `--blur-fade 0` overrules that",
            percent(answers.blended)
        ));
    }
    if frame.source.normal_rounding > 1e-3 {
        let held = match answers.holds_gain {
            true => ", and the curvature gain is held below what the shape asks for",
            false => "",
        };
        found.push(format!(
            "8 bits: normals are rounded by {} of their length, which shows at small scales{held}; a map of 16 bits or floats \
             has no such steps",
            scientific(frame.source.normal_rounding.into())
        ));
    }
    let rows = swept
        .scales
        .iter()
        .flat_map(|scale| scale.rows.iter().map(move |row| (scale, row)));
    let unstable = |row: &SolverRow| {
        row.gradient.non_finite + row.trace.non_finite > 0 || row.overshoot > OVERSHOOT
    };
    for (scale, row) in rows.filter(|(_, row)| unstable(row)) {
        found.push(format!(
            "unstable: {} at {}: {} samples are not finite, and slopes exceed their range by {}",
            row.setting,
            scale.scale,
            row.gradient.non_finite + row.trace.non_finite,
            scientific(row.overshoot)
        ));
    }
    found
}

/// Pictures side by side, as a PNG.
fn sheet(pictures: &[(&ColorPlanes, ViewTransform)]) -> Vec<u8> {
    let shown = pictures.iter().map(|&(color, transform)| {
        let at = |x: usize, y: usize, c: usize| [&color.r, &color.g, &color.b][c].row(y)[x];
        let color = small([color.r.width(), color.r.height()], LONGEST, at);
        let width = color.r.width();
        let picture = Picture::of(&color, transform);
        (pixels(&picture), width)
    });
    let shown: Vec<_> = shown.collect();
    let width: usize = shown.iter().map(|(_, width)| width).sum();
    let height = shown
        .first()
        .map_or(0, |(pixels, width)| pixels.len() / width);
    let rows = (0..height).flat_map(|y| {
        let row = move |(pixels, width): &'_ (Vec<[u8; 4]>, usize)| {
            pixels[y * width..][..*width].to_vec()
        };
        shown.iter().flat_map(row)
    });
    let rgb: Vec<u8> = rows.flat_map(|[r, g, b, _]| [r, g, b]).collect();
    let mut png = Vec::new();
    let [width, height] = [width, height].map(|side| side as u32);
    PngEncoder::new(&mut png)
        .write_image(&rgb, width, height, ExtendedColorType::Rgb8)
        .expect("memory can be written to");
    png
}
