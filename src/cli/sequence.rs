//! Frame by frame: the names of a sequence, and what moved between its frames.

use super::args::WorkArgs;
use super::message;
use super::role_args::RoleArgs;
use crate::error::Result;
use crate::frame::{AWAY, Camera, Vector2Planes, static_world_motion};
use crate::io::sequence::{FrameList, frames_of, of_frame, path_of_frame};
use crate::io::{Loaded, inputs::Inputs};
use clap::Args;
use std::path::{Path, PathBuf};

/// Which frames, and what moves between them.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sequence")]
pub(super) struct SequenceArgs {
    /// Frames of a sequence, whose numbers go where IN and -o have #### or %04d: 1-12, every second one
    /// 1-12x2, or 1,5,9.
    #[arg(long, value_name = "LIST")]
    frames: Option<FrameList>,
    /// Motion, by which strokes move with the surface: a layer of IN or a file, in pixels, y up, previous
    /// minus current. Where not given it is looked for, and taken from depth and camera where there is none;
    /// none lets strokes lie still in the picture.
    #[arg(long, value_name = "NAME|FILE|none", requires = "frames")]
    motion: Option<String>,
}

impl SequenceArgs {
    /// The frames, for names that have a place for their numbers; `None` for a single picture.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] for frames without such names, and names without frames.
    pub(super) fn frames(&self, input: &Path, output: Option<&Path>) -> Result<Option<&[u32]>> {
        frames_of(self.frames.as_ref(), input, output)
    }

    /// Whether strokes are to move with the surface.
    pub(super) fn moves(&self) -> bool {
        self.motion.as_deref() != Some("none")
    }

    /// The layer or file of motion that was named, for one frame.
    pub(super) fn motion_of(&self, frame: u32) -> Option<String> {
        let named = self.motion.as_deref().filter(|_| self.moves())?;
        Some(numbered(named, frame))
    }
}

/// A name with the number in its place, if it has one.
pub(super) fn numbered(name: &str, frame: u32) -> String {
    of_frame(name, frame).unwrap_or_else(|| name.into())
}

fn numbered_path(path: &Path, frame: u32) -> PathBuf {
    path_of_frame(path, frame).unwrap_or_else(|| path.into())
}

impl WorkArgs {
    /// The same for one frame of a sequence.
    pub(super) fn of_frame(&self, frame: u32) -> Self {
        let mut one = self.clone();
        one.input = numbered_path(&self.input, frame);
        one.roles.rename(|name| numbered(name, frame));
        one.output.output = numbered_path(&self.output.output, frame);
        let timings = &self.run.timings;
        one.run.timings = timings.as_ref().map(|path| numbered_path(path, frame));
        one
    }
}

/// [`WorkArgs::of_frame`] for inputs alone.
pub(super) fn inputs_of_frame(roles: &RoleArgs, input: &Path, frame: u32) -> Inputs {
    let mut roles = roles.clone();
    roles.rename(|name| numbered(name, frame));
    roles.inputs(&numbered_path(input, frame))
}

/// What has to be kept of a frame to know how the next one moved.
#[derive(Debug, Default)]
pub(super) struct Steps {
    before: Option<(u32, Option<Camera>)>,
    told: bool,
}

impl Steps {
    /// Whether there was a frame before, so that motion means something.
    pub(super) fn has_begun(&self) -> bool {
        self.before.is_some()
    }

    /// How far the surface of frame `number` has come since the frame before: by its own motion, else by
    /// its depth and both cameras.
    pub(super) fn motion(
        &mut self,
        number: u32,
        loaded: &mut Loaded,
        quiet: bool,
    ) -> Option<Vector2Planes> {
        let camera = loaded.frame.camera;
        let (last, camera_before) = self.before.replace((number, camera))?;
        let mut tell = |text: &str| {
            if !std::mem::replace(&mut self.told, true) {
                message::warning(quiet, text);
            }
        };
        if let Some(motion) = loaded.motion.take() {
            let step = number - last;
            if step > 1 {
                tell(&format!(
                    "from frame {last} to {number} motion is taken for {step} times that since the frame before"
                ));
            }
            return Some(longer(motion, step as f32));
        }
        let motion = camera_before.and_then(|before| static_world_motion(&loaded.frame, &before));
        tell(match motion {
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

/// Motion over several frames, as far as that of one tells.
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
