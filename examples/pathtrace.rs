//! A small path tracer that warps and scales light on its way: the kernels of `relievo` inside a renderer of one's own,
//! with no picture and no frame in between.
//!
//! `cargo run --release -p examples --example pathtrace -- --help`; the integration is in `enhancement.rs` and `path.rs` beside
//! this file.

mod common;
mod pathtrace {
    #[cfg(test)]
    mod energy_tests;
    pub(crate) mod enhancement;
    mod geometry;
    mod light;
    mod material;
    mod mesh;
    pub(crate) mod path;
    pub(crate) mod render;
    mod sampler;
    mod scene;
    pub(crate) mod sheet;
    pub(crate) mod stage;
    mod urn;
    #[cfg(test)]
    mod warp_tests;
}

use clap::{Parser, Subcommand};
use pathtrace::enhancement::{Bounces, Enhancement};
use pathtrace::path::{Direct, Tracing};
use pathtrace::render::Job;
use pathtrace::sheet::write_sheet;
use pathtrace::stage::{self, Setting};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// A small path tracer that warps and scales light on its way.
#[derive(Debug, Parser)]
#[command(name = "pathtrace")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene.
    Render(RenderArguments),
    /// Render the pictures of the guide as one.
    Sheet {
        /// A JPEG or PNG file.
        output: PathBuf,
        /// Paths per pixel; twice as many where there are mirrors.
        #[arg(long, default_value_t = 80, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
        samples: u32,
        /// Width of a picture, in pixels.
        #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(16..=2000))]
        width: u32,
    },
}

#[derive(Debug, clap::Args)]
struct RenderArguments {
    /// A PNG or EXR file.
    output: PathBuf,
    /// Materials and lights.
    #[arg(long, value_enum, default_value = "mirrors")]
    setting: Setting,
    /// Bounces at which light is warped.
    #[arg(long, value_enum, default_value = "none")]
    warp: Bounces,
    /// Bounces at which light is scaled.
    #[arg(long, value_enum, default_value = "none")]
    scale: Bounces,
    /// Radius of the features to bring out, where the thing is 2 tall.
    #[arg(long, default_value_t = Enhancement::default().feature)]
    feature: f32,
    /// Sampling of direct light.
    #[arg(long, value_enum, default_value = "both")]
    direct: Direct,
    /// Paths per pixel.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Width and height in pixels.
    #[arg(long, num_args = 2, default_values_t = [640, 480], value_parser = clap::value_parser!(u32).range(1..=16384))]
    size: Vec<u32>,
}

fn main() -> ExitCode {
    common::exit(match Arguments::parse().command {
        Command::Render(arguments) => render(&arguments),
        Command::Sheet {
            output,
            samples,
            width,
        } => write_sheet(&output, samples, width as usize),
    })
}

fn render(arguments: &RenderArguments) -> Result<(), Box<dyn Error>> {
    if !(arguments.feature >= 0.0 && arguments.feature.is_finite()) {
        return Err(format!("--feature is {}: give 0 or more", arguments.feature).into());
    }
    let size = [arguments.size[0], arguments.size[1]].map(|side| side as usize);
    let job = Job {
        scene: &stage::scene(arguments.setting),
        camera: stage::camera(arguments.setting, size),
        tracing: Tracing {
            enhancement: Enhancement {
                warp: arguments.warp,
                scale: arguments.scale,
                feature: arguments.feature,
                ..Enhancement::default()
            },
            direct: arguments.direct,
            ..Tracing::default()
        },
        samples: arguments.samples,
        seed: 1,
    };
    let picture = job.picture(|light| light);
    common::write(&arguments.output.to_string_lossy(), &picture)?;
    Ok(())
}
