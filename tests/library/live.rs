//! A session that keeps a frame gives the results of a fresh one, and recomputes only what a change affects.

use crate::common::files::load;
use crate::common::program::fixture;
use crate::prelude::*;
use relievo::engine;
use std::collections::BTreeMap;

fn bust() -> Frame {
    let loaded = load(fixture("bust.exr"), |inputs, needs| {
        inputs.light = Some(LightInputs::default());
        (needs.color, needs.projection) = (true, true);
    });
    loaded.frame
}

fn light(azimuth: f32) -> Illumination {
    lamp(azimuth, 35.0)
}

/// The settings of new light.
fn new_light(asked: &mut Asked) -> &mut RelightParams {
    match &mut asked.goal {
        Goal::Relight(params) => params,
        goal => panic!("{goal:?} has no new light"),
    }
}

/// A request.
#[derive(Clone)]
struct Asked {
    goal: Goal<'static>,
    shape: ShapeParams,
    scaling: ScalingParams,
    azimuth: f32,
    line: Option<LineParams>,
}

impl Asked {
    fn of(goal: Goal<'static>) -> Self {
        Self {
            goal,
            shape: ShapeParams::default(),
            scaling: ScalingParams::default(),
            azimuth: 120.0,
            line: None,
        }
    }

    fn with(&self, change: impl FnOnce(&mut Self)) -> Self {
        let mut asked = self.clone();
        change(&mut asked);
        asked
    }

    fn plan(&self, frame: &Frame) -> Plan {
        let available = Available::in_frame(frame).lit_by(&light(self.azimuth));
        let tone = match self.goal {
            Goal::Relight(relight) => Tone::Relit(relight),
            _ => Tone::Enhanced,
        };
        let drawn = self.line.map(|line| Goal::Hatch(tone, line));
        let goal = drawn.unwrap_or(self.goal);
        Plan::new(goal, available, self.shape, self.scaling).unwrap()
    }

    fn run_anew(&self, frame: &Frame) -> Outcome {
        let (plan, light) = (self.plan(frame), light(self.azimuth));
        cpu::execute(&plan, frame, engine::PlanInputs::lit_by(&light)).unwrap()
    }

    fn run_on<'l>(&self, live: &'l mut Session<Frame>) -> &'l Outcome {
        let (plan, light) = (self.plan(live.held()), light(self.azimuth));
        let inputs = engine::PlanInputs::lit_by(&light);
        live.execute(&plan, inputs, &Run::new()).unwrap()
    }
}

/// Every plane and number of an outcome, by its name.
fn all_of(outcome: &Outcome) -> BTreeMap<&'static str, Vec<u32>> {
    let planes = planes(outcome).into_iter();
    let planes = planes.map(|(name, plane)| (name, bits(plane)));
    let white_point = outcome.drawing.as_ref().map(|d| d.white_point);
    let numbers = [outcome.gain, outcome.white_level, white_point].into_iter();
    let numbers = ["gain", "white", "white point"].into_iter().zip(numbers);
    let numbers = numbers.filter_map(|(name, number)| Some((name, vec![number?.to_bits()])));
    planes.chain(numbers).collect()
}

