//! An environment and two lit spheres by formula: `room.hdr`, `clay.png` and `slate.png`, to light
//! surfaces with.
//!
//! `cargo run --release -p examples --example surroundings -- FOLDER`

mod common;

use glam::Vec3;
use relievo::frame::{ColorPlanes, Plane};
use relievo::light::environment::Environment;
use std::error::Error;
use std::process::ExitCode;

const ROOM_WIDTH: usize = 256;
const SPHERE_WIDTH: usize = 128;

fn main() -> ExitCode {
    common::exit(run())
}

fn run() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1);
    let folder = folder.ok_or("usage: surroundings FOLDER")?;
    let in_folder = |name| format!("{folder}/{name}");
    let room = common::room::room(ROOM_WIDTH);
    common::write(&in_folder("room.hdr"), &map_of(&room))?;
    common::write(&in_folder("clay.png"), &sphere(clay))?;
    common::write(&in_folder("slate.png"), &sphere(slate))?;
    Ok(())
}

fn planes(width: usize, height: usize, color: impl Fn(usize, usize) -> Vec3) -> ColorPlanes {
    let channel = |i| Plane::from_fn(width, height, |x, y| color(x, y)[i]);
    ColorPlanes {
        r: channel(0),
        g: channel(1),
        b: channel(2),
    }
}

fn map_of(room: &Environment) -> ColorPlanes {
    planes(room.width(), room.height(), |x, y| room.pixel(x, y).into())
}

/// A picture of a ball that touches its borders, with the colour `shade` of each normal. The rim is extended around the
/// ball.
fn sphere(shade: fn(Vec3) -> Vec3) -> ColorPlanes {
    let radius = SPHERE_WIDTH as f32 / 2.0;
    planes(SPHERE_WIDTH, SPHERE_WIDTH, |x, y| {
        let [x, y] = [x, y].map(|i| (i as f32 + 0.5) / radius - 1.0);
        let squared = x * x + y * y;
        let inside = 1.0 / squared.sqrt().max(1.0);
        let z = (1.0 - squared).max(0.0).sqrt();
        shade(Vec3::new(x * inside, -y * inside, z))
    })
}

/// Warm, under a broad light from the upper left, with a soft highlight.
fn clay(n: Vec3) -> Vec3 {
    let wrapped = 0.5 + 0.5 * n.dot(Vec3::new(-0.45, 0.65, 0.61));
    let highlight = n.dot(Vec3::new(-0.3, 0.42, 0.86)).max(0.0).powf(24.0);
    Vec3::new(0.08, 0.035, 0.03).lerp(Vec3::new(0.85, 0.52, 0.36), wrapped * wrapped)
        + 0.18 * highlight
}

/// Cool and dull, darkest where it faces down.
fn slate(n: Vec3) -> Vec3 {
    let wrapped = 0.5 + 0.5 * n.dot(Vec3::new(-0.2, 0.9, 0.39));
    Vec3::new(0.015, 0.02, 0.04).lerp(Vec3::new(0.16, 0.20, 0.28), wrapped)
}
