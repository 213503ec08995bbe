//! The engine as a caller meets it: requests, and how they are run.

use crate::prelude::*;
use relievo::Error;
use std::sync::Mutex;

fn waves() -> Frame {
    let mut frame = Scene::waves(80, 90).frame;
    let light = |x, y| 0.5 + 0.4 * ((x + 2 * y) as f32 / 9.0).sin();
    frame.color = Some(colors([80, 90], |i, x, y| [0.9, 0.7, 0.5][i] * light(x, y)));
    frame
}

/// Of a short diffusion.
fn usual() -> Params {
    default_but(|params: &mut Params| params.shape.scale = Scale::Iterations(6))
}

/// Parameters with nothing chosen from the frame.
fn given() -> Params {
    Params::of(usual().shape, crate::common::given(3.0, 1.0))
}

fn hatch(tone: Tone, line: LineParams) -> Request<'static> {
    Request::new(Goal::Hatch(tone, line), usual())
}

/// Lines of this style.
fn styled(style: Style) -> LineParams {
    default_but(|line: &mut LineParams| line.strokes.style = style)
}

#[test]
fn inputs_that_do_not_fit_a_plan_are_errors_of_one_line() {
    let frame = waves();
    let bare = Frame {
        color: None,
        ..frame.clone()
    };
    let (available, light) = (Available::in_frame(&frame), lamp(135.0, 40.0));
    let planned = |request: Request| request.plan(available).unwrap();
    let relit = planned(Request::relight(usual(), &light));
    let enhanced = planned(Request::enhance(usual()));
    let drawn = planned(hatch(Tone::Picture, styled(Style::Pictures)));
    // Even light alone: the plan was made without lamps.
    let new_light = |available| {
        let goal = Goal::Relight(RelightParams::default());
        let params = usual();
        Plan::new(goal, available, params.shape, params.scaling).unwrap()
    };
    let even = new_light(available);
    let mut with_sphere = available;
    with_sphere.new_light.lit_spheres = 1;
    let sphere = new_light(with_sphere);
    let engine = Engine::cpu();
    for (plan, frame, inputs, what) in [
        (&relit, &frame, PlanInputs::default(), "takes light"),
        (&sphere, &frame, PlanInputs::lit_by(&light), "1 lit spheres"),
        (&even, &frame, PlanInputs::lit_by(&light), "other lamps"),
        (&enhanced, &bare, PlanInputs::default(), "takes a picture"),
        (&drawn, &frame, PlanInputs::default(), "texture of strokes"),
    ] {
        let done = engine.execute(plan, frame, inputs, &Run::new());
        let error = done.unwrap_err();
        let line = error.to_string();
        assert!(matches!(error, Error::Unfit { .. }), "{line}");
        assert!(line.contains(what) && line.lines().count() == 1, "{line}");
    }
}

/// The layers that a frame may lack.
const LAYERS: [fn(&mut Frame); 9] = [
    |frame| frame.color = None,
    |frame| frame.albedo = None,
    |frame| frame.depth = None,
    |frame| frame.camera = None,
    |frame| frame.occlusion = None,
    |frame| frame.importance = None,
    |frame| frame.stroke_fallback = None,
    |frame| frame.light.lobes.clear(),
    |frame| frame.light.groups.clear(),
];

/// A frame with all of them.
fn with_all_layers() -> Frame {
    let frame = waves().crop(Window::at(10, 10, 24, 20));
    let color = frame.color.clone();
    let [fx, fy, cx, cy] = [40.0, 40.0, 12.0, 10.0];
    let ones = Plane::filled(24, 20, 1.0);
    let lobe = |lobe| LobeLayers {
        lobe,
        direct: color.clone(),
        indirect: color.clone(),
        color: None,
        albedo: None,
    };
    let group = LightGroup {
        name: "key".into(),
        light: color.clone().unwrap(),
        to_light: vec![Vec3::Z],
    };
    Frame {
        albedo: color.clone(),
        depth: Some(Plane::from_fn(24, 20, |x, _| 50.0 + x as f32)),
        camera: Some(Camera {
            view_from_world: DAffine3::IDENTITY,
            projection: Projection::Perspective { fx, fy, cx, cy },
        }),
        occlusion: Some(ones.clone()),
        importance: Some(ones),
        stroke_fallback: Some(Vector3Planes::from_fn(24, 20, |_, _| DVec3::ZERO)),
        light: LightLayers {
            lobes: vec![lobe(Lobe::Diffuse), lobe(Lobe::Specular)],
            groups: vec![group],
            ..LightLayers::default()
        },
        ..frame
    }
}

