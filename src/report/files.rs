//! The picture as a file: how large each kind is, how long it takes to write, and how far it is from the picture.

use super::StoredReport;
use super::clock::timed;
use super::difference::{CodeDifference, Codes};
use super::page::{level, png};
use super::subject::{ReportSubject, Shot};
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Plane, Window};
use crate::io::exr::{ExrFile, Limits, OutputCompression, OutputPart, OutputType, write_results};
use crate::io::output::layers::color_channels;
use crate::product::PART;
use OutputCompression::{Dwaa, None, Piz, Zip, Zips};
use OutputType::{Float, Half};
use std::io::BufWriter;
use std::path::Path;
use tempfile::NamedTempFile;

/// Kinds of EXR worth a try, by their flags.
#[rustfmt::skip] // A row each.
const KINDS: [(&str, OutputType, OutputCompression); 6] = [
    ("--depth-of-output float", Float, Zip),
    ("--depth-of-output half", Half, Zip),
    ("--depth-of-output half --compression zips", Half, Zips),
    ("--depth-of-output half --compression piz", Half, Piz),
    ("--depth-of-output half --compression dwaa", Half, Dwaa),
    ("--depth-of-output half --compression none", Half, None),
];

/// Writes the picture that the command makes as a PNG and as each kind of EXR, its three channels alone.
///
/// # Errors
/// [`Error::Io`] where temporary files cannot be written.
pub(super) fn files(
    subject: &ReportSubject,
    given: &Shot,
    counts: &[bool],
) -> Result<Vec<StoredReport>> {
    let (bytes, used) = timed(|| png(given.size, &given.codes));
    let rounded = |code: &u16| 257 * u16::from(level(code));
    let shown: Codes = given
        .codes
        .iter()
        .map(|code| code.each_ref().map(rounded))
        .collect();
    let mut files = vec![StoredReport {
        flags: "-o .png".into(),
        bytes: bytes.len() as u64,
        error: CodeDifference::between(&given.codes, &shown, counts),
        used,
    }];
    let Some(color) = given.made.outcome.picture() else {
        return Ok(files);
    };
    for (flags, sample_type, compression) in KINDS {
        let file = NamedTempFile::new().map_err(Error::io(Path::new("report.exr"), "make"))?;
        let part = part(subject, color, sample_type, compression);
        let (written, used) = timed(|| {
            let mut writer = BufWriter::new(file.as_file());
            write_results(&mut writer, file.path(), &part)
        });
        written?;
        let stored = ExrFile::open(file.path(), &Limits::default())?;
        let channels: Vec<_> = stored.channel_ids().collect();
        let Ok([b, g, r]) = <[Plane; 3]>::try_from(stored.read_channels(&channels)?) else {
            unreachable!("three channels were written, and files hold them by name")
        };
        let takes_picture = given.made.outcome.takes_picture;
        let shown = subject.displayed(ColorPlanes { r, g, b }, takes_picture);
        files.push(StoredReport {
            flags: format!("-o .exr {flags}"),
            bytes: file.as_file().metadata().map_or(0, |data| data.len()),
            error: CodeDifference::between(&given.codes, &shown.unwrap_or_default(), counts),
            used,
        });
    }
    Ok(files)
}

fn part<'a>(
    subject: &ReportSubject,
    color: &'a ColorPlanes,
    sample_type: OutputType,
    compression: OutputCompression,
) -> OutputPart<'a> {
    let window = Window::from_size(color.r.width(), color.r.height());
    OutputPart {
        name: PART.into(),
        data_window: window,
        display_window: window,
        pixel_aspect: subject.frame.pixel_aspect,
        channels: color_channels(Option::None, color, Option::None, sample_type),
        attributes: Vec::new(),
        chromaticities: Option::None,
        compression,
    }
}
