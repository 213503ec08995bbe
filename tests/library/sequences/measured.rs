//! How well drawings of a sequence follow each other.

use super::*;
use crate::coherence::{CoherenceRow, MovingFrame, measure};

/// Rows for a moving card. The first frame is white, and its white point applies to the grey frames that follow.
fn pan(by: [f64; 2]) -> Vec<CoherenceRow> {
    let frames = (1..=4).map(|number| {
        let luminance = if number == 1 { 1.0 } else { 0.2 };
        let frame = cards(Window::from_size(200, 140), luminance, |_, _| Some(7.0));
        let motion = (number > 1).then(|| motion(&frame, |_, _| by));
        Ok(MovingFrame {
            number,
            frame,
            motion,
        })
    });
    let measured = measure(frames, ShapeParams::default()).unwrap().unwrap();
    let rows = &measured.rows;
    assert_eq!(
        rows.iter().map(|row| row.frame).collect::<Vec<_>>(),
        [2, 3, 4]
    );
    let mean = rows.iter().map(|row| row.carried).sum::<f64>() / 3.0;
    assert!((measured.means[1] - mean).abs() < 1e-12);
    rows[1..].to_vec()
}

#[test]
fn whole_pixels_cost_nothing_and_half_ones_no_more_than_the_floor() {
    for row in pan([3.0, -2.0]) {
        assert_eq!((row.carried, row.floor), (0.0, 0.0));
        // 197 of 200 columns and 138 of 140 rows were visible before.
        assert!((row.seen_before - 197.0 * 138.0 / (200.0 * 140.0)).abs() < 1e-9);
        assert!((row.motion_px - 13.0_f64.sqrt()).abs() < 1e-6);
        assert_eq!(row.oldest_share, 1.0);
        // Ink, and as much of it that had none before: strokes that have nothing in common differ by
        // 2 * 1/2 * 1/2 = 1/2 in the mean.
        assert!(row.still > 0.2, "{}", row.still);
    }
    // Half a pixel along both axes, where interpolation blurs most. The card has the tone and direction of the
    // frame itself, so nothing but that blur is in either.
    for row in pan([2.5, 1.5]) {
        assert!(row.floor > 0.0 && row.floor < 0.5 * row.still, "{row:?}");
        assert!((row.carried / row.floor - 1.0).abs() < 0.1, "{row:?}");
    }
}

#[test]
fn frames_that_do_not_follow_each_other_measure_nothing() {
    let frame = || cards(Window::from_size(20, 10), 0.5, |_, _| Some(7.0));
    let alone = (1..=3).map(|number| {
        Ok(MovingFrame {
            number,
            frame: frame(),
            motion: None,
        })
    });
    assert!(measure(alone, ShapeParams::default()).unwrap().is_none());
}
