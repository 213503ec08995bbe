//! Cameras of real renders, recovered from their depth and normals and read from the JSON beside them.
//!
//! The renders are not part of this crate: where their folder is absent, these tests say so and pass.

use exr::prelude::*;
use glam::DVec3;
use relievo::frame::{Camera, Mask, Plane, Projection, Vector3Planes, Window};
use relievo::io::camera::{DepthCamera, RecoveryFailure, read_camera, recover_camera_from_depth};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A render's layers, as wide as its data window.
struct Render {
    layers: Vec<(String, Plane)>,
    data: Window,
    display: Window,
    aspect: f32,
}

impl Render {
    fn read(path: &Path) -> Option<Render> {
        let image = read_all_flat_layers_from_file(path).expect("a readable render");
        let first = image.layer_data.first()?;
        let (corner, size) = (first.attributes.layer_position, first.size);
        let mut layers = Vec::new();
        for layer in &image.layer_data {
            for channel in &layer.channel_data.list {
                let samples: Vec<f32> = channel.sample_data.values_as_f32().collect();
                let plane = Plane::from_samples(size.x(), size.y(), samples);
                layers.push((channel.name.to_string(), plane));
            }
        }
        let shown = image.attributes.display_window;
        Some(Render {
            layers,
            data: Window::at(corner.x(), corner.y(), size.x(), size.y()),
            display: Window::at(
                shown.position.x(),
                shown.position.y(),
                shown.size.x(),
                shown.size.y(),
            ),
            aspect: image.attributes.pixel_aspect,
        })
    }

    fn layer(&self, end: &str) -> Option<Plane> {
        let found = self.layers.iter().find(|(name, _)| name.ends_with(end));
        found.map(|(_, plane)| plane.clone())
    }

    fn vector(&self, name: &str) -> Option<Vector3Planes> {
        Some(Vector3Planes {
            x: self.layer(&format!("{name}.X"))?,
            y: self.layer(&format!("{name}.Y"))?,
            z: self.layer(&format!("{name}.Z"))?,
        })
    }

    fn recover(&self) -> Option<(Result<DepthCamera, RecoveryFailure>, f64)> {
        let (normal, depth) = (self.vector("Normal")?, self.layer("Depth.Z")?);
        let mask = Mask::new(depth.map(|d| d < 1e9));
        let start = Instant::now();
        let (data, display) = (self.data, self.display);
        let found = recover_camera_from_depth(&normal, &depth, &mask, data, display, self.aspect);
        Some((found, start.elapsed().as_secs_f64() * 1e3))
    }
}

type Result<T, E> = std::result::Result<T, E>;

fn renders() -> Vec<PathBuf> {
    let folder = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../shared/data/renders"
    ));
    let mut files: Vec<PathBuf> = [folder.to_path_buf(), folder.join("seq")]
        .iter()
        .filter_map(|f| std::fs::read_dir(f).ok())
        .flatten()
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "exr"))
        .collect();
    files.sort();
    if files.is_empty() {
        eprintln!("skipped: no renders at {}", folder.display());
    }
    files
}

fn is_panorama(path: &Path) -> bool {
    path.to_string_lossy().contains("pano")
}

fn turn_deg(a: &Camera, b: &Camera) -> f64 {
    let m = a.view_from_world.matrix3 * b.view_from_world.matrix3.transpose();
    let twice_sine = DVec3::new(
        m.y_axis.z - m.z_axis.y,
        m.z_axis.x - m.x_axis.z,
        m.x_axis.y - m.y_axis.x,
    );
    let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    twice_sine.length().atan2(trace - 1.0).to_degrees()
}

fn focal(camera: &Camera) -> f64 {
    match camera.projection {
        Projection::Perspective { fx, .. } => fx,
        Projection::Orthographic { .. } => f64::INFINITY,
    }
}

#[test]
fn rotations_match_the_renders() {
    println!(
        "{:<44} {:>8} {:>8} {:>8} {:>8} {:>8} {:>6} {:>7}",
        "render", "turn deg", "+- deg", "focal %", "+- %", "med deg", "n", "ms"
    );
    let (mut worst, mut worst_tiny) = (0.0f64, 0.0f64);
    for path in renders().into_iter().filter(|p| !is_panorama(p)) {
        let render = Render::read(&path).expect("a render with layers");
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let Some((found, ms)) = render.recover() else {
            println!("{name:<44} has no normals with depth");
            continue;
        };
        let found = match found {
            Ok(found) => found,
            Err(failure) => panic!("{name}: {failure}"),
        };
        let truth = read_camera(&path.with_extension("json"), render.display, render.aspect)
            .expect("a camera beside the render");
        let turn = turn_deg(&found.camera, &truth);
        println!(
            "{name:<44} {turn:>8.4} {:>8.4} {:>8.3} {:>8.3} {:>8.4} {:>6} {ms:>7.1}",
            found.rotation_uncertainty_deg,
            100.0 * (focal(&found.camera) / focal(&truth) - 1.0),
            100.0 * found.focal_uncertainty,
            found.residual_deg_median,
            found.samples,
        );
        let tiny = render.data.width() < 100;
        let worst = if tiny { &mut worst_tiny } else { &mut worst };
        *worst = worst.max(turn);
        assert!(tiny || turn < 4.0 * found.rotation_uncertainty_deg + 0.01);
    }
    assert!(worst < 0.2, "a camera is off by {worst} degrees");
    assert!(worst_tiny < 1.0, "a camera is off by {worst_tiny} degrees");
}

#[test]
fn view_space_normals_come_out_unturned() {
    for path in renders().into_iter().filter(|p| !is_panorama(p)) {
        let render = Render::read(&path).expect("a render with layers");
        let (Some(world), Some(depth)) = (render.vector("Normal"), render.layer("Depth.Z")) else {
            continue;
        };
        let truth = read_camera(&path.with_extension("json"), render.display, render.aspect)
            .expect("a camera beside the render");
        let turned = |axis: usize| {
            Plane::from_fn(depth.width(), depth.height(), |x, y| {
                let n = DVec3::new(
                    world.x.at(x, y).into(),
                    world.y.at(x, y).into(),
                    world.z.at(x, y).into(),
                );
                (truth.view_from_world.matrix3 * n)[axis] as f32
            })
        };
        let view = Vector3Planes {
            x: turned(0),
            y: turned(1),
            z: turned(2),
        };
        let mask = Mask::new(depth.map(|d| d < 1e9));
        let (data, display) = (render.data, render.display);
        let found = recover_camera_from_depth(&view, &depth, &mask, data, display, render.aspect)
            .expect("a camera");
        let unturned = Camera {
            view_from_world: glam::DAffine3::IDENTITY,
            ..found.camera
        };
        let turn = turn_deg(&found.camera, &unturned);
        assert!(turn < 1.0, "{}: {turn} degrees", path.display());
    }
}