/// Requests of every kind, and whether they cannot do without a picture.
fn requests(light: &Illumination) -> Vec<(&'static str, bool, Request<'_>)> {
    let relit = RelightParams::default();
    let drawn = |tone, line| hatch(tone, line).lit_by(light);
    let of_shape = |line| drawn(Tone::Shape(None), line);
    let (mut idle, mut of_picture) = (usual(), usual());
    idle.scaling.scaling = 0.0;
    of_picture.relight.albedo = AlbedoSource::Estimate;
    let mut shadows = LineParams::default();
    shadows.interior.as_mut().unwrap().shadow_share = 0.5;
    let relief = Goal::Layers {
        and: &[Product::Height, Product::Sky, Product::BentNormal],
        more_px: &[],
    };
    let usual_line = LineParams::default();
    let lines_only = default_but(|line: &mut LineParams| line.lines_only = true);
    #[rustfmt::skip]
    let requests = vec![
        ("layers", false, Request::layers(usual())),
        ("relief", false, Request::new(relief, usual())),
        ("display", false, Request::display(usual())),
        ("enhance", true, Request::enhance(usual())),
        ("enhance by 0", true, Request::enhance(idle)),
        ("relight", false, Request::relight(usual(), light)),
        ("relight its colours", true, Request::relight(of_picture, light)),
        ("tone of the picture", true, drawn(Tone::Picture, usual_line)),
        ("tone enhanced", true, drawn(Tone::Enhanced, usual_line)),
        ("tone relit", false, drawn(Tone::Relit(relit), usual_line)),
        ("tone of shape", false, of_shape(usual_line)),
        ("tone of shape, lit", false, drawn(Tone::Shape(Some(relit)), usual_line)),
        ("engraving", false, of_shape(styled(Style::Engraving))),
        ("stipple", false, of_shape(styled(Style::Stipple))),
        ("lines only", false, drawn(Tone::Picture, lines_only)),
        ("shadows", false, of_shape(shadows)),
    ];
    requests
}

/// Any two layers are missing, or all, or none: a request runs, unless it takes a picture that is not there. Its plan for
/// all layers runs nowhere else.
#[test]
fn a_request_without_its_layers_is_an_error_of_one_line() {
    let (whole, light, engine) = (with_all_layers(), lamp(135.0, 40.0), Engine::cpu());
    let mut frames = vec![whole.clone()];
    for (first, lose) in LAYERS.iter().enumerate() {
        for lose_more in &LAYERS[first..] {
            let mut frame = whole.clone();
            lose(&mut frame);
            lose_more(&mut frame);
            frames.push(frame);
        }
    }
    let mut bare = whole.clone();
    LAYERS.iter().for_each(|lose| lose(&mut bare));
    frames.push(bare);
    for (name, takes_picture, request) in requests(&light) {
        let plan = request.plan(Available::in_frame(&whole)).unwrap();
        for frame in &frames {
            let available = Available::in_frame(frame);
            let done = engine.run(&request, frame, &Run::new());
            let fails = takes_picture && frame.color.is_none();
            assert_eq!(done.is_err(), fails, "{name}: {available:?}");
            if let Err(error) = done {
                let line = error.to_string();
                assert!(line.contains("picture") && !line.contains('\n'), "{line}");
            }
            let done = engine.execute(&plan, frame, request.inputs, &Run::new());
            // Strokes do without the directions of objects.
            let mut needed = available;
            needed.object_angles = true;
            let is_fit = needed == Available::in_frame(&whole);
            let is_unfit = matches!(done, Err(Error::Unfit { .. }));
            assert_eq!(is_unfit, !is_fit, "{name}: {:?} {available:?}", done.err());
        }
    }
}

