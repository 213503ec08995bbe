//! The texture of strokes, and how it is pasted.

use super::*;

/// Sizes large enough that chance evens out: several periods of the texture.
const PAPER: [usize; 2] = [1024, 512];

/// White left of paper of this size, hatched along this angle in radians in this even tone, by strokes that are changed so.
fn strokes(change: impl FnOnce(&mut StrokeParams)) -> impl Fn([usize; 2], f32, f32) -> Plane {
    let params = default_but(change);
    let map = map(&params);
    move |size, angle, tone| hatched(&Hatching::new(&map, &params, 0), size, angle, |_, _| tone)
}

#[test]
fn a_constant_tone_is_drawn_as_dark_as_it_is() {
    for (style, sets) in STYLES.map(|style| [(style, 1), (style, 2)]).concat() {
        let paper = strokes(|params| (params.style, params.sets) = (style, sets));
        // On a level, and between levels: 11.25 degrees apart.
        for angle in [0.0_f32, 33.75, 39.0, 95.6, 177.0] {
            for tone in [0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98_f32] {
                let white = mean(&paper(PAPER, angle.to_radians(), tone));
                near(
                    white,
                    tone,
                    0.02,
                    format_args!("{style:?}, {sets} sets, {angle} degrees"),
                );
            }
        }
    }
}

#[test]
fn a_ramp_is_drawn_as_it_runs() {
    for style in STYLES {
        let params = default_but(|params: &mut StrokeParams| params.style = style);
        let map = map(&params);
        let hatching = Hatching::new(&map, &params, 0);
        let [width, height] = PAPER;
        let tone = |x: usize| 1.0 - (x as f32 + 0.5) / width as f32;
        let mut errors = Vec::new();
        for angle in [0.3_f32, 1.2, 2.5] {
            let white = hatched(&hatching, PAPER, angle, |x, _| tone(x));
            // Means over 32 columns, a twentieth of the ramp and less, show it as an eye sees it.
            for from in (0..width).step_by(32) {
                let columns = from..from + 32;
                let drawn = white.rows_within(columns.clone(), 0..height);
                let drawn: f32 = drawn.flatten().sum();
                let asked: f32 = columns.map(tone).sum();
                errors.push((drawn / (32 * height) as f32 - asked / 32.0).abs());
            }
        }
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        assert!(mean < 0.02, "{style:?}: mean error {mean:.4}");
    }
}

#[test]
fn white_stays_and_darker_tones_keep_the_strokes_of_lighter_ones() {
    for style in STYLES {
        let paper = strokes(|params| params.style = style);
        let all = |tone: f32| paper([200, 50], 0.7, tone);
        assert!(all(1.0).samples().iter().all(|&white| white == 1.0));
        assert!(all(0.0).samples().iter().all(|&white| white == 0.0));
        let mut lighter = paper([256, 256], 0.4, 0.99);
        for tone in (1..20).rev().map(|i| i as f32 / 20.0) {
            let darker = paper([256, 256], 0.4, tone);
            let mut pairs = darker.samples().iter().zip(lighter.samples());
            assert!(pairs.all(|(d, l)| d <= l), "{style:?} at {tone}");
            lighter = darker;
        }
    }
}

#[test]
fn strokes_run_along_their_angle_and_are_not_mirrored() {
    for style in STYLES {
        // Levels every 15 degrees: 0, 30, 90 and 150 are levels, 37 is not.
        let paper = strokes(|params| (params.style, params.levels) = (style, 12));
        for angle in [0.0_f64, 30.0, 90.0, 150.0, 37.0] {
            let white = paper([512, 512], angle.to_radians() as f32, 0.6);
            let found = stroke_angle(&blurred(&white), |_, _| true);
            let off = apart(found, angle);
            assert!(off < 1.0, "{style:?}: {angle} drawn as {found:.2}");
        }
    }
}

#[test]
fn there_is_no_seam_where_half_a_turn_begins_again() {
    for (levels, sets) in [(16, 1), (12, 2), (1, 1), (7, 3)] {
        let paper = strokes(|params| (params.levels, params.sets) = (levels, sets));
        let ends = [1e-5, std::f32::consts::PI - 1e-5];
        let [first, last] = ends.map(|angle| paper([256, 128], angle, 0.5));
        // 2e-5 radians of 16 levels is 1e-4 of a level: no ink changes by more than its ramp allows.
        let most = crate::common::apart(&first, &last);
        assert!(most < 0.05, "{levels} levels, {sets} sets: {most}");
    }
}

