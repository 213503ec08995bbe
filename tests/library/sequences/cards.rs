//! Cards that are shifted and rotated: their strokes move with them, and no others appear.

use super::*;

const SIZE: [usize; 2] = [400, 280];

/// Previous position of a pixel whose surface moved by whole columns and rows.
fn shifted(columns: isize, rows: isize) -> impl Fn(usize, usize) -> Option<[usize; 2]> {
    move |x, y| {
        let (u, v) = (x as isize - columns, y as isize - rows);
        let inside = (0..SIZE[0] as isize).contains(&u) && (0..SIZE[1] as isize).contains(&v);
        inside.then_some([u as usize, v as usize])
    }
}

#[test]
fn a_first_frame_is_the_still_drawing() {
    let frame = card(SIZE);
    let still = draw(&frame, ruled(30.0), None);
    let mut drawing = first(&frame, ruled(30.0));
    assert!(still.coordinates.is_none());
    assert_eq!(drawing.hatching, still.hatching);
    // And stays it while nothing moves.
    let rest = motion(&frame, |_, _| [0.0; 2]);
    for _ in 0..3 {
        drawing = next(&drawing, &frame, &rest, ruled(30.0));
        assert_eq!(drawing.hatching, still.hatching);
    }
}

#[test]
fn a_pan_moves_every_stroke_and_changes_none() {
    let frame = card(SIZE);
    let still = first(&frame, ruled(30.0));
    // Across the strokes, not along them.
    let pan = motion(&frame, |_, _| [2.0, 3.0]);
    let mut drawing = first(&frame, ruled(30.0));
    for step in 1..=20 {
        drawing = next(&drawing, &frame, &pan, ruled(30.0));
        // Whole pixels: places are integers and a half, all sums are exact, so every bit is preserved.
        let from = shifted(2 * step, 3 * step);
        let carried = difference(&drawing.hatching, &still.hatching, from);
        assert_eq!(carried, 0.0, "after {step} steps");
        // Newly visible surface has the tone of the rest.
        is_half_inked(&drawing, format!("after {step} steps"));
        assert_eq!(shares(&drawing), [1.0]);
    }
    // Fixed strokes: black and white meet by chance, with half of the pixels inked. Unrelated drawings differ at 2 *
    // 1/2 * 1/2; lines are anti-aliased, so somewhat less.
    let swimming = difference(&still.hatching, &still.hatching, shifted(2, 3));
    assert!(swimming > 0.25, "{swimming}");
}

#[test]
fn a_pan_by_parts_of_a_pixel_does_not_drift() {
    let frame = card(SIZE);
    let still = first(&frame, ruled(30.0));
    let pan = motion(&frame, |_, _| [0.3, 0.7]);
    let mut drawing = first(&frame, ruled(30.0));
    for _ in 0..20 {
        drawing = next(&drawing, &frame, &pan, ruled(30.0));
    }
    // 6 columns and 14 rows. Places near 400 are rounded by 3e-5 a step, and ink rises from 0 to 1 over
    // about a pixel: 20 steps leave less than 1e-3.
    let carried = difference(&drawing.hatching, &still.hatching, shifted(6, 14));
    assert!(carried < 1e-3, "{carried}");
    assert_eq!(shares(&drawing), [1.0]);
}

#[test]
fn an_object_that_turns_in_the_picture_keeps_its_strokes() {
    // A disc rotated by 5 degrees a frame, with its strokes.
    let side = 160;
    let middle = side as f64 / 2.0;
    let frame = cards([side; 2], 0.5, |x, y| {
        let from = (x as f64 + 0.5 - middle).hypot(y as f64 + 0.5 - middle);
        (from < 70.0).then_some(3.0)
    });
    let (sin, cos) = 5.0_f64.to_radians().sin_cos();
    // Counterclockwise as seen, rows down: where (x, y) was is turned the other way.
    let turn = motion(&frame, |x, y| {
        let (x, y) = (x - middle, y - middle);
        [x - (cos * x - sin * y), y - (sin * x + cos * y)]
    });
    let start = first(&frame, ruled(20.0));
    let mut drawing = first(&frame, ruled(20.0));
    for step in 1..=18 {
        let degrees = 20.0 + 5.0 * step as f32;
        drawing = next(&drawing, &frame, &turn, ruled(degrees));
        assert_eq!(shares(&drawing), [1.0], "at {degrees}");
    }
    // A right angle in all. The pixel at column x, row y was at column side - 1 - y, row x. Interpolation preserves
    // affine maps, so only rounding and the rim, which is extended from within, remain.
    let inside = |x: usize, y: usize| frame.mask.at(x, y).then_some([side - 1 - y, x]);
    let carried = difference(&drawing.hatching, &start.hatching, inside);
    assert!(carried < 5e-3, "{carried}");
    let elsewhere = |x: usize, y: usize| frame.mask.at(x, y).then_some([x, y]);
    assert!(difference(&drawing.hatching, &start.hatching, elsewhere) > 0.25);
}

#[test]
fn what_comes_out_from_behind_goes_on_as_if_it_had_been_seen() {
    // A card of 60 x 60 passes at 4 px a frame over a background that stays.
    let scene = |step: usize| {
        let front = passing(step);
        cards(SIZE, 0.5, move |x, y| {
            Some(if front(x, y) { 4.0 } else { 9.0 })
        })
    };
    let start = first(&scene(0), ruled(75.0));
    let mut drawing = first(&scene(0), ruled(75.0));
    for step in 1..=25 {
        let frame = scene(step);
        drawing = next(&drawing, &frame, &passage(&frame, step), ruled(75.0));
        assert!(is_a_drawing(&drawing));
        is_half_inked(&drawing, format!("after {step} steps"));
    }
    // Both textures began as the still drawing: the background, hidden and visible again, still has it, the card has
    // carried its part along.
    let front = passing(25);
    let background = |x, y| (!front(x, y)).then_some([x, y]);
    let card = |x, y| front(x, y).then(|| [x - 100, y]);
    let off = |from| difference(&drawing.hatching, &start.hatching, from);
    assert_eq!(off(&background as &dyn Fn(_, _) -> _), 0.0);
    assert_eq!(off(&card), 0.0);
}

#[test]
fn a_window_that_moves_over_the_picture_changes_nothing() {
    let whole = card(SIZE);
    let still = first(&whole, ruled(30.0));
    let [left, top] = [17, 9];
    let part = whole.crop(Window::at(left, top, 120, 90));
    let rest = motion(&part, |_, _| [0.0; 2]);
    let drawing = next(&still, &part, &rest, ruled(30.0));
    let from = |x, y| Some([x + left as usize, y + top as usize]);
    assert_eq!(difference(&drawing.hatching, &still.hatching, from), 0.0);
}
