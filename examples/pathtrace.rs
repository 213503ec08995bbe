//! A small path tracer that warps and scales light on its way: the kernels of `relievo` inside a renderer of one's own,
//! with no picture and no frame in between.
//!
//! `cargo run --release -p examples --example pathtrace -- --help`; the integration is in `enhancement.rs` and `path.rs` beside
//! this file.

#[path = "pathtrace/camera.rs"]
mod camera;
mod common;
#[cfg(test)]
#[path = "pathtrace/energy_tests.rs"]
mod energy_tests;
#[path = "pathtrace/enhancement.rs"]
mod enhancement;
#[path = "pathtrace/geometry.rs"]
mod geometry;
#[path = "pathtrace/light.rs"]
mod light;
#[path = "pathtrace/material.rs"]
mod material;
#[path = "pathtrace/mesh.rs"]
mod mesh;
#[path = "pathtrace/mesh_curvature.rs"]
mod mesh_curvature;
#[path = "pathtrace/path.rs"]
mod path;
#[path = "pathtrace/render.rs"]
mod render;
#[path = "pathtrace/sampler.rs"]
mod sampler;
#[path = "pathtrace/scene.rs"]
mod scene;
#[path = "pathtrace/sheet.rs"]
mod sheet;
#[path = "pathtrace/stage.rs"]
mod stage;
#[path = "pathtrace/tree.rs"]
mod tree;
#[path = "pathtrace/urn.rs"]
mod urn;
#[cfg(test)]
#[path = "pathtrace/warp_tests.rs"]
mod warp_tests;

use clap::{Parser, Subcommand};
use enhancement::{Bounces, Enhancement};
use glam::Vec3;
use mesh::Mesh;
use path::{Direct, Tracing};
use relievo::frame::{ColorPlanes, Plane};
use render::Job;
use stage::Setting;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Columns and rows of the urn by default: about two to a pixel of the pictures.
const URN: [usize; 2] = [1100, 800];

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
    common::exit(run(Arguments::parse()))
}

fn run(arguments: Arguments) -> Result<(), Box<dyn Error>> {
    match arguments.command {
        Command::Render(arguments) => render(&arguments),
        Command::Sheet {
            output,
            samples,
            width,
        } => sheet::write_sheet(&output, samples, width as usize),
    }
}

fn the_urn() -> Mesh {
    urn::urn(URN[0], URN[1])
}

fn render(arguments: &RenderArguments) -> Result<(), Box<dyn Error>> {
    if !(arguments.feature >= 0.0 && arguments.feature.is_finite()) {
        return Err(format!("--feature is {}: give 0 or more", arguments.feature).into());
    }
    let size = [arguments.size[0], arguments.size[1]].map(|side| side as usize);
    let job = Job {
        scene: &stage::scene(arguments.setting, the_urn()),
        camera: stage::camera(arguments.setting, size),
        tracing: Tracing {
            enhancement: Enhancement {
                warp: arguments.warp,
                scale: arguments.scale,
                feature: arguments.feature,
                ..Enhancement::default()
            },
            direct: arguments.direct,
            max_bounces: MAX_BOUNCES,
        },
        samples: arguments.samples,
        seed: 1,
    };
    let picture = planes(&job.pixels(), size);
    Ok(common::write(
        &arguments.output.to_string_lossy(),
        &picture,
    )?)
}

/// The light of pixels as planes.
fn planes(light: &[Vec3], [width, height]: [usize; 2]) -> ColorPlanes {
    let channel = |c: usize| Plane::from_fn(width, height, |x, y| light[y * width + x][c]);
    ColorPlanes {
        r: channel(0),
        g: channel(1),
        b: channel(2),
    }
}

/// Surfaces that a path of the pictures may meet.
const MAX_BOUNCES: usize = 12;
