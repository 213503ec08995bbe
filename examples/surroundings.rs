//! An environment and two lit spheres by formula: `room.hdr`, `clay.png` and `slate.png`, to light
//! surfaces with.
//!
//! `cargo run --release -p examples --example surroundings -- FOLDER`

mod common;

use common::Outcome;
use glam::Vec3;
use relievo::frame::{ColorPlanes, Plane};
use std::process::ExitCode;

const ROOM_WIDTH: usize = 256;
const SPHERE_WIDTH: usize = 128;

fn main() -> ExitCode {
    common::run(|arguments| match arguments {
        [folder] => write_all(folder),
        _ => Err("usage: surroundings FOLDER".into()),
    })
}

fn write_all(folder: &str) -> Outcome<()> {
    let in_folder = |name| format!("{folder}/{name}");
    let room = common::room::room(ROOM_WIDTH);
    let map = planes(room.width(), room.height(), |x, y| room.pixel(x, y).into());
    common::write(&in_folder("room.hdr"), &map)?;
    common::write(&in_folder("clay.png"), &sphere(clay))?;
    common::write(&in_folder("slate.png"), &sphere(slate))?;
    Ok(())
}

fn planes(width: usize, height: usize, color: impl Fn(usize, usize) -> Vec3) -> ColorPlanes {
    let [r, g, b] = [0, 1, 2].map(|i| Plane::from_fn(width, height, |x, y| color(x, y)[i]));
    ColorPlanes { r, g, b }
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
