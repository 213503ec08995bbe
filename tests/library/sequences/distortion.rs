//! Motion that distorts the texture, and motion that is no motion at all.

use super::*;
use relievo::line::texture_coordinates::{distortion, soundness};

const SIDE: usize = 256;

/// Motion toward or away from the middle: everything becomes `by` times as large.
fn zoom(frame: &Frame, by: f64) -> Vector2Planes {
    let middle = SIDE as f64 / 2.0;
    motion(frame, |x, y| {
        [x, y].map(|at| (at - middle) * (1.0 - 1.0 / by))
    })
}

/// Mean size of drawn features: the inverse of the mean change of ink from pixel to pixel.
fn size(ink: &Plane) -> f64 {
    let change = Plane::from_fn(SIDE - 1, SIDE - 1, |x, y| {
        let here = ink.at(x, y);
        (ink.at(x + 1, y) - here).hypot(ink.at(x, y + 1) - here)
    });
    mean(&change, everywhere).recip()
}

#[test]
fn strokes_keep_their_size_while_the_camera_draws_near_or_away() {
    // Four times as large, or small, in 24 frames.
    for by in [4.0_f64.powf(1.0 / 24.0), 0.25_f64.powf(1.0 / 24.0)] {
        let frame = card([SIDE; 2]);
        let moves = zoom(&frame, by);
        let mut drawing = first(&frame, ruled(30.0));
        let meant = size(&drawing.hatching);
        let mut handed_over = 0;
        for step in 1..=24 {
            drawing = next(&drawing, &frame, &moves, ruled(30.0));
            // A map is drawn up to a distortion of 1.5, less and less from 1.2 on.
            let case = format!("after {step} steps of {by}");
            let times = size(&drawing.hatching) / meant;
            assert!((1.0 / 1.5..1.5).contains(&times), "{times} {case}");
            is_half_inked(&drawing, &case);
            let shares = shares(&drawing);
            near(shares.iter().sum::<f64>(), 1.0, 1e-5, &case);
            handed_over += usize::from(shares.len() > 1);
        }
        assert!(handed_over > 5);
    }
}

#[test]
fn strokes_are_handed_over_a_few_at_a_time() {
    // By 2 % a frame a map goes from a distortion of 1.2 to 1.5 in 11 frames: the smooth step between them is steepest
    // at its middle, 1.5 * 0.02 * 1.35 / 0.3 = 0.135 of the strokes in one frame. In the middle of the picture nothing
    // else changes.
    let frame = card([SIDE; 2]);
    let moves = zoom(&frame, 1.02);
    let mut drawing = first(&frame, ruled(30.0));
    let elsewhere = |x, y| Some([x, (y + 101) % SIDE]);
    let unlike = difference(&drawing.hatching, &drawing.hatching, elsewhere);
    let mut all = 0.0;
    for step in 1..=40 {
        let before = drawing;
        drawing = next(&before, &frame, &moves, ruled(30.0));
        let middle = |at: usize| (SIDE / 2 - 14..SIDE / 2 + 14).contains(&at);
        let changed = difference(&drawing.hatching, &before.hatching, |x, y| {
            (middle(x) && middle(y)).then_some([x, y])
        });
        // Some for the 0.2 px that strokes move there.
        let are_few = changed < 0.25 * unlike;
        assert!(are_few, "{changed} of {unlike} after {step} steps");
        all += changed;
    }
    assert!(all > unlike, "they are handed over: {all}");
}

#[test]
fn a_leap_is_drawn_anew_at_once() {
    // Three times as large in one step: a texture three times too large serves no more at all.
    let third = [[1.0 / 3.0, 0.0], [0.0, 1.0 / 3.0]];
    assert_eq!(soundness(distortion(&third)), 0.0);
    let frame = card([SIDE; 2]);
    let still = first(&frame, ruled(30.0));
    let drawing = next(&still, &frame, &zoom(&frame, 3.0), ruled(30.0));
    let times = size(&drawing.hatching) / size(&still.hatching);
    assert!((0.9..1.1).contains(&times), "{times}");
    assert_eq!(shares(&drawing), [1.0]);
}

