//! Frames of a sequence.

use super::made::settings_in;
use super::scene::File;
use super::work::Work;
use crate::command::chosen::Chosen;
use crate::command::recipe::SAMPLE_FRAMES;
use crate::engine::{Engine, Run};
use crate::error::Result;
use std::path::Path;

pub use crate::command::frames_there::frames_on_disk as frames_of;

/// The settings with everything that a command chooses by itself, chosen once for all frames, as the command line does:
/// from five of them, or those of `sample-frames`. Frames that cannot be read are ignored.
///
/// # Errors
/// As [`Work::new`]; that of the first frame if none can be read; [`crate::Error::Cancelled`].
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
    let each = samples.iter().map(|&number| {
        run.watch().check()?;
        let made = work.run(engine, &*work.load(&file(number), None)?, run)?;
        let chosen = made.chosen.clone();
        engine.recycle(made.into_outcome());
        Ok(chosen)
    });
    let chosen = Chosen::for_all(each)?;
    let chosen = settings_in(&chosen, command);
    let once = (!samples.is_empty()).then(|| (SAMPLE_FRAMES.into(), "none".into()));
    let given = settings.iter().filter(|(name, _)| name != SAMPLE_FRAMES);
    Ok(given.cloned().chain(chosen).chain(once).collect())
}
