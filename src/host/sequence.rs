//! Frames of a sequence.

use super::made::settings_in;
use super::scene::File;
use super::work::Work;
use crate::command::chosen::Chosen;
use crate::command::recipe::SAMPLE_FRAMES;
use crate::engine::{Engine, Run};
use crate::error::{Error, Result};
use std::path::Path;

pub use crate::command::frames_there::frames_on_disk as frames_of;

/// The settings with everything that a command chooses by itself, chosen once for all frames, as the command line does:
/// from five of them, or those of `sample-frames`. Frames that cannot be read are ignored.
///
/// # Errors
/// As [`Work::new`]; that of the first frame if none can be read; [`Error::Cancelled`].
pub fn chosen_for_all(
    engine: &Engine,
    command: &str,
    settings: &[(String, String)],
    pattern: &Path,
    frames: &[i32],
    run: &Run,
) -> Result<Vec<(String, String)>> {
    let file = |number| File {
        path: pattern.into(),
        number: Some(number),
    };
    let Some(&first) = frames.first() else {
        return Ok(settings.to_vec());
    };
    let work = Work::new(command, settings, Some(&file(first)))?;
    let samples = work.sequence().samples(frames);
    let (mut each, mut first_error) = (Vec::new(), None);
    for &number in &samples {
        run.watch().check()?;
        let scene = work.load(&file(number), None);
        match scene.and_then(|scene| work.run(engine, &scene, run)) {
            Ok(made) => {
                each.push(made.chosen.clone());
                engine.recycle(made.into_outcome());
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    if let (Some(error), true) = (first_error, each.is_empty()) {
        return Err(error);
    }
    let chosen = settings_in(&Chosen::for_all(&each), command);
    let once = (!samples.is_empty()).then(|| (SAMPLE_FRAMES.into(), "none".into()));
    let given = settings.iter().filter(|(name, _)| name != SAMPLE_FRAMES);
    Ok(given.cloned().chain(chosen).chain(once).collect())
}