#[test]
fn what_is_kept_changes_no_bit() {
    let frame = bust();
    let mut live = Session::new(Engine::cpu(), frame.clone());
    let enhance = Asked::of(Goal::Enhance);
    let relight = Asked::of(Goal::Relight(RelightParams::default()));
    let coarse = |a: &mut Asked| a.shape.scale = Scale::Sigma(6.0);
    let steps = [
        enhance.clone(),
        enhance.with(|a| a.scaling.scaling = 1.7),
        enhance.with(|a| a.shape.scale = Scale::Iterations(25)),
        enhance.with(|a| a.shape.scale = Scale::Iterations(0)),
        enhance.with(|a| a.shape.solver = Solver::Explicit),
        enhance.with(|a| a.shape.reference_height = Some(640)),
        enhance.with(|a| a.scaling.curvature_gain = Adaptive::Fixed(3.0)),
        enhance.with(|a| a.scaling.white_level = Adaptive::Fixed(0.5)),
        relight.clone(),
        relight.with(|a| a.azimuth = 10.0),
        relight.with(|a| new_light(a).method = Method::Plain),
        relight.with(|a| new_light(a).albedo = AlbedoSource::White),
        relight.with(coarse),
        Asked::of(Goal::LAYERS),
        Asked::of(Goal::LAYERS).with(coarse),
        Asked::of(Goal::Display).with(coarse),
        enhance.with(coarse),
        Asked::of(Goal::Display),
        relight.with(|a| a.line = Some(LineParams::default())),
        relight.with(|a| {
            a.azimuth = 200.0;
            a.line = Some(LineParams::default());
        }),
        enhance.with(|a| {
            let mut line = LineParams::default();
            line.strokes.style = Style::Pencil;
            line.field.passes += 2;
            a.line = Some(line);
        }),
        enhance.with(|a| {
            a.shape.silhouette = SoftThreshold { lo: 0.1, hi: 0.2 };
            a.line = Some(default_but(|line: &mut LineParams| line.contours = None));
        }),
        enhance.with(|a| a.shape.foreshortening = 0.5),
        enhance,
    ];
    for (step, asked) in steps.iter().enumerate() {
        let expected = all_of(&asked.run_anew(&frame));
        let found = all_of(asked.run_on(&mut live));
        assert!(found.keys().eq(expected.keys()), "step {step}");
        for (name, bits) in &expected {
            assert!(found[name] == *bits, "step {step}: {name} differs");
        }
    }
}

/// The passes run for `asked` after `before`.
fn passes_of(live: &mut Session<Frame>, before: &Asked, asked: &Asked) -> Vec<&'static str> {
    before.run_on(live);
    let counts = live.counts().clone();
    asked.run_on(live);
    let more = live.counts().iter();
    let more = more.filter(|(name, count)| counts.get(*name) != Some(count));
    more.map(|(&name, _)| name).collect()
}

#[test]
fn only_what_a_change_touches_is_made_anew() {
    let mut live = Session::new(Engine::cpu(), bust());
    let relight = Asked::of(Goal::Relight(RelightParams::default()));
    let enhance = Asked::of(Goal::Enhance);
    let mut pen = LineParams::default();
    pen.strokes.style = Style::Pen;
    let hatch = relight.with(|a| a.line = Some(pen));
    let mut expect = |before: &Asked, passes: &[&str], change: fn(&mut Asked)| {
        let after = before.with(change);
        assert_eq!(passes_of(&mut live, before, &after), passes);
    };
    // Light and its scaling do not affect shape.
    expect(&relight, &["relight"], |a| a.azimuth = 30.0);
    expect(&relight, &["relight"], |a| a.scaling.scaling = 1.5);
    expect(&relight, &["relight"], |a| new_light(a).warping.warp = 2.0);
    let scaled = ["radiance-scaling"];
    expect(&enhance, &scaled, |a| a.scaling.scaling = 1.5);
    // A new scale repeats the diffusion, between the same edges.
    let diffused = ["auto-gain", "curvature", "diffusion", "relight"];
    expect(&relight, &diffused, |a| {
        a.shape.scale = Scale::Iterations(30)
    });
    // A given gain applies to the same curvature.
    expect(&enhance, &scaled, |a| {
        a.scaling.curvature_gain = Adaptive::Fixed(4.0)
    });
    // Other edges recompute everything except products of the picture alone.
    let all = "auto-gain curvature diffusion edges-and-gradient radiance-scaling";
    let all: Vec<_> = all.split(' ').collect();
    expect(&enhance, &all, |a| {
        a.shape.crease = SoftThreshold { lo: 20.0, hi: 40.0 }
    });
    // A drawing in another light keeps directions and contours.
    let drawn = ["auto-white", "hatching", "relight"];
    expect(&hatch, &drawn, |a| a.azimuth = 30.0);
}
