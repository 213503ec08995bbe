//! With a reference height a look survives resolution: the same scene at 270, 540 and 1080 lines.
//!
//! Lengths are in pixels at the reference height of 540 lines. Results are compared with the closed form, so the bounds
//! also hold between any two resolutions, added up.

use crate::prelude::*;

const REFERENCE: u32 = 540;
const LINES: [usize; 3] = [270, 540, 1080];
const GAIN: f32 = 30.0;

/// The scale of most tests, in pixels at the reference height.
const SIGMA: f64 = 12.0;

/// Pixels per reference pixel in a picture of `lines` lines.
fn factor(lines: usize) -> f64 {
    lines as f64 / f64::from(REFERENCE)
}

fn settings(reference_height: Option<u32>, scale: Scale) -> ShapeParams {
    ShapeParams {
        reference_height,
        scale,
        foreshortening: 1.0,
        tolerance: 1e-6,
        ..ShapeParams::default()
    }
}

fn described(frame: &Frame, shape: ShapeParams, gain: Adaptive) -> Outcome {
    let scaling = default_but(|scaling: &mut ScalingParams| scaling.curvature_gain = gain);
    let plan = Plan::new(Goal::LAYERS, Available::in_frame(frame), shape, scaling).unwrap();
    cpu::run(&plan, frame).unwrap()
}

// Waves: everything about them decays as a known factor -------------------------------------------

const AMPLITUDE: f64 = 3.0;
/// Wave number per pixel of the reference: waves of 64 pixels, 32 at 270 lines.
const K: f64 = std::f64::consts::TAU / 64.0;
const ANGLE: f64 = 0.7;

/// The waves, half as wide as high, with the normals of their slopes.
fn waves(lines: usize) -> Frame {
    let (width, scale) = (lines / 2, factor(lines));
    let relief = Surface::sine_relief(AMPLITUDE, std::f64::consts::TAU / K, ANGLE);
    let mut frame =
        ExactScene::orthographic(Surface::plane(DVec3::Z), 0.0, 0.0).frame(width, lines);
    frame.normal = Vector3Planes::from_fn(width, lines, |x, y| {
        let (slope, _) = relief.derivatives(position(x, y, scale).extend(0.0));
        slope.normalize()
    });
    frame
}

/// Position of a pixel's centre, in pixels of the reference, y up.
fn position(x: usize, y: usize, scale: f64) -> DVec2 {
    DVec2::new(x as f64 + 0.5, -(y as f64 + 0.5)) / scale
}

/// The largest error of kappa on the waves, away from the border by five sigma.
///
/// The height a sin(w.p) has the trace -a k^2 sin(w.p), and a Gaussian of sigma s multiplies it by
/// e^(-k^2 s^2 / 2).
fn wave_error(lines: usize, sigma: f64, shape: ShapeParams) -> f64 {
    let outcome = described(&waves(lines), shape, Adaptive::Fixed(GAIN));
    let kappa = outcome.shape.kappa.unwrap();
    let wave = DVec2::from_angle(ANGLE) * K;
    let peak = AMPLITUDE * K * K * (-0.5 * (K * sigma).powi(2)).exp();
    let border = (5.0 * sigma * factor(lines)) as usize;
    let inner = places(kappa.width() - 2 * border, kappa.height() - 2 * border);
    let errors = inner.map(|(x, y)| {
        let (x, y) = (x + border, y + border);
        let at = position(x, y, factor(lines));
        let expected = (f64::from(GAIN) * peak * wave.dot(at).sin()).tanh();
        (f64::from(kappa.at(x, y)) - expected).abs()
    });
    errors.fold(0.0, f64::max)
}

/// Largest error of kappa against the closed form at `lines` lines, at least 0.0061.
///
/// Per pixel the wave number is q = K / factor. Sobel's kernel gives sin(q_x)(1 + cos q_y)/2 for q_x: the trace is low
/// by at most 5/24 q^2. Diffusion for a time t decays with 2(1 - cos q) for q^2, off by t q^4/12, and a step of dt by t
/// q^4 dt/2 more. A relative error e of x moves tanh(x) by at most max(x sech^2 x) e = 0.448 e. Rounding and the
/// expansion add less than 3e-4.
fn allowed(lines: usize, sigma: f64) -> f64 {
    let q = K / factor(lines);
    let time = 0.5 * (sigma * factor(lines)).powi(2);
    let relative = 5.0 / 24.0 * q.powi(2) + time * q.powi(4) * (1.0 / 12.0 + 0.5 * 0.2);
    0.448 * relative + 3e-4
}

#[test]
fn waves_keep_their_kappa_at_every_resolution() {
    // 180 steps of 0.2 are a time of 36, a sigma of sqrt(72): 45 steps at 270 lines, 720 at 1080.
    for (scale, sigma) in [
        (Scale::Sigma(SIGMA as f32), SIGMA),
        (Scale::Iterations(180), 72.0_f64.sqrt()),
    ] {
        for lines in LINES {
            let error = wave_error(lines, sigma, settings(Some(REFERENCE), scale));
            let limit = allowed(lines, sigma);
            assert!(
                error < limit,
                "{scale:?}, {lines} lines: {error}, not {limit}"
            );
        }
    }
}

