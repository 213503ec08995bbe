//! Temporal coherence of drawings: each drawing of a sequence, warped by the surface's motion, compared with the next,
//! for strokes fixed in the picture, for strokes that move with the surface, and for lines along edges and inside
//! surfaces.
//!
//! Warping blurs a drawing, so even a perfect sequence has a difference. As its measure, a card of one tone and one
//! direction, drawn with a texture that moved like the frame, is compared with the previous card.

use crate::common::{covered, default_but};
use relievo::Result;
use relievo::engine::{Engine, Outcome, PlanInputs, Run, SequenceInputs, TextureCoordinates};
use relievo::frame::{ColorPlanes, Frame, Mask, Plane, Vector2Planes, Vector3Planes};
use relievo::light::lights::{DirectionalLight, Illumination};
use relievo::params::{
    Adaptive, LineLevels, LineParams, RelightParams, ScalingParams, ShapeParams, StrokeScale,
    ToneParams,
};
use relievo::plan::{Available, Goal, Plan, Tone};

/// A frame of a sequence.
#[derive(Debug)]
pub(crate) struct MovingFrame {
    /// Frame number.
    pub number: i32,
    /// The frame.
    pub frame: Frame,
    /// Motion of the surface seen at each pixel since the previous frame, in pixels, x right, y up.
    pub motion: Option<Vector2Planes>,
}

/// Mean absolute differences of ink, 0..1, from one frame to the next, over the pixels seen in both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CoherenceRow {
    /// Number of the later frame.
    pub frame: i32,
    /// Mean length of the motion, in pixels.
    pub motion_px: f64,
    /// Share of the surface that was also seen before.
    pub seen_before: f64,
    /// Difference for strokes fixed in the picture.
    pub still: f64,
    /// Difference for strokes that move with the surface.
    pub carried: f64,
    /// Difference for the card: the cost of warping a drawing.
    pub floor: f64,
    /// Difference for lines along edges and inside surfaces, without strokes.
    pub lines: f64,
    /// Largest share of the drawing that uses one coordinate map: 1 if strokes were only moved.
    pub oldest_share: f64,
}

/// The whole sequence.
#[derive(Debug, Clone)]
pub(crate) struct Coherence {
    /// One row per pair of frames.
    pub rows: Vec<CoherenceRow>,
    /// Mean of each difference over the rows: still, carried, floor, lines.
    pub means: [f64; 4],
}

/// Measures consecutive `frames`; frames without motion start anew. `None` if no two consecutive frames are linked by
/// motion.
///
/// # Errors
/// Those of processing a frame, and [`crate::Error::BadParameter`] for parameters outside their range.
pub(crate) fn measure(
    frames: impl Iterator<Item = Result<MovingFrame>>,
    shape: ShapeParams,
) -> Result<Option<Coherence>> {
    let mut drawer = SequenceDrawer::new(shape);
    let mut before: Option<Drawn> = None;
    let mut rows = Vec::new();
    for moving in frames {
        let moving = moving?;
        let drawn = drawer.draw(&moving, before.as_ref())?;
        if let (Some(before), Some(motion)) = (&before, &moving.motion) {
            rows.push(drawer.row(&moving, motion, before, &drawn)?);
        }
        before = Some(drawn);
    }
    let of: [fn(&CoherenceRow) -> f64; 4] = [|r| r.still, |r| r.carried, |r| r.floor, |r| r.lines];
    let means = of.map(|of| rows.iter().map(of).sum::<f64>() / rows.len().max(1) as f64);
    Ok((!rows.is_empty()).then_some(Coherence { rows, means }))
}

/// A frame drawn in all ways.
struct Drawn {
    frame: Frame,
    still: Plane,
    carried: Plane,
    lines: Plane,
    coordinates: TextureCoordinates,
}

struct SequenceDrawer {
    engine: Engine,
    shape: ShapeParams,
    scaling: ScalingParams,
    line: LineParams,
    /// Parameters of the drawing with lines only.
    lines_alone: LineParams,
    lamp: Illumination,
}

