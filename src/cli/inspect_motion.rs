//! The findings of `inspect` on motion: how its layers lead to the previous frame, if that lies beside the file.

use crate::error::Result;
use crate::frame::static_world_motion;
use crate::io::inputs::Inputs;
use crate::io::motion::{FrameBefore, MotionLayers};
use crate::io::motion_layer_names;
use crate::io::{self, Finding, Needs};
use crate::untrusted::Untrusted;
use std::path::{Path, PathBuf};

/// The finding on motion of the frame of `inputs`; `None` where no layer may hold any.
///
/// # Errors
/// Those of loading it.
pub(super) fn finding(inputs: &Inputs) -> Result<Option<Finding>> {
    let (names, mean_motion) = motion_layer_names(inputs)?;
    let Some(first) = names.first() else {
        return Ok(None);
    };
    let flag = format!("--motion {}", Untrusted(first).quoted());
    // Only comparing frames shows whether layers without a telling name hold motion.
    let unread = |evidence: &str| {
        mean_motion.then(|| Finding {
            subject: "motion".into(),
            conclusion: names.join(", "),
            evidence: evidence.into(),
            flag: flag.clone(),
        })
    };
    let Some((before, number)) = frame_before(&inputs.picture).filter(|(path, _)| path.exists())
    else {
        return Ok(unread(
            "how it leads to the frame before is judged where that lies beside the file",
        ));
    };
    let inputs_before = Inputs {
        picture: before.clone(),
        ..inputs.clone()
    };
    let needs = Needs {
        color_if_any: true,
        projection: true,
        motion: true,
        ..Needs::default()
    };
    // A frame before that is no frame tells nothing.
    let Ok(seen) = io::load(&inputs_before, needs) else {
        return Ok(unread("the frame before cannot be read"));
    };
    let now = io::load(inputs, needs)?;
    let still = seen
        .frame
        .camera
        .and_then(|camera| static_world_motion(&now.frame, &camera));
    let judge = |layers: &MotionLayers| {
        layers.judge(&now.frame, &FrameBefore::of(&seen.frame), 1, still.as_ref())
    };
    Ok(now.motion.as_ref().map(judge).map(|verdict| Finding {
        subject: "motion".into(),
        conclusion: verdict.conclusion,
        evidence: format!("against frame {number}: {}", verdict.evidence),
        flag: verdict.flags.unwrap_or(flag),
    }))
}

/// The file of the frame before `path`, whose last number in its name is one less, and that number.
fn frame_before(path: &Path) -> Option<(PathBuf, u32)> {
    let stem = path.file_stem()?.to_str()?;
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let begin = stem[..end].rfind(|c: char| !c.is_ascii_digit());
    let begin = begin.map_or(0, |at| {
        at + stem[at..].chars().next().map_or(1, char::len_utf8)
    });
    let digits = &stem[begin..end];
    let number = digits.parse::<u32>().ok()?.checked_sub(1)?;
    let width = digits.len();
    let mut name = format!("{}{number:0width$}{}", &stem[..begin], &stem[end..]);
    if let Some(extension) = path.extension() {
        name = format!("{name}.{}", extension.to_str()?);
    }
    Some((path.with_file_name(name), number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_before_has_the_number_before() {
        let before = |name: &str| {
            let (path, number) = frame_before(Path::new(name))?;
            Some((path.to_str()?.to_string(), number))
        };
        assert_eq!(
            before("a/shot.1000.exr"),
            Some(("a/shot.0999.exr".into(), 999))
        );
        assert_eq!(
            before("v2_7_beauty.exr"),
            Some(("v2_6_beauty.exr".into(), 6))
        );
        assert_eq!(before("é10"), Some(("é09".into(), 9)));
        assert_eq!(before("shot.0000.exr"), None);
        assert_eq!(before("shot.exr"), None);
    }
}
