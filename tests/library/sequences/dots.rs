//! Dots that move with the surface.

use super::*;
use relievo::line::stippling::Dot;

const SIDE: usize = 200;
const MIDDLE: Vec2 = Vec2::splat(SIDE as f32 / 2.0);

fn stippled() -> LineParams {
    let mut line = ruled(0.0);
    line.strokes.style = Style::Stipple;
    line
}

/// Motion of a surface, by where a point of it was.
fn moved(frame: &Frame, from: impl Fn(Vec2) -> Vec2) -> Vector2Planes {
    motion(frame, |x, y| {
        let at = Vec2::new(x as f32, y as f32);
        (at - from(at)).to_array().map(f64::from)
    })
}

/// The dots of `part` that are where `to` leads a dot of `before`, up to a distance, and those that are not.
fn parted(dots: &[Dot], before: &[Dot], to: impl Fn(Vec2) -> Vec2, within: f32) -> [Vec<Dot>; 2] {
    let led: Vec<Vec2> = before.iter().map(|dot| to(dot.at)).collect();
    let is_led = |dot: &&Dot| led.iter().any(|at| at.distance(dot.at) < within);
    let (there, other): (Vec<&Dot>, Vec<&Dot>) = dots.iter().partition(is_led);
    [there, other].map(|dots| dots.into_iter().copied().collect())
}

/// The dots at these places from the middle.
fn within_view(drawing: &Drawing, is_in: impl Fn(Vec2) -> bool) -> Vec<Dot> {
    let dots = drawing.dots.iter().copied();
    dots.filter(|dot| is_in(dot.at - MIDDLE)).collect()
}

#[test]
fn a_pan_moves_every_dot() {
    let (frame, by) = (card([SIDE; 2]), Vec2::new(7.0, -4.25));
    let start = first(&frame, stippled());
    assert_eq!(start.dots, draw(&frame, stippled(), None).dots);
    let mut drawing = first(&frame, stippled());
    let pan = moved(&frame, |at| at - by);
    for step in 1..=4 {
        drawing = next(&drawing, &frame, &pan, stippled());
        let way = step as f32 * by;
        // All that stays in view is where it went, beside a few more in the widest gaps; of what came into view the tone is
        // the same.
        let came = |at: Vec2| at.x < way.x + 1.0 || at.y > SIDE as f32 + way.y - 1.0;
        let stays = |at: Vec2| !came(at) && at.y > 0.0 && at.x < SIDE as f32;
        let there = |dot: &&Dot| stays(dot.at + way);
        let [led, gone] = parted(&start.dots, &drawing.dots, |at| at - way, 1e-3);
        let [led, gone] = [led, gone].map(|dots| dots.iter().filter(there).count());
        let [_, new] = parted(&drawing.dots, &start.dots, |at| at + way, 1e-3);
        let new = new.iter().filter(|dot| stays(dot.at)).count();
        let are_led = led > 3500 && 100 * gone < led && 50 * new < led;
        assert!(are_led, "{led}, not {gone} and {new}");
        let into_view = |x: usize, y: usize| came(Vec2::new(x as f32, y as f32));
        let ink = [&drawing, &start].map(|drawing| mean(&drawing.hatching, into_view));
        assert!((ink[0] - ink[1]).abs() < 0.02, "{ink:?}");
    }
}

#[test]
fn dots_of_a_disc_turn_with_it() {
    // By 5 degrees a frame, a right angle in all.
    let frame = cards([SIDE; 2], 0.5, |x, y| {
        let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        (at.distance(MIDDLE) < 90.0).then_some(3.0)
    });
    let turned = |at: Vec2, degrees: f32| {
        MIDDLE + Vec2::from_angle(degrees.to_radians()).rotate(at - MIDDLE)
    };
    let turn = moved(&frame, |at| turned(at, -5.0));
    let start = first(&frame, stippled());
    let mut drawing = first(&frame, stippled());
    for _ in 0..18 {
        drawing = next(&drawing, &frame, &turn, stippled());
    }
    // Motion is that of the nearest pixel, up to 0.71 pixels away: 0.062 off in a frame, and 0.26 in 18 if these errors are
    // independent. At the rim, dots go where none of the surface is.
    let inner = within_view(&drawing, |from| from.length() < 85.0);
    let [led, new] = parted(&inner, &start.dots, |at| turned(at, 90.0), 0.6);
    assert!(20 * new.len() < led.len(), "{} of {}", new.len(), led.len());
    let [led, _] = parted(&inner, &start.dots, |at| at, 0.6);
    assert!(2 * led.len() < inner.len());
}

#[test]
fn dots_come_and_go_as_the_camera_draws_near_or_away() {
    // Four times as large, or small, in 24 frames.
    for by in [4.0_f32.powf(1.0 / 24.0), 0.25_f32.powf(1.0 / 24.0)] {
        let frame = card([SIDE; 2]);
        let to = |at: Vec2| MIDDLE + by * (at - MIDDLE);
        let zoom = moved(&frame, |at| MIDDLE + (at - MIDDLE) / by);
        let median = |dots: &[Dot]| {
            let radii = sorted(dots.iter().map(|dot| dot.radius.into()));
            radii[radii.len() / 2] as f32
        };
        let mut drawing = first(&frame, stippled());
        let meant = median(&drawing.dots);
        for step in 1..=24 {
            let now = next(&drawing, &frame, &zoom, stippled());
            let before = std::mem::replace(&mut drawing, now);
            let case = format!("after {step} steps of {by}");
            is_half_inked(&drawing, &case);
            // Dots stay down to 0.6 of the distance they are to have, and come from 0.835 of it on. They take four frames to
            // grow, two on average, in which the others grow by 1.06^2: 1.12/0.835 = 1.35.
            let times = median(&drawing.dots) / meant;
            assert!((0.6..1.35).contains(&times), "{times} {case}");
            // Away from the border new dots are small: half the radius, more where ink is short.
            let within = by.min(1.0) * (SIDE as f32 / 2.0 - 6.0);
            let seen = within_view(&drawing, |from| from.abs().max_element() < within);
            let [led, new] = parted(&seen, &before.dots, to, 0.1);
            let [old, fresh] = [led.len(), new.len()];
            assert!(5 * fresh < old, "{fresh} beside {old} {case}");
            let is_small = |dot: &Dot| dot.radius < 0.85 * median(&led);
            assert!(new.iter().all(is_small), "{case}");
        }
    }
}