#[test]
fn a_ball_that_turns_in_depth_keeps_size_and_tone() {
    // Its surface rotates by 6 degrees a frame about the vertical: new surface keeps appearing at one rim.
    let radius = 110.0_f64;
    let middle = SIDE as f64 / 2.0;
    let frame = cards([SIDE; 2], 0.5, |x, y| {
        let (x, y) = (x as f64 + 0.5 - middle, y as f64 + 0.5 - middle);
        let z = (radius * radius - x * x - y * y).sqrt();
        (z > 0.0).then_some((1000.0 - z) as f32)
    });
    let (sin, cos) = 6.0_f64.to_radians().sin_cos();
    let turn = motion(&frame, |x, y| {
        let (x, y) = (x - middle, y - middle);
        let z = (radius * radius - x * x - y * y).max(0.0).sqrt();
        // It comes from z' = z cos + x sin; surface behind the rim was not visible.
        match z * cos + x * sin > 0.0 {
            true => [x - (x * cos - z * sin), 0.0],
            false => [f64::from(Vector2Planes::AWAY), 0.0],
        }
    });
    let mut drawing = first(&frame, ruled(30.0));
    let meant = size(&drawing.hatching);
    for step in 1..=30 {
        drawing = next(&drawing, &frame, &turn, ruled(30.0));
        let ink = mean(&drawing.hatching, |x, y| frame.mask.at(x, y));
        near(ink, 0.5, 0.02, format_args!("after {step} steps"));
        let times = size(&drawing.hatching) / meant;
        assert!((1.0 / 1.5..1.5).contains(&times), "{times}: step {step}");
    }
}

#[test]
fn without_depth_motion_tells_what_was_hidden() {
    // The card passes as above, known by its motion alone; from the third frame on motion can be compared.
    let mut frame = card([SIDE; 2]);
    frame.depth = None;
    let start = first(&frame, ruled(75.0));
    let mut drawing = first(&frame, ruled(75.0));
    for step in 1..=25 {
        drawing = next(&drawing, &frame, &passage(&frame, step), ruled(75.0));
    }
    // Only surface revealed in the first step may have passed for the card's: 4 columns.
    let front = passing(25);
    let background = |x: usize, y: usize| (!front(x, y) && x > 20).then_some([x, y]);
    let changed = difference(&drawing.hatching, &start.hatching, background);
    assert!(changed < 1e-3, "{changed}");
}

#[test]
fn threads_change_nothing() {
    let frame = card([SIDE; 2]);
    let with = |threads: usize| {
        on_threads(threads, || {
            let mut drawing = first(&frame, ruled(30.0));
            for _ in 0..8 {
                drawing = next(&drawing, &frame, &zoom(&frame, 1.09), ruled(30.0));
            }
            drawing.hatching
        })
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn motion_that_is_no_motion_gives_a_drawing_all_the_same() {
    let (nan, inf, away) = (f32::NAN, f32::INFINITY, Vector2Planes::AWAY);
    let odd = [nan, inf, -inf, away, -1e30, 1e-30, 0.0, 7.25];
    for [width, height] in [[1, 1], [1, 9], [9, 1], [2, 2], [64, 3], [67, 33]] {
        for covered in [0, 1, 3] {
            let mut frame = cards([width, height], 0.4, |x, y| {
                (covered > 0 && (x + y) % covered == 0).then_some(5.0)
            });
            let mut drawing = first(&frame, ruled(30.0));
            for step in 0..6 {
                let any = |x: usize, y: usize| odd[(x * 7 + y * 3 + step) % odd.len()];
                let moves = Vector2Planes {
                    x: Plane::from_fn(width, height, any),
                    y: Plane::from_fn(width, height, |x, y| any(y, x)),
                };
                let depth = frame.depth.as_mut().unwrap();
                depth.samples_mut()[0] = odd[step];
                drawing = next(&drawing, &frame, &moves, ruled(30.0));
                assert!(is_a_drawing(&drawing), "{width}x{height}");
            }
        }
    }
}

#[test]
fn frames_may_change_their_size_and_lose_their_surface() {
    let sized = |size, covered: bool| cards(size, 0.5, move |_, _| covered.then_some(5.0));
    let rest = |frame: &Frame| motion(frame, |_, _| [0.0; 2]);
    let small = sized([40, 30], true);
    let drawing = first(&small, ruled(30.0));
    // Large enough that chance evens out.
    let large = sized([300, 240], true);
    let grown = next(&drawing, &large, &rest(&large), ruled(30.0));
    assert_eq!(grown.hatching, draw(&large, ruled(30.0), None).hatching);
    let nothing = sized([300, 240], false);
    let gone = next(&grown, &nothing, &rest(&nothing), ruled(30.0));
    assert!(gone.hatching.samples().iter().all(|&ink| ink == 0.0));
    // A surface that follows nothing is drawn as new.
    let again = next(&gone, &large, &rest(&large), ruled(30.0));
    is_half_inked(&again, "again");
}
