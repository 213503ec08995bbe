//! Cameras of real renders, recovered from their position layers and read from the JSON beside them.
//!
//! The renders are not part of this crate: where their folder is absent, these tests say so and pass.

use exr::prelude::*;
use glam::DVec3;
use relievo::frame::{Camera, Mask, NormalSpace, Plane, Projection, Vector3Planes, Window};
use relievo::io::camera::{RecoveredCamera, RecoveryFailure, read_camera, recover_camera};
use relievo::io::normal_space::{NormalSpaceConclusion, judge_normal_space};
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

    /// Pixels nearer than the background, or with a position where there is no depth.
    fn mask(&self, position: &Vector3Planes) -> Mask {
        if let Some(depth) = self.layer("Depth.Z") {
            return Mask::new(depth.map(|d| d < 1e9));
        }
        let p = position;
        let seen = |x: usize, y: usize| [&p.x, &p.y, &p.z].iter().any(|p| p.at(x, y) != 0.0);
        Mask::new(Plane::from_fn(p.x.width(), p.x.height(), seen))
    }

    fn recover(&self) -> Option<(Result<RecoveredCamera, RecoveryFailure>, f64)> {
        let position = self.vector("Position")?;
        let mask = self.mask(&position);
        let start = Instant::now();
        let found = recover_camera(&position, &mask, self.data, self.display, self.aspect);
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

fn eye(camera: &Camera) -> DVec3 {
    camera.view_from_world.inverse().translation
}

#[test]
fn recovered_cameras_match_the_renders() {
    println!(
        "{:<36} {:>9} {:>8} {:>8} {:>8} {:>7} {:>6} {:>6} {:>7}",
        "render", "turn deg", "focal %", "eye", "med px", "p95 px", "in %", "n", "ms"
    );
    let mut worst: f64 = 0.0;
    for path in renders().into_iter().filter(|p| !is_panorama(p)) {
        let render = Render::read(&path).expect("a render with layers");
        let Some((found, ms)) = render.recover() else {
            continue;
        };
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let found = match found {
            Ok(found) => found,
            Err(failure) => panic!("{name}: {failure}"),
        };
        let truth = read_camera(&path.with_extension("json"), render.display, render.aspect)
            .expect("a camera beside the render");
        let turn = turn_deg(&found.camera, &truth);
        println!(
            "{name:<36} {turn:>9.5} {:>8.4} {:>8.5} {:>8.4} {:>7.3} {:>6.1} {:>6} {ms:>7.1}",
            100.0 * (focal(&found.camera) / focal(&truth) - 1.0),
            (eye(&found.camera) - eye(&truth)).length(),
            found.residual_px_median,
            found.residual_px_p95,
            100.0 * found.inlier_share,
            found.samples,
        );
        worst = worst.max(turn);
    }
    assert!(worst < 0.05, "a camera is off by {worst} degrees");
}

#[test]
fn panoramas_are_refused() {
    for path in renders().into_iter().filter(|p| is_panorama(p)) {
        let render = Render::read(&path).expect("a render with layers");
        let (found, ms) = render.recover().expect("positions");
        let failure = found.expect_err("fitted a panorama");
        println!("{}: {failure} ({ms:.1} ms)", path.display());
        assert!(matches!(failure, RecoveryFailure::NotACamera { .. }));
        let error = read_camera(&path.with_extension("json"), render.display, 1.0)
            .expect_err("read a panorama's camera");
        assert!(error.to_string().contains("panorama"), "{error}");
    }
}

const WORLD: NormalSpaceConclusion = NormalSpaceConclusion::Certain {
    space: NormalSpace::World,
    flip_z: false,
};
const VIEW: NormalSpaceConclusion = NormalSpaceConclusion::Certain {
    space: NormalSpace::View,
    flip_z: false,
};
const VIEW_FLIPPED: NormalSpaceConclusion = NormalSpaceConclusion::Certain {
    space: NormalSpace::View,
    flip_z: true,
};

/// The normals turned to the view, z toward the viewer or away from it.
fn turned(normal: &Vector3Planes, camera: &Camera, sign: f64) -> Vector3Planes {
    let n = normal;
    let at = |x, y| {
        DVec3::new(
            n.x.at(x, y).into(),
            n.y.at(x, y).into(),
            n.z.at(x, y).into(),
        )
    };
    let view = |x, y| camera.view_from_world.matrix3 * at(x, y) * DVec3::new(1.0, 1.0, sign);
    let plane =
        |axis: usize| Plane::from_fn(n.x.width(), n.x.height(), |x, y| view(x, y)[axis] as f32);
    Vector3Planes {
        x: plane(0),
        y: plane(1),
        z: plane(2),
    }
}

/// One normal layer judged with every selection of clues; the wrong conclusions.
fn misjudged(
    render: &Render,
    normal: &Vector3Planes,
    truth: NormalSpaceConclusion,
    camera: &Camera,
) -> Vec<String> {
    let position = render.vector("Position");
    let depth = render.layer("Depth.Z");
    let mask = match &depth {
        Some(depth) => Mask::new(depth.map(|d| d < 1e9)),
        None => render.mask(normal),
    };
    let blind = if truth == WORLD {
        NormalSpaceConclusion::WorldWithoutCamera
    } else {
        truth
    };
    // Facing alone may leave a view-space guess open, but must not be sure and wrong.
    let clues = [
        ("camera", None, None, Some(camera), truth, false),
        (
            "camera+depth",
            None,
            depth.as_ref(),
            Some(camera),
            truth,
            false,
        ),
        (
            "camera+position",
            position.as_ref(),
            None,
            Some(camera),
            truth,
            false,
        ),
        ("depth", None, depth.as_ref(), None, blind, false),
        ("nothing", None, None, None, blind, true),
    ];
    let mut wrong = Vec::new();
    for (name, position, depth, camera, expected, may_be_open) in clues {
        let verdict = judge_normal_space(normal, &mask, position, depth, camera, render.data);
        println!("  {name:<16} {}", verdict.reason);
        let open = may_be_open && verdict.conclusion == NormalSpaceConclusion::Ambiguous;
        if verdict.conclusion != expected && !open {
            wrong.push(format!("{name}: {}", verdict.reason));
        }
    }
    wrong
}

#[test]
fn normals_of_renders_are_judged_right() {
    let mut wrong = Vec::new();
    for path in renders().into_iter().filter(|p| !is_panorama(p)) {
        let render = Render::read(&path).expect("a render with layers");
        let Some(normal) = render.vector("ViewLayer.Normal") else {
            continue;
        };
        let camera = read_camera(&path.with_extension("json"), render.display, render.aspect)
            .expect("a camera beside the render");
        let readings = [
            ("world", normal.clone(), WORLD),
            ("view", turned(&normal, &camera, 1.0), VIEW),
            ("flipped", turned(&normal, &camera, -1.0), VIEW_FLIPPED),
        ];
        for (kind, normal, truth) in readings {
            println!("{} as {kind}", path.display());
            wrong.extend(
                misjudged(&render, &normal, truth, &camera)
                    .into_iter()
                    .map(|w| format!("{} as {kind}, {w}", path.display())),
            );
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn photographed_normal_maps_are_view_space() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/rgbn"));
    let names = ["Bricks102_1K-JPG_NormalGL.jpg", "rock058_1k_NormalGL.jpg"];
    for path in names.map(|n| folder.join(n)) {
        if !path.exists() {
            eprintln!("skipped: no {}", path.display());
            continue;
        }
        let picture = image::open(&path).expect("a readable picture").to_rgb8();
        let (w, h) = (picture.width() as usize, picture.height() as usize);
        let plane = |channel: usize| {
            Plane::from_fn(w, h, |x, y| {
                f32::from(picture.get_pixel(x as u32, y as u32)[channel]) / 127.5 - 1.0
            })
        };
        let normal = Vector3Planes {
            x: plane(0),
            y: plane(1),
            z: plane(2),
        };
        let (mask, window) = (Mask::full(w, h), Window::from_size(w, h));
        let verdict = judge_normal_space(&normal, &mask, None, None, None, window);
        println!("{}: {}", path.display(), verdict.reason);
        assert_eq!(verdict.conclusion, VIEW);
    }
}
