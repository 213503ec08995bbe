//! Drawings: the tone of a picture in strokes along the curvature, and lines along its edges.

use crate::frame::{ColorPlanes, Frame, Plane};
use crate::line::density::{coverage_at, density_table};
use crate::line::streamlines::Streamline;
use crate::line::tone::{Densities, PictureDensities};
use crate::params::{Adaptive, LineParams, ToneParams};
use crate::plan::Plan;
use crate::plan::drawing::Drawing;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;
use crate::shape::auto_levels::cpu::white_level;

/// The verdict on a step of drawings.
pub(crate) fn is_drawn(plan: &Plan, decide: impl FnOnce(&LineParams) -> Verdict) -> Verdict {
    match &plan.drawing {
        Some(params) => decide(params),
        None => Verdict::left_out("no drawing is asked for"),
    }
}

/// The verdict on a step of strokes that come from a texture.
pub(crate) fn has_texture(plan: &Plan, decide: impl FnOnce(&LineParams) -> Verdict) -> Verdict {
    has_strokes(plan, |params| match params.strokes.style.is_laid() {
        true => Verdict::left_out("strokes are laid one by one"),
        false => decide(params),
    })
}

/// The verdict on a step of strokes.
pub(crate) fn has_strokes(plan: &Plan, decide: impl FnOnce(&LineParams) -> Verdict) -> Verdict {
    is_drawn(plan, |params| match params.lines_only {
        true => Verdict::left_out("lines alone are drawn"),
        false => decide(params),
    })
}

/// The surface that is drawn, and its edges.
pub(crate) struct Drawn<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) silhouette: Option<&'a Plane>,
    pub(crate) crease: Option<&'a Plane>,
    pub(crate) conductance: Option<&'a Plane>,
}

impl<'a> Drawn<'a> {
    /// The surface of a run as it is seen, also in mirrors and lenses.
    pub(crate) fn of(run: &'a Execution) -> Self {
        let shape = &run.made.outcome.shape;
        match &run.canvas().seen {
            Some((seen, edges)) => Self {
                frame: &seen.frame,
                silhouette: edges.silhouette.as_ref(),
                crease: edges.crease.as_ref(),
                conductance: Some(&edges.conductance),
            },
            None => Self {
                frame: run.frame,
                silhouette: shape.silhouette.as_ref(),
                crease: shape.crease.as_ref(),
                conductance: shape.conductance.as_ref(),
            },
        }
    }
}

/// A drawing of contours and interior lines alone: strokes that cover nothing.
pub(crate) static LINES_ONLY: Stage = Stage {
    makes: Makes::Drawing,
    name: "lines-only",
    steps: &[step("lines-only", &[Product::Strokes], |plan| {
        is_drawn(plan, |params| match params.lines_only {
            true => Verdict::runs("the paper between lines stays white"),
            false => Verdict::left_out("strokes are drawn too"),
        })
    })],
    cpu: leave_white,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("drawings of lines alone"),
    ..Stage::DEFAULT
};

fn leave_white(run: &mut Execution) {
    let mask = &run.frame.mask;
    let tone = DrawnTone {
        density: None,
        made: None,
        white: 1.0,
    };
    let blank = Plane::filled(mask.width(), mask.height(), 0.0);
    finish(run, tone, blank, Vec::new());
}

/// The tone to draw: the picture made so far, or that of the frame, or densities computed from either.
pub(crate) struct DrawnTone {
    density: Option<Plane>,
    made: Option<ColorPlanes>,
    /// Luminance of paper white.
    pub(crate) white: f32,
}

impl DrawnTone {
    /// The tone of a run, out of its hands until [`finish`] gives it back.
    pub(crate) fn taken(run: &mut Execution) -> Self {
        let (plan, frame) = (run.plan, run.frame);
        let params = plan.drawing.as_ref().expect("a tone is of a drawing");
        let mut tone = Self {
            density: run.canvas_mut().density.take(),
            made: run.made.outcome.color.take(),
            white: 1.0,
        };
        tone.white = match params.tone.white_point {
            _ if tone.density.is_some() => 1.0,
            Adaptive::Fixed(white) => white,
            Adaptive::Auto => run.timed("auto-white", || {
                let weights = frame.luminance_weights();
                white_level(tone.of(frame), weights, &frame.mask)
            }),
        };
        tone
    }

    fn of<'a>(&'a self, frame: &'a Frame) -> &'a ColorPlanes {
        let shown = self.made.as_ref().or(frame.color.as_ref());
        shown.expect("a drawing is planned with its tone")
    }

    /// The optical densities that are drawn.
    pub(crate) fn densities<'a>(&'a self, frame: &'a Frame, params: &ToneParams) -> Densities<'a> {
        match &self.density {
            Some(density) => Densities::Found(density),
            None => Densities::OfPicture(PictureDensities {
                color: self.of(frame),
                frame,
                weights: frame.luminance_weights(),
                white: self.white,
                table: density_table(params),
            }),
        }
    }
}

/// The share of the paper that is covered at optical densities.
fn covering(mut density: Plane) -> Plane {
    density.each_row(|_, row| row.iter_mut().for_each(|v| *v = coverage_at(*v)));
    density
}

/// Assembles the drawing from its strokes and the content of the canvas.
pub(crate) fn finish(
    run: &mut Execution,
    tone: DrawnTone,
    hatching: Plane,
    lines: Vec<Streamline>,
) {
    let canvas = std::mem::take(run.canvas_mut());
    let (plan, memory) = (run.plan, run.memory);
    let directions = canvas.directions.into_iter();
    memory.recycle(directions.flat_map(|d| [d.x, d.y]));
    let (contours, contour_lines) = canvas.contours.unzip();
    let (interior, interior_lines) = canvas.interior.unzip();
    run.made.outcome.color = tone.made;
    let asked = tone.density.filter(|_| plan.keeps_tone);
    run.made.outcome.drawing = Some(Drawing {
        hatching,
        lines,
        dots: Vec::new(),
        contours,
        contour_lines: contour_lines.unwrap_or_default(),
        interior,
        interior_lines: interior_lines.unwrap_or_default(),
        asked: asked.map(covering),
        white_point: tone.white,
        coordinates: canvas.coordinates,
    });
}