#[test]
fn the_texture_repeats_without_a_seam() {
    for style in STYLES {
        let paper = strokes(|params| params.style = style);
        let map = map(&default_but(|params: &mut StrokeParams| {
            params.style = style
        }));
        let period = (map.period()[0] as f32 / map.texels_per_px()).round() as usize;
        let white = paper([2 * period, period + 20], 0.0, 0.5);
        // The same ink a period farther, except for the rounding of coordinates.
        for (x, y) in places(period, 20) {
            for farther in [white.at(x + period, y), white.at(x, y + period)] {
                near(
                    white.at(x, y),
                    farther,
                    0.02,
                    format_args!("{style:?} ({x}, {y})"),
                );
            }
        }
    }
}

#[test]
fn a_seed_is_one_drawing_and_another_is_another() {
    for style in STYLES {
        let change = |seed| move |p: &mut StrokeParams| (p.style, p.seed) = (style, seed);
        let of = |seed| strokes(change(seed))([256, 128], 0.4, 0.5);
        let (one, other) = (of(7), of(8));
        assert_eq!(one, of(7));
        let pairs = one.samples().iter().zip(other.samples());
        let differ = pairs.filter(|(a, b)| (*a - *b).abs() > 0.1).count();
        // Either inks half of the paper: independent drawings differ on half of it, as far as their greys do.
        assert!(differ > one.samples().len() / 4, "{style:?}: {differ}");
    }
}

#[test]
fn strokes_of_any_size_and_number_keep_their_tone() {
    use StrokeScale::Factor;
    for style in STYLES {
        for (scale, levels, size) in [
            (Factor(0.1), 16, PAPER),
            (Factor(4.0), 16, [2048, 2048]),
            (Factor(1.0), 1, PAPER),
            (Factor(1.0), 360, PAPER),
        ] {
            let change =
                |p: &mut StrokeParams| (p.style, p.scale, p.levels) = (style, scale, levels);
            let paper = strokes(change);
            let white = mean(&paper(size, 0.8, 0.6));
            near(
                white,
                0.6,
                0.02,
                format_args!("{style:?} {scale:?} {levels}"),
            );
        }
        // One stroke is wider than the paper: no meaningful tone, but drawn.
        let paper = strokes(|params| (params.style, params.scale) = (style, Factor(500.0)));
        let white = paper(PAPER, 0.8, 0.6);
        assert!(white.samples().iter().all(|v| (0.0..=1.0).contains(v)));
    }
}

#[test]
fn millimetres_are_those_of_the_print() {
    let mut params = StrokeParams::default();
    (params.scale, params.dpi) = (StrokeScale::Millimetres(0.254), Some(600.0));
    // 0.254 mm are a hundredth of an inch: 6 pixels of 600, for any reference height.
    for factor in [1.0, 3.0] {
        assert!((params.stroke(factor).width_px - 6.0).abs() < 1e-4);
    }
    let own = params.style.stroke();
    let ratio = params.stroke(1.0).length_px / own.length_px;
    assert!((ratio - 6.0 / own.width_px).abs() < 1e-4);
}

#[test]
fn pictures_of_strokes_keep_their_tone_too() {
    // Lines of 1, 2 and 4 rows in 8, in no order: inks 1/8, 1/2, 1/4.
    let lines = |rows: usize| Plane::from_fn(48, 40, move |_, y| f32::from(u8::from(y % 8 < rows)));
    let map = TonalArtMap::of_pictures(&[lines(1), lines(4), lines(2)], 1.0);
    let params = default_but(|params: &mut StrokeParams| params.style = Style::Pictures);
    let hatching = Hatching::new(&map, &params, 0);
    for tone in [0.05, 0.3, 0.5, 0.6, 0.95_f32] {
        for angle in [0.0_f32, 0.6, 1.6] {
            let white = hatched(&hatching, PAPER, angle, |_, _| tone);
            let error = mean(&white) - f64::from(tone);
            assert!(error.abs() < 0.02, "{angle}: {tone} drawn {error:+.4}");
        }
    }
    let white = hatched(&hatching, [256, 256], 33.75_f32.to_radians(), |_, _| 0.5);
    assert!(apart(stroke_angle(&blurred(&white), |_, _| true), 33.75) < 1.0);
}
