//! The texture of strokes, and how it is pasted.

use super::*;

/// Sizes large enough that chance evens out: several periods of the texture.
const PAPER: [usize; 2] = [1024, 512];

/// Strokes of this style.
fn of_style(style: Style) -> StrokeParams {
    default_but(|params: &mut StrokeParams| params.style = style)
}

#[test]
fn a_constant_tone_is_drawn_as_dark_as_it_is() {
    for style in STYLES {
        for sets in [1, 2] {
            let mut params = of_style(style);
            params.sets = sets;
            let map = map(&params);
            let hatching = Hatching::new(&map, &params, 0);
            // On a level, and between levels: 11.25 degrees apart.
            for angle in [0.0_f32, 33.75, 39.0, 95.6, 177.0] {
                for tone in [0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98_f32] {
                    let white = hatched(&hatching, PAPER, angle.to_radians(), |_, _| tone);
                    let error = mean(&white) - f64::from(tone);
                    let case = format!("{style:?}, {sets} sets, {angle} degrees: {tone}");
                    assert!(error.abs() < 0.02, "{case} drawn {error:+.4}");
                }
            }
        }
    }
}

#[test]
fn a_ramp_is_drawn_as_it_runs() {
    for style in STYLES {
        let params = of_style(style);
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
                let drawn: f32 = white
                    .rows_within(columns.clone(), 0..height)
                    .flatten()
                    .sum();
                let asked: f32 = columns.map(tone).sum();
                errors.push((drawn / (32 * height) as f32 - asked / 32.0).abs());
            }
        }
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        assert!(mean < 0.02, "{style:?}: mean error {mean:.4}");
    }
}

#[test]
fn nothing_is_drawn_on_white_and_black_is_black() {
    for style in STYLES {
        let params = of_style(style);
        let map = map(&params);
        let hatching = Hatching::new(&map, &params, 0);
        let all = |tone: f32| hatched(&hatching, [200, 50], 0.7, |_, _| tone);
        assert!(all(1.0).samples().iter().all(|&white| white == 1.0));
        assert!(all(0.0).samples().iter().all(|&white| white == 0.0));
    }
}

#[test]
fn darker_tones_keep_the_strokes_of_lighter_ones() {
    for style in STYLES {
        let params = of_style(style);
        let map = map(&params);
        let hatching = Hatching::new(&map, &params, 0);
        let mut lighter = hatched(&hatching, [256, 256], 0.4, |_, _| 0.99);
        for tone in (1..20).rev().map(|i| i as f32 / 20.0) {
            let darker = hatched(&hatching, [256, 256], 0.4, |_, _| tone);
            let pairs = darker.samples().iter().zip(lighter.samples());
            let mut pairs = pairs.into_iter();
            assert!(pairs.all(|(d, l)| d <= l), "{style:?} at {tone}");
            lighter = darker;
        }
    }
}

#[test]
fn strokes_run_along_their_angle_and_are_not_mirrored() {
    for style in STYLES {
        // Levels every 15 degrees: 0, 30, 90 and 150 are levels, 37 is not.
        let mut params = of_style(style);
        params.levels = 12;
        let map = map(&params);
        let hatching = Hatching::new(&map, &params, 0);
        for angle in [0.0_f64, 30.0, 90.0, 150.0, 37.0] {
            let white = hatched(&hatching, [512, 512], angle.to_radians() as f32, |_, _| 0.6);
            let found = stroke_angle(&blurred(&white), |_, _| true);
            let off = apart(found, angle);
            assert!(off < 1.0, "{style:?}: {angle} drawn as {found:.2}");
        }
    }
}

#[test]
fn there_is_no_seam_where_half_a_turn_begins_again() {
    for (levels, sets) in [(16, 1), (12, 2), (1, 1), (7, 3)] {
        let params = default_but(|p: &mut StrokeParams| (p.levels, p.sets) = (levels, sets));
        let map = map(&params);
        let hatching = Hatching::new(&map, &params, 0);
        let drawn = |angle: f32| hatched(&hatching, [256, 128], angle, |_, _| 0.5);
        let (first, last) = (drawn(1e-5), drawn(std::f32::consts::PI - 1e-5));
        // 2e-5 radians of 16 levels is 1e-4 of a level: no ink changes by more than its ramp allows.
        let most = crate::common::apart(&first, &last);
        assert!(most < 0.05, "{levels} levels, {sets} sets: {most}");
    }
}

#[test]
fn the_texture_repeats_without_a_seam() {
    for style in STYLES {
        let params = of_style(style);
        let map = map(&params);
        let hatching = Hatching::new(&map, &params, 0);
        let period = (map.period()[0] as f32 / map.texels_per_px()).round() as usize;
        let white = hatched(&hatching, [2 * period, period + 20], 0.0, |_, _| 0.5);
        // The same ink a period farther, except for the rounding of coordinates.
        for (x, y) in places(period, 20) {
            let a = white.at(x, y);
            for b in [white.at(x + period, y), white.at(x, y + period)] {
                assert!((a - b).abs() < 0.02, "{style:?} ({x}, {y}): {a} {b}");
            }
        }
    }
}

#[test]
fn a_seed_is_one_drawing_and_another_is_another() {
    for style in STYLES {
        let drawn = |seed| {
            let mut params = of_style(style);
            params.seed = seed;
            let map = map(&params);
            let hatching = Hatching::new(&map, &params, 0);
            hatched(&hatching, [256, 128], 0.4, |_, _| 0.5)
        };
        assert_eq!(drawn(7), drawn(7));
        let (one, other) = (drawn(7), drawn(8));
        let pairs = one.samples().iter().zip(other.samples());
        let differ = pairs.filter(|(a, b)| (*a - *b).abs() > 0.1).count();
        // Either inks half of the paper: independent drawings differ on half of it, as far as their greys do.
        assert!(differ > one.samples().len() / 4, "{style:?}: {differ}");
    }
}

#[test]
fn strokes_of_any_size_and_number_keep_their_tone() {
    let (few, many) = (StrokeScale::Factor(0.1), StrokeScale::Factor(500.0));
    for style in STYLES {
        for (scale, levels, paper) in [
            (few, 16, PAPER),
            (StrokeScale::Factor(4.0), 16, [2048, 2048]),
            (StrokeScale::Factor(1.0), 1, PAPER),
            (StrokeScale::Factor(1.0), 360, PAPER),
        ] {
            let mut params = of_style(style);
            (params.scale, params.levels) = (scale, levels);
            let map = map(&params);
            let hatching = Hatching::new(&map, &params, 0);
            let white = hatched(&hatching, paper, 0.8, |_, _| 0.6);
            let error = (mean(&white) - 0.6).abs();
            assert!(error < 0.02, "{style:?} {scale:?} {levels}: {error:.4}");
        }
        // One stroke is wider than the paper: no meaningful tone, but drawn.
        let mut params = of_style(style);
        params.scale = many;
        let map = map(&params);
        let white = hatched(&Hatching::new(&map, &params, 0), PAPER, 0.8, |_, _| 0.6);
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
    let params = of_style(Style::Pictures);
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