/// A run of each kind is cancelled as each of its passes begins. Afterwards the same session, with its cached products,
/// gives the samples of one that was never cancelled.
#[test]
fn wherever_a_run_is_cancelled_its_session_stays_whole() {
    let (frame, light) = (waves(), lamp(135.0, 40.0));
    let drawing = |style| hatch(Tone::Shape(None), styled(style));
    let requests = [
        Request::layers(usual()),
        Request::enhance(usual()),
        Request::relight(usual(), &light),
        drawing(Style::Pen),
        drawing(Style::Lines),
        drawing(Style::Stipple),
    ];
    for request in &requests {
        let mut anew = Session::new(Engine::cpu(), frame.clone());
        let expected = anew.run(request, &Run::new()).unwrap();
        let passes: Vec<_> = expected.timings.iter().map(|(pass, _)| *pass).collect();
        assert!(passes.len() > 3, "{passes:?}");
        let (engine, token) = (Engine::cpu(), CancelToken::new());
        token.cancel();
        let stopped = engine.run(request, &frame, &Run::new().cancel(&token));
        assert!(matches!(stopped, Err(Error::Cancelled)));
        engine.run(request, &frame, &Run::new()).unwrap();
        for pass in passes {
            let mut session = Session::new(Engine::cpu(), frame.clone());
            for with_kept in [false, true] {
                let token = CancelToken::new();
                let tell = |at: Progress| {
                    if at.stage == pass {
                        token.cancel();
                    }
                };
                let run = Run::new().progress(&tell).cancel(&token);
                let stopped = session.run(request, &run).err();
                // Cached products may make the pass unnecessary.
                let is_met = matches!(stopped, Some(Error::Cancelled)) && token.is_cancelled();
                assert!(is_met || with_kept && stopped.is_none(), "{pass}");
                let again = session.run(request, &Run::new()).unwrap();
                let made = again.products().count();
                assert_eq!(made, expected.products().count(), "{pass}");
                for ((product, a), (_, b)) in again.products().zip(expected.products()) {
                    let same = a.iter().zip(&b).all(|(a, b)| bits(a) == bits(b));
                    assert!(same, "{product:?} after {pass} was cancelled");
                }
            }
        }
    }
}

#[test]
fn progress_goes_up_to_the_end() {
    let said = Mutex::new(Vec::new());
    let tell = |at: Progress| said.lock().unwrap().push(at);
    let request = Request::enhance(usual());
    let run = Run::new().progress(&tell);
    Engine::cpu().run(&request, &waves(), &run).unwrap();
    let said = said.lock().unwrap();
    assert!(said.is_sorted_by(|a, b| a.done <= b.done), "{said:?}");
    assert!(said.iter().any(|at| at.stage == "radiance-scaling"));
    let last = said.last().map(|at| (at.stage, at.done));
    assert_eq!(last, Some(("done", 1.0)));
}

#[test]
fn a_region_is_that_part_of_the_whole() {
    let (frame, engine) = (waves(), Engine::cpu());
    let request = Request::enhance(given());
    let window = frame.data_window;
    let region = Window::at(window.x0 + 20, window.y0 + 33, 31, 17);
    let whole = engine.run(&request, &frame, &Run::new()).unwrap();
    let part = engine.run(&request, &frame, &Run::new().region(region));
    let part = part.unwrap();
    for ((_, part), (_, whole)) in part.products().zip(whole.products()) {
        for (part, whole) in part.iter().zip(whole) {
            assert_eq!(bits(part), bits(&whole.crop(window, region)));
        }
    }
    let outside = Window::at(window.x0 - 1, window.y0, 5, 5);
    let outside = engine.run(&request, &frame, &Run::new().region(outside));
    let error = outside.unwrap_err().to_string();
    assert!(error.contains("inside the frame"), "{error}");
}