#[test]
fn without_a_reference_kappa_follows_resolution() {
    let own = settings(None, Scale::Sigma(SIGMA as f32));
    assert!(wave_error(540, SIGMA, own) < allowed(540, SIGMA));
    for lines in [270, 1080] {
        let error = wave_error(lines, SIGMA, own);
        let bound = 10.0 * allowed(lines, SIGMA);
        assert!(error > bound, "{lines} lines: {error}");
    }
}

#[test]
fn the_gain_chosen_is_the_same_at_every_resolution() {
    // A mean of the trace, whose relative error `allowed` derives, 1.3 % at the most.
    let gain = |lines, reference| {
        let shape = settings(reference, Scale::Sigma(SIGMA as f32));
        let outcome = described(&waves(lines), shape, Adaptive::Auto);
        outcome.gain.unwrap()
    };
    let expected = gain(540, Some(REFERENCE));
    for lines in LINES {
        let ratio = gain(lines, Some(REFERENCE)) / expected;
        assert!((ratio - 1.0).abs() < 0.015, "{lines} lines: times {ratio}");
    }
    assert!((gain(270, None) / expected - 1.0).abs() > 0.2);
}

// Balls: edges, and a curvature that diffusion keeps --------------------------------------------

const NEAR: f64 = 110.0;
const FAR: f64 = 170.0;

fn balls(lines: usize) -> ExactScene {
    let scale = factor(lines);
    let [sx, sy, cx, cy] = [1.0, 1.0, 270.0, 270.0].map(|length| length * scale);
    ExactScene {
        projection: Projection::Orthographic { sx, sy, cx, cy },
        ..ExactScene::two_balls(NEAR, FAR, 0.0, 0.0)
    }
}

/// The ball seen at a position of the picture at the reference height and all around it.
fn well_inside(scene: &ExactScene, x: f64, y: f64, margin: f64) -> Option<usize> {
    let seen = |x, y| scene.exact_at(x, y).map(|exact| exact.surface);
    let here = seen(x, y)?;
    let around = (0..24).map(|i| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 24.0));
    let mut seen = around.map(|u| seen(x + margin * u.x, y + margin * u.y));
    seen.all(|other| other == Some(here)).then_some(here)
}

#[test]
fn balls_keep_their_kappa_at_every_resolution() {
    // Without foreshortening the gradient on a ball is linear: the trace is -2/R however far it is
    // diffused. Six sigma from an edge it adds e^-18; slopes are within 1e-6 of exact, so the trace
    // within 4e-6 at a factor of 2 and kappa, at a gain of 30, within 2e-4. Edges are jumps across one
    // pixel: at 270 lines the steep rim of the nearer ball is one from 24 pixels inside its outline on.
    let sigma = 4.0;
    let shape = ShapeParams {
        foreshortening: 0.0,
        ..settings(Some(REFERENCE), Scale::Sigma(sigma as f32))
    };
    let scene = balls(540);
    let inside = places(54, 54).filter_map(|(x, y)| {
        let (x, y) = (10.0 * x as f64 + 5.3, 10.0 * y as f64 + 4.7);
        Some((x, y, well_inside(&scene, x, y, 24.0 + 6.0 * sigma)?))
    });
    let inside: Vec<_> = inside.collect();
    assert!(inside.len() > 300, "only {} places", inside.len());
    for lines in LINES {
        let frame = balls(lines).frame(lines, lines);
        let outcome = described(&frame, shape, Adaptive::Fixed(GAIN));
        let kappa = outcome.shape.kappa.unwrap();
        for &(x, y, ball) in &inside {
            let radius = [NEAR, FAR][ball];
            let expected = (f64::from(GAIN) * 2.0 / radius).tanh();
            let pixel = |v: f64| (v * factor(lines)) as usize;
            let found = f64::from(kappa.at(pixel(x), pixel(y)));
            let case = format_args!("{lines} lines, ({x}, {y})");
            near(found, expected, 2e-4, case);
        }
    }
}

// The height that the reference refers to ----------------------------------------------------

#[test]
fn the_picture_at_its_reference_height_keeps_its_bits() {
    let frame = balls(270).frame(270, 270);
    let shape = |reference| settings(reference, Scale::Iterations(30));
    let [plain, referred] = [None, Some(270)].map(|r| described(&frame, shape(r), Adaptive::Auto));
    assert_eq!(plain.gain, referred.gain);
    assert_eq!(plain.shape.kappa, referred.shape.kappa);
    assert_eq!(plain.shape.gradient, referred.shape.gradient);
}

#[test]
fn a_crop_counts_the_lines_of_the_whole_picture() {
    let shape = settings(Some(REFERENCE), Scale::Sigma(4.0));
    let whole = waves(270);
    let part = Window::at(0, 40, 135, 160);
    let cropped = whole.crop(part);
    // The display needs the inputs of kappa; layers also need directions, from farther away.
    let plan = |frame| cpu::plan(Goal::Display, frame, shape).unwrap();
    assert_eq!(plan(&cropped).resolution_factor, 0.5);
    let reach = plan(&cropped).reach();
    let gain = Adaptive::Fixed(GAIN);
    let [all, some] = [&whole, &cropped].map(|f| described(f, shape, gain).shape.kappa.unwrap());
    for y in reach..160 - reach {
        assert_eq!(all.row(y + 40), some.row(y), "row {y}");
    }
    assert!(160 > 2 * reach + 50, "the reach is {reach}");
}
