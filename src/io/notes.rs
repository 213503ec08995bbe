//! Conclusions and warnings gathered while a frame is loaded.

use super::finding::Finding;
use super::frame_sources::FrameSources;
use super::inputs::{Inputs, NormalEncoding};
use super::normal_encoding::judge_encoding;
use super::opened::Opened;
use super::roles::Role;
use super::sources::Chosen;
use crate::frame::{Mask, Vector3Planes};

/// Conclusions and warnings gathered while loading.
pub(super) struct Notes {
    pub(super) findings: Vec<Finding>,
    pub(super) warnings: Vec<String>,
}

/// Most characters of a line of evidence and of the flag that goes with it.
const LINE: usize = 80;

/// Why a layer was chosen, and as many of the others as the line has room for beside the `flag`.
fn evidence(chosen: &Chosen, flag: &str) -> String {
    let Chosen { why, others } = chosen;
    let Some(first) = others.first() else {
        return why.clone();
    };
    let all = format!("{why}; or {}", others.join(", "));
    let (some, few) = match others.len() - 1 {
        0 => (None, format!("{why}; or one other")),
        more => (
            Some(format!("{why}; or {first}, {more} more")),
            format!("{why}; or {} others", more + 1),
        ),
    };
    let fits = |text: &String| text.chars().count() + flag.chars().count() <= LINE;
    [Some(all), some]
        .into_iter()
        .flatten()
        .find(fits)
        .unwrap_or(few)
}

impl Notes {
    pub(super) fn about(sources: &FrameSources) -> Self {
        let findings = sources
            .roles
            .iter()
            .map(|source| Finding {
                subject: source.role.name(),
                conclusion: source.label().into(),
                evidence: match &source.chosen {
                    Some(chosen) => evidence(chosen, &source.flag()),
                    None => format!("from {}", source.file.path().display()),
                },
                flag: source.flag(),
            })
            .collect();
        let data = [Role::Normal, Role::Depth, Role::Position];
        let warnings = data
            .into_iter()
            .filter_map(|role| sources.get(role))
            .filter(|source| !source.lossy_channels().is_empty())
            .map(|source| {
                format!(
                    "{} was stored with a lossy compression: expect noise in curvature",
                    source.lossy_channels().join(", ")
                )
            })
            .collect();
        Self { findings, warnings }
    }

    pub(super) fn on_coverage(&mut self, mask: &Mask) {
        if mask.count() == 0 {
            self.warnings
                .push("no pixel shows a surface: nothing to do".into());
        }
    }

    pub(super) fn encoding(
        &mut self,
        inputs: &Inputs,
        sources: &FrameSources,
        stored: &Vector3Planes,
    ) -> NormalEncoding {
        let integers = sources.get(Role::Normal).is_some_and(
            |source| matches!(source.file.as_ref(), Opened::Photo { photo, .. } if !photo.header.is_float),
        );
        let (encoding, evidence) = match inputs.normal_encoding {
            Some(encoding) => (encoding, "as given"),
            None if integers => (NormalEncoding::Unsigned, "stored as integers"),
            None => (judge_encoding(stored), "from lengths and signs"),
        };
        let (conclusion, name) = match encoding {
            NormalEncoding::Signed => ("signed, -1..1", "signed"),
            NormalEncoding::Unsigned => ("unsigned, 0..1", "unsigned"),
        };
        self.findings.push(Finding {
            subject: "normal encoding".into(),
            conclusion: conclusion.into(),
            evidence: evidence.into(),
            flag: format!("--normal-encoding {name}"),
        });
        encoding
    }
}
