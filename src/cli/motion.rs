//! Motion between the frames of a sequence.

use crate::frame::{AWAY, Camera, Vector2Planes, static_world_motion};
use crate::io::Loaded;

/// What has to be kept of a frame to know how the next one moved.
#[derive(Debug, Default)]
pub(super) struct Steps {
    before: Option<(i32, Option<Camera>)>,
}

impl Steps {
    /// Whether there was a frame before, so that motion means something.
    pub(super) fn has_begun(&self) -> bool {
        self.before.is_some()
    }

    /// How far the surface of frame `number` has come since the frame before: by its own motion, else by
    /// its depth and both cameras. What it is taken from is said to `say`.
    pub(super) fn motion(
        &mut self,
        number: i32,
        loaded: &mut Loaded,
        say: impl Fn(&str),
    ) -> Option<Vector2Planes> {
        let camera = loaded.frame.camera;
        let (last, camera_before) = self.before.replace((number, camera))?;
        if let Some(motion) = loaded.motion.take() {
            let step = i64::from(number) - i64::from(last);
            if step > 1 {
                say(
                    "where frames are left out motion is taken for so many times that since the frame before",
                );
            }
            return Some(longer(motion, step as f32));
        }
        let motion = camera_before.and_then(|before| static_world_motion(&loaded.frame, &before));
        say(match motion {
            Some(_) => {
                "no layer of motion: it is taken from depth and cameras, as of a world that stands still"
            }
            None => {
                "neither a layer of motion nor depth with a camera: strokes lie still in the picture"
            }
        });
        motion
    }
}

/// Motion over several frames, from that of one.
fn longer(motion: Vector2Planes, factor: f32) -> Vector2Planes {
    let times = |m: f32| if m == AWAY { m } else { factor * m };
    match factor == 1.0 {
        true => motion,
        false => Vector2Planes {
            x: motion.x.map(times),
            y: motion.y.map(times),
        },
    }
}
