//! Everything that runs the program, as a user or a farm does.

#[path = "../common/mod.rs"]
mod common;

mod blender;
mod blur;
mod bundles;
mod colors;
mod conformance;
#[cfg(unix)]
mod corpus;
mod dependencies;
mod gloss;
mod hatch;
mod inputs;
mod kept;
mod layers;
mod light_layers;
mod manual;
mod map;
mod messages;
mod moving_strokes;
mod names;
mod objects;
mod outputs;
mod photos;
mod pictures;
mod readme;
mod recipes;
mod refusals;
mod relight;
mod report;
mod scale_bar;
mod sequences;
mod sheets;
mod specular;
#[cfg(unix)]
mod stops;
mod strips;
#[cfg(target_os = "linux")]
mod threads;
