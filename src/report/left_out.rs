//! What the command could go without: each input and each stage left out in turn.

use super::subject::{ALBEDO, DEPTH, LIGHT, OCCLUSION, Subject, Variation};
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

fn input(name: &'static str, change: Variation, flags: &str) -> Omission {
    Omission {
        name,
        change,
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
pub(super) fn parts(subject: &Subject, outcome: &Outcome) -> Vec<Omission> {
    let (command, frame) = (&subject.command, &subject.frame);
    let params = &command.work().args().flags.params;
    let ran = |stage: &str| outcome.timings.iter().any(|(name, _)| *name == stage);
    let mut parts = Vec::new();
    parts.extend(of_command(subject));
    if frame.depth.is_some() {
        parts.push(input(
            "depth",
            Variation::without(DEPTH),
            "--depth none --position none",
        ));
    }
    if frame.occlusion.is_some() {
        parts.push(input(
            "occlusion",
            Variation::without(OCCLUSION),
            "--occlusion none",
        ));
    }
    if frame.albedo.is_some() {
        parts.push(input("albedo", Variation::without(ALBEDO), "--albedo none"));
    }
    if frame.light != LightLayers::default() && matches!(command, Command::Enhance(_)) {
        parts.push(input(
            "light layers",
            Variation::without(LIGHT),
            "--lobes off",
        ));
    }
    if ran("diffusion") {
        parts.push(stage("diffusion", "iterations", 0));
    }
    if ran("edges-and-gradient") {
        parts.push(stage("silhouettes", "silhouette", NEVER));
        parts.push(stage("creases", "crease", NEVER));
    }
    let scaling = &params.scaling;
    if let (Some(gain), Adaptive::Auto) = (outcome.gain, scaling.curvature_gain) {
        parts.push(stage("choice of the gain", "curvature-gain", gain));
    }
    if let (Some(white), Adaptive::Auto) = (outcome.white_level, scaling.white_level) {
        parts.push(stage("choice of white", "white-level", white));
    }
    let is_picture = matches!(command, Command::Enhance(_) | Command::Relight(_));
    if is_picture && frame.confidence.is_some() && params.blur_fade > 0.0 {
        parts.push(stage("fade at blended pixels", "blur-fade", 0));
    }
    if is_picture && params.display.highlights == Highlights::Compress {
        parts.push(stage("compression of highlights", "highlights", "clip"));
    }
    if let Some(args) = command.work().light().filter(|_| ran("relight"))
        && args.params().method == Method::Both
    {
        parts.push(stage("warping", "method", "scale"));
        parts.push(stage("radiance scaling", "method", "warp"));
    }
    if ran("contours") {
        parts.push(stage("contours", "contours", "off"));
    }
    if ran("interior") {
        parts.push(stage("lines inside", "interior", "off"));
    }
    if ran("shape-tone") {
        parts.push(stage(
            "tone that shows shape",
            "tone",
            ToneSource::Picture.name(),
        ));
    }
    parts
}

/// The shape that it brings out.
fn of_command(subject: &Subject) -> Option<Omission> {
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
