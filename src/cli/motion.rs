//! Motion between the frames of a sequence.

use crate::frame::{Camera, Frame, Vector2Planes, static_world_motion};
use crate::io::motion::{FrameBefore, MotionConvention, MotionLayers, MotionVerdict};

/// State kept from a frame to find the motion of the next.
#[derive(Debug, Default)]
pub(super) struct Steps {
    before: Option<Before>,
    /// How the layer that is named is read, where a flag says so.
    convention: Option<MotionConvention>,
    /// How layers of motion are read, once frames have shown it.
    verdict: Option<MotionVerdict>,
}

#[derive(Debug)]
struct Before {
    number: i32,
    camera: Option<Camera>,
    /// Its content, while the convention of motion is undecided.
    seen: Option<FrameBefore>,
}

impl Steps {
    /// Before the first frame; `convention` overrules what frames show.
    pub(super) fn new(convention: Option<MotionConvention>) -> Self {
        Self {
            convention,
            ..Self::default()
        }
    }

    /// How far the surface of frame `number` has come since the frame before: by its own motion, else by
    /// its depth and both cameras. What it is taken from is said to `say`.
    pub(super) fn motion(
        &mut self,
        number: i32,
        frame: &Frame,
        layers: Option<MotionLayers>,
        say: impl Fn(&str),
    ) -> Option<Vector2Planes> {
        let camera = frame.camera;
        let is_settled = |verdict: &MotionVerdict| verdict.is_settled;
        let is_open = self.convention.is_none() && !self.verdict.as_ref().is_some_and(is_settled);
        let now = Before {
            number,
            camera,
            seen: is_open.then(|| FrameBefore::of(frame)),
        };
        let before = self.before.replace(now)?;
        let still = before
            .camera
            .and_then(|before| static_world_motion(frame, &before));
        let step = i64::from(number) - i64::from(before.number);
        let step = u32::try_from(step).unwrap_or(1).max(1);
        let of_layers = layers.and_then(|layers| {
            if let Some(convention) = self.convention {
                return Some(layers.given(convention));
            }
            if let Some(seen) = &before.seen {
                let verdict = layers.judge(frame, seen, step, still.as_ref());
                self.learn(verdict, &layers, &say);
            }
            let found = self
                .verdict
                .as_ref()
                .and_then(|verdict| layers.read_as(verdict));
            found.or_else(|| layers.by_name())
        });
        if let Some(motion) = of_layers {
            if step > 1 {
                say(
                    "where frames are left out motion is taken for so many times that since the frame before",
                );
            }
            return Some(longer(motion, step as f32));
        }
        say(match still {
            Some(_) => "motion is taken from depth and cameras, as of a world that stands still",
            None => {
                "neither motion nor depth with a camera is known: strokes lie still in the picture"
            }
        });
        still
    }

    /// Takes a verdict for all frames from here on, unless an earlier one found a layer and this one does not.
    fn learn(&mut self, verdict: MotionVerdict, layers: &MotionLayers, say: impl Fn(&str)) {
        let was_found = self.verdict.as_ref().is_some_and(MotionVerdict::is_found);
        if was_found && !verdict.is_found() {
            return;
        }
        let is_news = match verdict.is_found() {
            true => !was_found && !layers.is_by_name(&verdict),
            false => !verdict.is_still,
        };
        if is_news {
            let conclusion = match verdict.is_found() || !layers.has_named() {
                true => &verdict.conclusion,
                false => "read as the name of its layer says, which frames do not show",
            };
            say(&format!("motion: {conclusion} ({})", verdict.evidence));
        }
        self.verdict = Some(verdict);
    }
}

/// Motion over several frames, from that of one.
fn longer(motion: Vector2Planes, factor: f32) -> Vector2Planes {
    let is_known = |m: f32| m != Vector2Planes::AWAY;
    let times = |m: f32| if is_known(m) { factor * m } else { m };
    match factor == 1.0 {
        true => motion,
        false => Vector2Planes {
            x: motion.x.map(times),
            y: motion.y.map(times),
        },
    }
}
