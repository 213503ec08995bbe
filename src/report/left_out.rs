//! What the command could go without: each input and each stage left out in turn.

use super::subject::{ALBEDO, DEPTH, LIGHT, OCCLUSION, Removal, ReportSubject, Variation};
use crate::command::commands::Command;
use crate::engine::Outcome;
use crate::frame::LightLayers;
use crate::params::{Adaptive, Highlights, Method, ToneSource};

/// Something to be left out.
pub(super) struct Omission {
    pub(super) name: &'static str,
    pub(super) change: Variation,
    /// How to leave it out by flags.
    pub(super) flags: String,
    /// Whether it is the very thing that the command is for.
    pub(super) is_command: bool,
}

fn input(name: &'static str, input: Removal, flags: &str) -> Omission {
    Omission {
        name,
        change: Variation::without(input),
        flags: flags.into(),
        is_command: false,
    }
}

fn stage(name: &'static str, setting: &'static str, value: impl ToString) -> Omission {
    let change = Variation::setting(setting, value);
    Omission {
        name,
        flags: change.flags(),
        change,
        is_command: false,
    }
}

/// A threshold that nothing reaches.
const NEVER: &str = "1e29,1e30";

/// What can be left out of the command as given, which made `outcome`.
pub(super) fn parts(subject: &ReportSubject, outcome: &Outcome) -> Vec<Omission> {
    let (command, frame) = (&subject.command, &subject.frame);
    let params = &command.work().args().flags.params;
    let ran = |stage: &str| outcome.timings.iter().any(|(name, _)| *name == stage);
    let scaling = &params.scaling;
    let chosen = |auto: Adaptive, found: Option<f32>| found.filter(|_| auto == Adaptive::Auto);
    let gain = chosen(scaling.curvature_gain, outcome.gain);
    let white = chosen(scaling.white_level, outcome.white_level);
    let is_enhanced = matches!(command, Command::Enhance(_));
    let is_relit = command
        .work()
        .light()
        .is_some_and(|args| args.params().method == Method::Both);
    let is_relit = is_relit && ran("relight");
    let is_picture = matches!(command, Command::Enhance(_) | Command::Relight(_));
    let fades = is_picture && frame.confidence.is_some() && params.blur_fade > 0.0;
    let compresses = is_picture && params.display.highlights == Highlights::Compress;
    let has_light = is_enhanced && frame.light != LightLayers::default();
    let has_edges = ran("edges-and-gradient");
    let picture = ToneSource::Picture.name();
    let [gain_value, white_value] = [gain, white].map(|v| v.unwrap_or_default().to_string());
    #[rustfmt::skip] // A row each.
    let inputs = [
        (frame.depth.is_some(), "depth", DEPTH, "--depth none --position none"),
        (frame.occlusion.is_some(), "occlusion", OCCLUSION, "--occlusion none"),
        (frame.albedo.is_some(), "albedo", ALBEDO, "--albedo none"),
        (has_light, "light layers", LIGHT, "--lobes off"),
    ];
    #[rustfmt::skip]
    let stages = [
        (ran("diffusion"), "diffusion", "iterations", "0"),
        (has_edges, "silhouettes", "silhouette", NEVER),
        (has_edges, "creases", "crease", NEVER),
        (gain.is_some(), "choice of the gain", "curvature-gain", &gain_value),
        (white.is_some(), "choice of white", "white-level", &white_value),
        (fades, "fade at blended pixels", "blur-fade", "0"),
        (compresses, "compression of highlights", "highlights", "clip"),
        (is_relit, "warping", "method", "scale"),
        (is_relit, "radiance scaling", "method", "warp"),
        (ran("contours"), "contours", "contours", "off"),
        (ran("interior"), "lines inside", "interior", "off"),
        (ran("shape-tone"), "tone that shows shape", "tone", picture),
    ];
    let inputs = inputs.into_iter().filter(|(is_there, ..)| *is_there);
    let stages = stages.into_iter().filter(|(ran, ..)| *ran);
    of_command(subject)
        .into_iter()
        .chain(inputs.map(|(_, name, removal, flags)| input(name, removal, flags)))
        .chain(stages.map(|(_, name, setting, value)| stage(name, setting, value)))
        .collect()
}

/// The shape that it brings out.
fn of_command(subject: &ReportSubject) -> Option<Omission> {
    let part = match &subject.command {
        Command::Enhance(_) => stage("enhance", "scaling", 0),
        Command::Relight(args) if args.params().method != Method::Plain => {
            stage("shape in the light", "method", "plain")
        }
        _ => return None,
    };
    Some(Omission {
        is_command: true,
        ..part
    })
}
