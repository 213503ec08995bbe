//! Frames and settings at their extremes: a drawing or a refusal, never a NaN.

use super::*;

/// Strokes at the ends of their ranges, and every style.
fn settings() -> Vec<(&'static str, LineParams)> {
    let usual = default_but(|line: &mut LineParams| line.directions = StrokeDirections::Both);
    let strokes = |name, change: fn(&mut StrokeParams)| {
        let mut line = usual;
        change(&mut line.strokes);
        (name, line)
    };
    let mut fine = usual;
    (fine.field.cell_px, fine.field.passes, fine.field.radius_px) = (1, 6, 64.0);
    #[rustfmt::skip]
    let all = vec![
        ("usual", usual),
        ("a field as fine as the picture", fine),
        strokes("narrower than a pixel", |s| s.scale = StrokeScale::Factor(0.1)),
        strokes("wider than the picture", |s| s.scale = StrokeScale::Factor(500.0)),
        strokes("8 sets of 360 levels", |s| (s.levels, s.sets) = (360, 8)),
        strokes("one level", |s| s.levels = 1),
        strokes("hairs far apart", |s| (s.width_px, s.spacing_px) = (Some(0.05), Some(1000.0))),
        strokes("dots for strokes", |s| (s.width_px, s.length_px) = (Some(100.0), Some(1.0))),
        strokes("8 sets of a pencil", |s| (s.style, s.sets) = (Style::Pencil, 8)),
        strokes("lines", |s| s.style = Style::Lines),
        strokes("engraving", |s| s.style = Style::Engraving),
        strokes("stipple", |s| s.style = Style::Stipple),
        strokes("no wobble", |s| (s.wobble, s.pressure) = (Some(0.0), Some(0.0))),
    ];
    all
}

fn frames() -> Vec<(&'static str, Frame)> {
    let scene = |surface| ExactScene::orthographic(surface, 20.0, 20.0);
    let ball = scene(Surface::ball(15.0)).frame(40, 40);
    let plane = scene(Surface::plane(DVec3::Z)).frame(40, 40);
    let even = |luminance| grey(scene(Surface::ball(15.0)).frame(40, 40), luminance);
    let mut bare = ball.clone();
    (bare.depth, bare.alpha, bare.camera) = (None, None, None);
    vec![
        ("umbilic everywhere", ball.clone()),
        ("planar everywhere", plane),
        ("nothing covered", masked(ball.clone(), |_, _| false)),
        (
            "one pixel covered",
            masked(ball.clone(), |x, y| (x, y) == (20, 20)),
        ),
        ("black", even(0.0)),
        ("white", even(1.0)),
        ("infinitely bright", even(f32::INFINITY)),
        ("no number", even(f32::NAN)),
        ("normals alone", bare),
        ("poisoned outside", poisoned(&ball, f32::NAN)),
        ("one pixel", scene(Surface::plane(DVec3::Z)).frame(1, 1)),
        ("one row", scene(Surface::plane(DVec3::Z)).frame(90, 1)),
        ("one column", scene(Surface::plane(DVec3::Z)).frame(1, 90)),
    ]
}

#[test]
fn extremes_are_drawn() {
    let frames = frames();
    for (setting, line) in settings() {
        // One engine for a setting: it keeps the strokes it has made.
        let engine = Engine::cpu();
        for (name, frame) in &frames {
            let drawn = drawn_by(&engine, frame, line);
            assert!(is_a_drawing(&drawn), "{name}, {setting}");
        }
    }
}

#[test]
fn what_lies_outside_the_mask_changes_nothing() {
    let frame = ExactScene::orthographic(Surface::ball(15.0), 20.0, 20.0).frame(40, 40);
    let clean = drawing(&frame, LineParams::default());
    for poison in [f32::NAN, f32::INFINITY, -1e30] {
        let other = drawing(&poisoned(&frame, poison), LineParams::default());
        assert_eq!(clean.hatching, other.hatching);
        assert_eq!(clean.contours, other.contours);
    }
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let refused = |change: fn(&mut LineParams), name: &str| {
        let mut line = LineParams::default();
        change(&mut line);
        let said = line.validate().unwrap_err().to_string();
        assert!(said.starts_with(name), "{said}");
    };
    refused(|l| l.strokes.levels = 0, "--levels");
    refused(|l| l.strokes.levels = 361, "--levels");
    refused(|l| l.strokes.sets = 9, "--sets");
    let scale = "--stroke-scale";
    refused(|l| l.strokes.scale = StrokeScale::Factor(0.0), scale);
    refused(
        |l| l.strokes.scale = StrokeScale::Millimetres(f32::NAN),
        scale,
    );
    refused(|l| l.strokes.dpi = Some(-1.0), "--dpi");
    refused(|l| l.strokes.wobble = Some(2.0), "--wobble");
    refused(|l| l.tone.black_point = 1.0, "--black-point");
    refused(|l| l.tone.gamma = f32::NAN, "--tone-gamma");
}
