//! Drawings: strokes and contours of both backends.

use super::hostile::HOSTILE;
use super::{MASKS, assert_alike, covered_where, on_gpu, outcomes, waves, with_color};
use glam::DVec3;
use relievo::engine::gpu::DeviceRunner;
use relievo::engine::{Outcome, PlanInputs, SequenceInputs, TextureCoordinates};
use relievo::frame::{Frame, Plane, Vector2Planes, Window};
use relievo::light::lights::{DirectionalLight, Illumination, direction_of};
use relievo::line::tonal_art_map::TonalArtMap;
use relievo::params::{
    Adaptive, Bend, LineParams, Material, Method, RelightParams, ScalingParams, SearchParams,
    ShapeParams, SpecularParams, StrokeDirections, StrokeScale, Style, Tangent,
};
use relievo::plan::{Available, Goal, Plan, Tone};
use relievo::product::Product;
use relievo::scenes::{ExactScene, Surface};

/// Strokes that the device has kernels for.
pub(super) fn pen() -> LineParams {
    let mut line = LineParams::default();
    line.strokes.style = Style::Pen;
    line
}

/// Asserts that both backends draw the same, and returns the total ink of the CPU's strokes and contours.
#[track_caller]
pub(super) fn assert_drawn(
    name: &str,
    runner: &DeviceRunner,
    frame: &Frame,
    line: LineParams,
    tone: Tone,
) -> [f32; 2] {
    let lamp = lamp();
    let available = Available::in_frame(frame).lit_by(&lamp);
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let plan = Plan::new(Goal::Hatch(tone, line), available, shape, scaling).unwrap();
    let map = (line.strokes.style == Style::Pictures).then(pictures);
    let inputs = PlanInputs {
        art_map: map.as_ref(),
        illumination: Some(&lamp),
        ..PlanInputs::default()
    };
    assert_is_drawing(name, outcomes(runner, &plan, frame, inputs))
}

/// Asserts that a drawing is that of the CPU, and gives the ink of its strokes and contours in all.
#[track_caller]
fn assert_is_drawing(name: &str, made: [Outcome; 2]) -> [f32; 2] {
    use Product::{Contours, Picture, Strokes};
    assert_alike(name, &made[0], &made[1], |product| {
        matches!(product, Picture | Strokes | Contours)
    });
    let [found, expected] = made.map(|outcome| outcome.drawing.unwrap());
    let white = [&found, &expected].map(|drawing| drawing.white_point);
    assert!(
        (white[0] / white[1] - 1.0).abs() < 1e-5,
        "{name}: {white:?}"
    );
    let lines =
        [&found, &expected].map(|drawing| [drawing.contour_lines.len(), drawing.lines.len()]);
    assert_eq!(lines[0], lines[1], "{name}");
    let ink = |plane: &Plane| plane.samples().iter().sum::<f32>();
    let contours = expected.contours.as_ref();
    [ink(&expected.hatching), contours.map_or(0.0, ink)]
}