/// A region of a frame of a sequence is drawn as a frame of that part is, with as much around it as the plan reaches.
#[test]
fn a_region_in_a_sequence_is_drawn_as_that_part_is() {
    let (frame, engine, line) = (waves(), Engine::cpu(), LineParams::default());
    let drawn = |frame: &Frame, sequence: SequenceInputs, region: Option<Window>| {
        let request = Request::new(Goal::Hatch(Tone::Picture, line), given());
        let request = request.in_sequence(sequence);
        let run = region.map_or(Run::new(), |region| Run::new().region(region));
        let plan = request.plan(Available::in_frame(frame)).unwrap();
        let outcome = engine.run(&request, frame, &run).unwrap();
        (outcome.drawing.unwrap(), plan.reach() as i32)
    };
    let moved = |height: usize, width: usize| {
        let [x, y] = [1.0, 0.0].map(|by| Plane::filled(width, height, by));
        Vector2Planes { x, y }
    };
    let (window, still) = (frame.data_window, SequenceInputs::default());
    let region = Window::at(window.x0 + 20, window.y0 + 33, 31, 17);
    let (first, reach) = drawn(&frame, still, Some(region));
    let (x0, y0) = (region.x0 - reach, region.y0 - reach);
    let (x1, y1) = (region.x1 + reach, region.y1 + reach);
    let around = Window { x0, y0, x1, y1 }.common(&window).unwrap();
    let part = frame.crop(around);
    let (expected, _) = drawn(&part, still, None);
    let (all, of_part) = (moved(90, 80), moved(around.height(), around.width()));
    let after = |before: &Drawing, motion, frame: &Frame, region| {
        let (before, motion) = (before.coordinates.as_ref(), Some(motion));
        drawn(frame, SequenceInputs { before, motion }, region).0
    };
    let second = after(&first, &all, &frame, Some(region));
    let expected_second = after(&expected, &of_part, &part, None);
    for (found, expected) in [(&first, &expected), (&second, &expected_second)] {
        let expected = expected.hatching.crop(around, region);
        assert_eq!(bits(&found.hatching), bits(&expected));
    }
    assert_ne!(bits(&first.hatching), bits(&second.hatching));
}

#[test]
fn results_go_to_memory_of_the_caller_and_threads_change_no_bit() {
    let (frame, engine) = (waves(), Engine::cpu());
    let request = Request::layers(given());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2);
    let pool = pool.build().unwrap();
    let (mut hessian, mut kappa) = (vec![0.0; 3 * 80 * 90], vec![0.0; 80 * 90]);
    let run = Run::new().threads(&pool);
    let run = run.output(Product::Hessian, &mut hessian);
    let run = run.output(Product::MappedCurvature, &mut kappa);
    let outcome = engine.run(&request, &frame, &run).unwrap();
    drop(run);
    let alone = engine.run(&request, &frame, &Run::new()).unwrap();
    let expected = alone.planes(Product::MappedCurvature);
    assert_eq!(kappa, expected[0].samples());
    let expected = outcome.planes(Product::Hessian);
    let pixel = [0, 1, 2].map(|k| expected[k].at(11, 7));
    assert_eq!(hessian[3 * (7 * 80 + 11)..][..3], pixel);
}

#[test]
fn memory_of_another_size_is_refused_before_anything_is_done() {
    let (frame, engine) = (waves(), Engine::cpu());
    let request = Request::layers(given());
    let tell = |at: Progress| panic!("{} began", at.stage);
    let mut session = Session::new(Engine::cpu(), frame.clone());
    let mut short = vec![0.0; 80 * 90 - 1];
    let run = Run::new().progress(&tell);
    let run = run.output(Product::MappedCurvature, &mut short);
    let refused = |done: relievo::Result<()>| {
        let line = done.unwrap_err().to_string();
        assert!(line.contains("mapped curvature has 1 components"), "{line}");
    };
    refused(engine.run(&request, &frame, &run).map(drop));
    refused(session.run(&request, &run).map(drop));
    let region = run.region(Window::at(0, 0, 8, 8));
    refused(engine.run(&request, &frame, &region).map(drop));
}