impl SequenceDrawer {
    fn new(shape: ShapeParams) -> Self {
        // Strokes and lines at scale 1.
        let mut own_size = LineParams::default();
        own_size.strokes.scale = StrokeScale::Factor(1.0);
        let lamp = DirectionalLight::white([135.0, 40.0]);
        Self {
            engine: Engine::cpu(),
            shape,
            scaling: ScalingParams::default(),
            line: LineParams {
                contours: None,
                interior: None,
                ..own_size
            },
            lines_alone: LineParams {
                lines_only: true,
                ..own_size
            },
            lamp: default_but(|light: &mut Illumination| light.directional.push(lamp)),
        }
    }

    fn draw(&mut self, moving: &MovingFrame, before: Option<&Drawn>) -> Result<Drawn> {
        let frame = &moving.frame;
        let tone = match frame.color {
            Some(_) => Tone::Enhanced,
            None => Tone::Relit(RelightParams::default()),
        };
        let lines = self.draw_lines(frame)?;
        let plan = self.plan(frame, tone, self.line)?;
        let draw = |sequence| {
            let inputs = PlanInputs {
                illumination: Some(&self.lamp),
                sequence,
                ..PlanInputs::default()
            };
            self.engine.execute(&plan, frame, inputs, &Run::new())
        };
        let still = draw(None)?;
        let carried = draw(Some(SequenceInputs {
            before: before.map(|before| &before.coordinates),
            motion: moving.motion.as_ref(),
        }))?;
        self.keep(&still);
        let still = still.drawing.expect("a drawing was planned");
        let carried = carried.drawing.expect("a drawing was planned");
        Ok(Drawn {
            frame: frame.clone(),
            still: still.hatching,
            carried: carried.hatching,
            lines,
            coordinates: carried.coordinates.expect("a sequence has coordinates"),
        })
    }

    /// The ink of lines only; levels for their widths come from the first frame.
    fn draw_lines(&mut self, frame: &Frame) -> Result<Plane> {
        let plan = self.plan(frame, Tone::Picture, self.lines_alone)?;
        let inputs = PlanInputs::default();
        let outcome = self.engine.execute(&plan, frame, inputs, &Run::new())?;
        let interior = self.lines_alone.interior.as_mut();
        if let (Some(interior), Some(levels)) = (interior, outcome.line_levels) {
            interior.levels = LineLevels::Given(levels);
        }
        let drawing = outcome.drawing.expect("a drawing was planned");
        let layers = [drawing.contours, drawing.interior];
        let [mut ink, interior] = layers.map(|layer| layer.expect("both kinds are drawn"));
        let both = ink.samples_mut().iter_mut().zip(interior.samples());
        both.for_each(|(ink, interior)| *ink += (1.0 - *ink) * interior);
        Ok(ink)
    }

    fn plan(&self, frame: &Frame, tone: Tone, line: LineParams) -> Result<Plan> {
        let available = Available {
            moving: true,
            in_sequence: true,
            ..Available::in_frame(frame).lit_by(&self.lamp)
        };
        Plan::new(Goal::Hatch(tone, line), available, self.shape, self.scaling)
    }

    /// Keeps the levels chosen from the first frame.
    fn keep(&mut self, outcome: &Outcome) {
        let white = outcome.drawing.as_ref().map(|drawing| drawing.white_point);
        for (chosen, used) in [
            (&mut self.scaling.curvature_gain, outcome.gain),
            (&mut self.scaling.white_level, outcome.white_level),
            (&mut self.line.tone.white_point, white),
        ] {
            if let Some(used) = used {
                *chosen = Adaptive::Fixed(used);
            }
        }
    }

    fn row(
        &self,
        moving: &MovingFrame,
        motion: &Vector2Planes,
        before: &Drawn,
        drawn: &Drawn,
    ) -> Result<CoherenceRow> {
        let frame = &moving.frame;
        let seen = before.coordinates.seen_before(frame, motion);
        let path = Path {
            before: &before.frame,
            frame,
            motion,
            seen: &seen,
        };
        let tone = 1.0 - mean(drawn.carried.samples(), &frame.mask) as f32;
        let [first, then] = [&before.frame, frame].map(|frame| card(frame, tone));
        let first = self.draw_card(&first, None)?;
        let then = self.draw_card(&then, Some((&first.1, motion)))?;
        let lengths = motion.x.samples().iter().zip(motion.y.samples());
        let lengths: Vec<f32> = lengths.map(|(x, y)| x.hypot(*y)).collect();
        let shares = drawn.coordinates.mean_shares();
        Ok(CoherenceRow {
            frame: moving.number,
            motion_px: mean(&lengths, &seen),
            seen_before: seen.count() as f64 / frame.mask.count().max(1) as f64,
            still: path.difference(&before.still, &drawn.still),
            carried: path.difference(&before.carried, &drawn.carried),
            floor: path.difference(&first.0, &then.0),
            lines: path.difference(&before.lines, &drawn.lines),
            oldest_share: shares.first().copied().unwrap_or(1.0),
        })
    }

