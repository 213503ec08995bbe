//! Drawings: error against time for levels, sets, passes and the field's resolution, and the accuracy of tones.
//!
//! The drawing is a card: the surface of a frame in one uniform tone, which isolates the strokes.

pub(super) mod field;
pub(super) mod strokes;
pub(super) mod tone;

use super::asked::{Asked, Extent};
use super::engine::{Inputs, Outcome, Session, hatch_plan, painted};
use super::light::middle;
use super::scenes::Scene;
use super::sweeps::precision::{Stored, rounded};
use super::timing::{Effort, Timed};
use crate::Result;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use crate::params::{
    FieldParams, LineParams, ShapeParams, StrokeDirections, StrokeParams, StrokeScale,
};
use crate::plan::{Available, Plan};
use serde::Serialize;

/// All measurements of drawings.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct DrawingReport {
    pub fields: Vec<field::Sweep>,
    pub strokes: strokes::Sweep,
    pub tones: Vec<tone::ToneRow>,
}

/// Measures drawings of `frame`, called `name`.
pub(super) fn run(asked: &Asked) -> Result<DrawingReport> {
    let Asked {
        name,
        frame,
        shape,
        extent,
        progress,
        ..
    } = *asked;
    let (most, effort) = match extent {
        Extent::Full => ([960, 720], Effort::new(5, 200)),
        Extent::Quick => ([480, 360], Effort::new(3, 60)),
    };
    let part = middle(frame, most);
    let bench = Card::new(&part, shape, effort);
    progress(&format!("{name}: directions of strokes"));
    let mut fields = vec![field::sweep(name, &bench, None)?];
    let (width, height) = super::scene_size(extent);
    let ellipsoid = Scene::ellipsoid(width, height);
    for stored in [Stored::Float, Stored::Byte] {
        let frame = rounded(&ellipsoid.frame, stored);
        let bench = Card::new(&frame, ShapeParams::default(), effort);
        let name = match stored {
            Stored::Byte => "ellipsoid, normals of 8 bits",
            Stored::Float | Stored::Half => "ellipsoid",
        };
        progress(&format!("{name}: directions of strokes"));
        fields.push(field::sweep(name, &bench, Some(&ellipsoid))?);
    }
    progress(&format!("{name}: levels and sets of strokes"));
    let strokes = strokes::sweep(name, &bench)?;
    progress("tones of strokes");
    let tones = tone::rows()?;
    Ok(DrawingReport {
        fields,
        strokes,
        tones,
    })
}

/// The tone that shows strokes best.
const HALF: f32 = 0.5;

/// A card for repeated drawing in the same memory.
struct Card {
    card: Frame,
    shape: ShapeParams,
    effort: Effort,
    session: Session,
}

impl Card {
    /// The surface of `frame` in half tone.
    fn new(frame: &Frame, shape: ShapeParams, effort: Effort) -> Self {
        let mut bench = Self {
            card: frame.clone(),
            shape,
            effort,
            session: Session::default(),
        };
        bench.paint(HALF);
        bench
    }

    /// Sets the tone of the card.
    fn paint(&mut self, tone: f32) {
        let mask = &self.card.mask;
        let even = Plane::filled(mask.width(), mask.height(), tone);
        self.card.color = Some(ColorPlanes::grey(even));
    }

    /// The ink of its drawing, without contours.
    fn ink(&self, line: LineParams) -> Result<Plane> {
        let plan = self.plan(line)?;
        Ok(hatching(self.session.run(
            &plan,
            &self.card,
            Inputs::default(),
        )))
    }

    /// The same, with the times of the stages.
    fn timed(&self, line: LineParams) -> Result<(Plane, Timed)> {
        let plan = self.plan(line)?;
        let inputs = Inputs::default();
        let (outcome, timed) = self.session.measure(&plan, &self.card, inputs, self.effort);
        Ok((hatching(outcome), timed))
    }

    /// The directions that strokes follow.
    fn field(&self, field: FieldParams) -> Result<Vector2Planes> {
        let plan = self.plan(LineParams::default())?;
        let line = LineParams {
            field,
            ..LineParams::default()
        };
        let inputs = Inputs::default();
        Ok(self.session.stroke_field(&plan, &self.card, inputs, &line))
    }

    /// A single family of strokes at scale 1.
    fn plan(&self, line: LineParams) -> Result<Plan> {
        let line = LineParams {
            tone: painted(),
            contours: None,
            directions: StrokeDirections::Max,
            strokes: StrokeParams {
                scale: StrokeScale::Factor(1.0),
                ..line.strokes
            },
            ..line
        };
        hatch_plan(Available::in_frame(&self.card), self.shape, line)
    }
}

fn hatching(outcome: Outcome) -> Plane {
    outcome.drawing.expect("a drawing was planned").hatching
}
