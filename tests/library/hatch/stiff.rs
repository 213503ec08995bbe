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
    let contours = |name, width_px| {
        let mut line = usual;
        line.contours.as_mut().unwrap().width_px = width_px;
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
        contours("thin contours", 0.1),
        contours("thick contours", 500.0),
        strokes("no wobble", |s| (s.wobble, s.pressure) = (Some(0.0), Some(0.0))),
    ];
    all
}

fn frames() -> Vec<(&'static str, Frame)> {
    let scene = |surface| ExactScene::orthographic(surface, 20.0, 20.0);
    let ball = scene(Surface::ball(15.0)).frame(40, 40);
    let wall = |width, height| scene(Surface::plane(DVec3::Z)).frame(width, height);
    let part = |mask: fn(usize, usize) -> bool| masked(wall(40, 40), mask);
    let mut bare = ball.clone();
    (bare.depth, bare.alpha, bare.camera) = (None, None, None);
    let deep = |depth: fn(usize, usize) -> f32| Frame {
        depth: Some(Plane::from_fn(40, 40, depth)),
        ..wall(40, 40)
    };
    // Normals that turn by 90 degrees from pixel to pixel.
    let turned = normals(40, 40, |x, y| {
        Vec3::new([0.707, -0.707][(x + y) % 2], 0.0, 0.707)
    });
    let bad = Frame {
        normal: normals(40, 40, |x, _| {
            Vec3::new([0.0, f32::NAN][usize::from(x % 7 == 0)], 0.0, 1.0)
        }),
        alpha: Some(Plane::filled(40, 40, f32::NAN)),
        ..deep(|x, y| [f32::NAN, 1.0, f32::INFINITY, 0.0, -1.0][(x + y) % 5])
    };
    vec![
        ("umbilic everywhere", ball.clone()),
        ("planar everywhere", wall(40, 40)),
        ("nothing covered", part(|_, _| false)),
        ("one pixel covered", part(|x, y| (x, y) == (20, 20))),
        ("checkerboard", part(|x, y| (x + y) % 2 == 0)),
        ("stripes", part(|x, _| x % 2 == 0)),
        ("black", grey(ball.clone(), 0.0)),
        ("white", grey(ball.clone(), 1.0)),
        ("infinitely bright", grey(ball.clone(), f32::INFINITY)),
        ("no number", grey(ball.clone(), f32::NAN)),
        ("normals alone", bare),
        ("poisoned outside", poisoned(&ball, f32::NAN)),
        (
            "crease everywhere",
            Frame {
                normal: turned,
                ..wall(40, 40)
            },
        ),
        (
            "steps everywhere",
            deep(|x, y| if (x / 2 + y / 3) % 2 == 0 { 1.0 } else { 3.0 }),
        ),
        ("bad values", masked(bad, |x, y| x > 10 || y > 20)),
        ("one pixel", wall(1, 1)),
        ("one row", wall(90, 1)),
        ("one column", wall(1, 90)),
    ]
}

/// Forms without an edge.
const PLAIN: [&str; 4] = [
    "planar everywhere",
    "nothing covered",
    "one pixel covered",
    "one pixel",
];

#[test]
fn extremes_are_drawn() {
    let frames = frames();
    for (setting, line) in settings() {
        // One engine for a setting: it keeps the strokes it has made.
        let engine = Engine::cpu();
        for (name, frame) in &frames {
            let drawn = drawn_by(&engine, frame, line);
            let case = format!("{name}, {setting}");
            assert!(is_a_drawing(&drawn), "{case}");
            for line in &drawn.contour_lines {
                let is_sound = |w: &f32| w.is_finite() && *w >= 0.0;
                let are_finite = line.points.iter().all(|p| p.is_finite());
                assert!(
                    are_finite && line.widths.iter().all(is_sound),
                    "{case}: {line:?}"
                );
                assert_eq!(line.points.len(), line.widths.len(), "{case}");
            }
            assert!(
                !PLAIN.contains(name) || drawn.contour_lines.is_empty(),
                "{case}"
            );
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