    /// The ink on a card, and the coordinates of its texture.
    fn draw_card(
        &self,
        card: &Frame,
        before: Option<(&TextureCoordinates, &Vector2Planes)>,
    ) -> Result<(Plane, TextureCoordinates)> {
        let mut line = self.line;
        // The picture is used as the tone: 1 is paper.
        line.tone = ToneParams {
            white_point: Adaptive::Fixed(1.0),
            black_point: 0.0,
            gamma: 1.0,
            ..ToneParams::default()
        };
        let available = Available::in_frame(card);
        let goal = Goal::Hatch(Tone::Picture, line);
        let plan = Plan::new(goal, available, self.shape, self.scaling)?;
        let inputs = PlanInputs {
            sequence: Some(SequenceInputs {
                before: before.map(|(coordinates, _)| coordinates),
                motion: before.map(|(_, motion)| motion),
            }),
            ..PlanInputs::default()
        };
        let outcome = self.engine.execute(&plan, card, inputs, &Run::new())?;
        let drawing = outcome.drawing.expect("a drawing was planned");
        let coordinates = drawing.coordinates.expect("a sequence has coordinates");
        Ok((drawing.hatching, coordinates))
    }
}

/// A card of one tone facing the viewer, with the outline and depth of `frame`.
fn card(frame: &Frame, tone: f32) -> Frame {
    let flat = |value| Plane::filled(frame.mask.width(), frame.mask.height(), value);
    let [x, y, z] = [0.0, 0.0, 1.0].map(flat);
    Frame {
        normal: Vector3Planes { x, y, z },
        normal_length: None,
        color: Some(ColorPlanes::grey(flat(tone))),
        alpha: None,
        ..frame.clone()
    }
}

fn mean(samples: &[f32], mask: &Mask) -> f64 {
    let covered = samples.iter().zip(mask.plane().samples());
    let covered = covered.filter(|(_, covered)| **covered);
    let sum: f64 = covered.map(|(s, _)| f64::from(*s)).sum();
    sum / mask.count().max(1) as f64
}

/// The motion of the surface between two frames.
struct Path<'a> {
    before: &'a Frame,
    frame: &'a Frame,
    motion: &'a Vector2Planes,
    /// The pixels to compare.
    seen: &'a Mask,
}

impl Path<'_> {
    /// Mean absolute difference between the ink `before`, warped by the motion, and the ink `now`.
    fn difference(&self, before: &Plane, now: &Plane) -> f64 {
        let (then, here) = (self.before.data_window, self.frame.data_window);
        let (right, down) = (here.x0 - then.x0, here.y0 - then.y0);
        let differences = covered(self.seen).map(|(x, y)| {
            let u = x as f64 + f64::from(right) - f64::from(self.motion.x.at(x, y));
            let v = y as f64 + f64::from(down) + f64::from(self.motion.y.at(x, y));
            (f64::from(now.at(x, y)) - between(before, u, v)).abs()
        });
        differences.sum::<f64>() / self.seen.count().max(1) as f64
    }
}

/// Bilinear interpolation of a plane; outside, its border is repeated.
fn between(plane: &Plane, x: f64, y: f64) -> f64 {
    let inside = |at: f64, length: usize| at.clamp(0.0, length as f64 - 1.0);
    let (x, y) = (inside(x, plane.width()), inside(y, plane.height()));
    let (left, top) = (x.floor(), y.floor());
    let at = |dx: usize, dy: usize| {
        let column = (left as usize + dx).min(plane.width() - 1);
        let row = (top as usize + dy).min(plane.height() - 1);
        f64::from(plane.at(column, row))
    };
    let along = |dy| at(0, dy) + (x - left) * (at(1, dy) - at(0, dy));
    along(0) + (y - top) * (along(1) - along(0))
}