/// The picture as it is, with its shape brought out, and in new light.
fn tones() -> [(&'static str, Tone); 3] {
    let relight = RelightParams {
        method: Method::Both,
        ..RelightParams::default()
    };
    [
        ("as it is", Tone::Picture),
        ("enhanced", Tone::Enhanced),
        ("in new light", Tone::Relit(relight)),
    ]
}

fn lamp() -> Illumination {
    Illumination {
        directional: vec![DirectionalLight {
            to_light: direction_of(130.0, 35.0),
            intensity: [1.0; 3],
        }],
        ..Illumination::default()
    }
}

/// Lines in three tones, in pictures that are no squares.
fn pictures() -> TonalArtMap {
    let lines = |share: f32| {
        Plane::from_fn(48, 20, |x, y| {
            let way = ((y as f32 + 0.7 * (0.26 * x as f32).sin()) / 5.0).fract();
            (4.0 * (share - (way - 0.5).abs())).clamp(0.0, 1.0)
        })
    };
    TonalArtMap::of_pictures(&[0.1, 0.25, 0.4].map(lines), 0.8)
}

/// A torus before the paper, which has a border and is covered in part at its rim.
fn torus() -> Frame {
    let torus = Surface::torus(45.0, 18.0, DVec3::new(0.3, 0.5, 0.8).normalize());
    let mut frame = with_color(ExactScene::orthographic(torus, 70.0, 66.0).frame(147, 131));
    frame.alpha = Some(Plane::from_fn(147, 131, |x, y| {
        0.3 + 0.1 * ((x * 7 + y * 3) % 8) as f32
    }));
    frame
}

fn settings() -> Vec<(&'static str, LineParams)> {
    let rows: [(_, fn(&mut LineParams)); 7] = [
        ("usual", |_| ()),
        ("pencil", |line| line.strokes.style = Style::Pencil),
        ("pencil both ways, another seed", |line| {
            line.strokes.style = Style::Pencil;
            line.strokes.seed = 1 << 40 | 9;
            line.directions = StrokeDirections::Both;
            line.contours.as_mut().unwrap().width_px = 5.0;
        }),
        ("small in sets", |line| {
            line.strokes.scale = StrokeScale::Factor(0.4);
            line.strokes.sets = 3;
            line.strokes.levels = 7;
            line.directions = StrokeDirections::Both;
        }),
        ("large on one level, dark", |line| {
            line.strokes.scale = StrokeScale::Factor(3.0);
            line.strokes.levels = 1;
            line.directions = StrokeDirections::Min;
            line.tone.white_point = Adaptive::Fixed(1.7);
            line.tone.black_point = 0.2;
            line.tone.gamma = 1.0;
            line.contours = None;
        }),
        ("pictures", |line| line.strokes.style = Style::Pictures),
        ("lines", |line| {
            line.strokes.style = Style::Lines;
            line.directions = StrokeDirections::Max;
        }),
    ];
    let rows = rows.into_iter().map(|(name, change)| {
        let mut params = pen();
        change(&mut params);
        (name, params)
    });
    rows.collect()
}

#[test]
fn styles_families_and_scales() {
    on_gpu(|runner| {
        for (scene, frame) in [("waves", waves(203, 155)), ("torus", torus())] {
            for (name, line) in settings() {
                for (tone_name, tone) in tones() {
                    let name = format!("{scene}, {name}, {tone_name}");
                    let [strokes, contours] = assert_drawn(&name, runner, &frame, line, tone);
                    let pixels = frame.mask.count() as f32;
                    // A single tone under the lamp leaves hardly any paper.
                    let most = [0.95, 1.0][usize::from(tone_name == "in new light")];
                    // Light tones get no lines.
                    let least = [0.05, 0.01][usize::from(line.strokes.style == Style::Lines)];
                    let share = strokes / pixels;
                    assert!(share > least && share < most, "{name}: {share}");
                    let lined = scene == "torus" && line.contours.is_some();
                    assert!(!lined || contours > 100.0, "{name}: {contours}");
                }
            }
        }
    });
}

#[test]
fn sizes_and_masks() {
    on_gpu(|runner| {
        let line = LineParams {
            directions: StrokeDirections::Both,
            ..pen()
        };
        let mut frames: Vec<(String, Frame)> = Vec::new();
        for (width, height) in [(1, 1), (1, 7), (65, 1), (33, 2), (129, 5), (16, 48)] {
            frames.push((format!("{width}x{height}"), waves(width, height)));
        }
        let whole = waves(80, 60);
        for (name, covers) in MASKS {
            frames.push((name.into(), covered_where(&whole, covers, f32::NAN)));
        }
        // Far from the origin, and before it.
        let whole = waves(200, 150);
        let [x, y] = [whole.data_window.x0 + 61, whole.data_window.y0 + 37];
        frames.push(("crop".into(), whole.crop(Window::at(x, y, 90, 70))));
        for origin in [-300, 7000] {
            let mut frame = waves(90, 70);
            frame.data_window = Window::at(origin, -origin, 90, 70);
            frames.push((format!("at {origin}"), frame));
        }
        for (name, frame) in frames {
            assert_drawn(&name, runner, &frame, line, Tone::Enhanced);
        }
    });
}

#[test]
fn colors_that_are_no_numbers_are_black_or_white() {
    on_gpu(|runner| {
        let mut frame = waves(70, 50);
        let color = frame.color.as_mut().unwrap();
        for (i, value) in HOSTILE.into_iter().enumerate() {
            // Whole strokes of them.
            for y in 7 * i..7 * i + 5 {
                color.r.row_mut(y)[10..25].fill(value);
                color.g.row_mut(y)[20..40].fill(value);
                color.b.row_mut(y)[20..60].fill(-value);
            }
        }
        frame.alpha = Some(Plane::from_fn(70, 50, |x, _| match x % 5 {
            0 => f32::NAN,
            1 => 0.0,
            _ => 1.0,
        }));
        for (name, tone) in tones() {
            assert_drawn(name, runner, &frame, pen(), tone);
        }
    });
}

#[test]
fn a_texture_that_was_copied_is_not_taken_for_another() {
    on_gpu(|runner| {
        let frame = waves(80, 60);
        for (name, line) in settings().into_iter().chain(settings()) {
            assert_drawn(name, runner, &frame, line, Tone::Picture);
        }
    });
}

/// A surface that approaches and rotates: its texture is laid anew now and then, and several maps share the drawing.
#[test]
fn strokes_move_with_the_surface() {
    on_gpu(|runner| {
        let whole = torus();
        let motion = Vector2Planes {
            x: Plane::from_fn(147, 131, |x, y| {
                0.07 * (x as f32 - 70.0) + 0.03 * (y as f32 - 60.0)
            }),
            y: Plane::from_fn(147, 131, |x, y| {
                0.05 * (60.0 - y as f32) + 0.03 * (x as f32 - 70.0)
            }),
        };
        let mut holed = motion.clone();
        for (i, value) in HOSTILE.into_iter().enumerate() {
            holed.x.row_mut(9 * i + 30)[30..60].fill(value);
            holed.y.row_mut(9 * i + 31)[50..90].fill(-value);
        }
        // Steps just below the threshold that separates surfaces, and just above.
        let mut stepped = whole.clone();
        for (i, depth) in stepped
            .depth
            .iter_mut()
            .flat_map(Plane::samples_mut)
            .enumerate()
        {
            *depth *= [1.0, 1.06, 1.15][i / 40 % 3];
        }
        let flat = Frame {
            depth: None,
            ..whole.clone()
        };
        let crossed = LineParams {
            directions: StrokeDirections::Both,
            ..pen()
        };
        let mut of_pictures = pen();
        of_pictures.strokes.style = Style::Pictures;
        let map = pictures();
        for (name, frame, motion, line) in [
            ("with depth", &whole, &motion, crossed),
            ("with steps of depth", &stepped, &motion, crossed),
            ("without depth", &flat, &motion, crossed),
            ("motion that is no number", &flat, &holed, crossed),
            ("pictures", &whole, &motion, of_pictures),
        ] {
            let available = Available {
                moving: true,
                ..Available::in_frame(frame)
            };
            let plan = drawing_plan(line, available);
            let mut before: Option<TextureCoordinates> = None;
            let mut most_sheets = 0;
            for number in 0..9 {
                let sequence = SequenceInputs {
                    before: before.as_ref(),
                    motion: Some(motion),
                };
                let inputs = PlanInputs {
                    art_map: Some(&map),
                    sequence: Some(sequence),
                    ..PlanInputs::default()
                };
                let made = outcomes(runner, &plan, frame, inputs);
                let handed_on = |outcome: &Outcome| {
                    let drawing = outcome.drawing.as_ref().unwrap();
                    drawing.coordinates.clone().unwrap()
                };
                let [found, expected] = made.each_ref().map(handed_on);
                most_sheets = expected.mean_shares().len().max(most_sheets);
                assert_eq!(found.mean_shares(), expected.mean_shares(), "{name}");
                assert_is_drawing(&format!("{name}, frame {number}"), made);
                before = Some(expected);
            }
            assert!(most_sheets > 1, "{name}");
        }
    });
}

fn drawing_plan(line: LineParams, available: Available) -> Plan {
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    Plan::new(Goal::Hatch(Tone::Picture, line), available, shape, scaling).unwrap()
}

#[test]
fn what_has_no_kernels_is_named() {
    let frame = torus();
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let seen = Available {
        specular: Some(SpecularParams {
            bend: Bend::Mirror,
            search: SearchParams::default(),
        }),
        ..Available::in_frame(&frame)
    };
    let lit = |material, available| {
        let mut relight = RelightParams::default();
        relight.material.material = material;
        relight.material.tangent = Tangent::Curvature;
        relight.material.coat = [10.0, 200.0];
        let mut kinds = lamp().kinds();
        // A mirror shows no light that is no larger than a point.
        (kinds.directional, kinds.environment) = match material {
            Material::Mirror => (false, true),
            _ => (true, false),
        };
        let available = Available {
            new_light: kinds,
            ..available
        };
        Plan::new(Goal::Relight(relight), available, shape, scaling).unwrap()
    };
    let known = Available::in_frame(&frame);
    let traced = Some("that show what is traced");
    for (plan, expected) in [
        (drawing_plan(pen(), known), None),
        (drawing_plan(pen(), seen), traced),
        (lit(Material::Lambert, known), None),
        (lit(Material::Mirror, seen), traced),
        (
            lit(Material::AshikhminShirley, known),
            Some("a grain along the curvature"),
        ),
    ] {
        let lacks = DeviceRunner::lacks(&plan);
        assert_eq!(lacks.is_some(), expected.is_some(), "{lacks:?}");
        assert!(lacks.is_none_or(|what| what.contains(expected.unwrap())));
    }
}
