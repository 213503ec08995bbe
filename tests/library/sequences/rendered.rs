//! A rendered sequence of the collection, whose motion layer and cameras are known.

use super::*;
use crate::coherence::{MovingFrame, measure};
use relievo::frame::{DepthKind, static_world_motion};
use relievo::io::inputs::Inputs;
use relievo::io::{self, camera::read_camera};

fn loaded(directory: &std::path::Path, number: i32) -> io::Loaded {
    let inputs = Inputs {
        picture: directory.join(format!("monkeyrun.{number:04}.exr")),
        camera: Some(directory.join(format!("monkeyrun.{number:04}.json"))),
        ..Inputs::default()
    };
    io::load(&inputs, moving()).unwrap()
}

#[test]
fn motion_is_read_as_blender_writes_it() {
    let Some(directory) = crate::common::real_files::real("renders/seq") else {
        return;
    };
    for number in [2, 7, 12] {
        let mut now = loaded(&directory, number);
        // Depth of half floats is good to 5e-4 of itself: of ten pixels of parallax that is nothing.
        now.frame.source.depth_kind = DepthKind::Planar;
        let before = directory.join(format!("monkeyrun.{:04}.json", number - 1));
        let window = now.frame.display_window;
        let before = read_camera(&before, window, 1.0).unwrap();
        let expected = static_world_motion(&now.frame, &before).unwrap();
        let found = now.motion.unwrap().by_name().unwrap();
        // The ground does not move; it fills the lowest rows, except for objects standing on it.
        let mut off: Vec<f32> = Vec::new();
        for y in 310..360 {
            for x in 0..640 {
                let [dx, dy] = [(&found.x, &expected.x), (&found.y, &expected.y)]
                    .map(|(a, b)| a.at(x, y) - b.at(x, y));
                off.push(dx.hypot(dy));
            }
        }
        off.sort_by(f32::total_cmp);
        let (median, most) = (off[off.len() / 2], off[off.len() * 95 / 100]);
        assert!(
            median < 0.05 && most < 0.3,
            "frame {number}: {median}, {most} px off"
        );
        let length = expected.x.samples()[350 * 640 + 320];
        assert!(length.abs() > 1.0, "the camera moves: {length}");
    }
}

#[test]
fn strokes_that_move_with_the_surface_swim_less() {
    let Some(directory) = crate::common::real_files::real("renders/seq") else {
        return;
    };
    let frames = (1..=5).map(|number| {
        let loaded = loaded(&directory, number);
        Ok(MovingFrame {
            number,
            frame: loaded.frame,
            motion: loaded
                .motion
                .and_then(|m| m.by_name())
                .filter(|_| number > 1),
        })
    });
    let measured = measure(frames, ShapeParams::default()).unwrap().unwrap();
    let [still, carried, floor, lines] = measured.means;
    assert!(floor < carried && carried < 0.7 * still, "{measured:?}");
    // Lines alone cover less paper than strokes, and follow the surface.
    assert!(lines > 0.0 && lines < carried, "{measured:?}");
}
