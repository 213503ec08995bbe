//! A render as an EXR file, its layers named as Blender names them.

use super::render::{Job, Middle, Pixel};
use glam::Vec3;
use relievo::frame::{Plane, Window};
use relievo::io::exr::{OutputChannel, OutputPart, OutputType, write_results};
use relievo::io::output::{Replace, write_atomically};
use std::path::Path;

/// Blender's depth where there is no surface.
const NO_DEPTH: f32 = 1e10;

/// A layer: its name, its components, how it is stored, and its planes.
struct Layer {
    name: &'static str,
    components: &'static [&'static str],
    sample_type: OutputType,
    planes: Vec<Plane>,
}

/// Layers written beside those that every file has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extras {
    /// Hit positions seen in mirrors and glass.
    pub(crate) hit_positions: bool,
    /// Radius within which things darken corners.
    pub(crate) ambient_reach: f32,
}

/// Renders the job and writes it.
pub(crate) fn write_layers(path: &Path, job: &Job, extras: Extras) -> relievo::Result<()> {
    let mut pixels = job.pixels();
    job.describe(&mut pixels, extras.ambient_reach);
    let middles = job.middles();
    let layers = layers(job.camera.size, &pixels, &middles, extras);
    let [width, height] = job.camera.size;
    let window = Window::from_size(width, height);
    let mut channels = Vec::new();
    for layer in &layers {
        for (component, plane) in layer.components.iter().zip(&layer.planes) {
            channels.push(OutputChannel {
                name: format!("ViewLayer.{}.{component}", layer.name),
                plane,
                sample_type: layer.sample_type,
            });
        }
    }
    let part = OutputPart {
        name: "ViewLayer".into(),
        data_window: window,
        display_window: window,
        pixel_aspect: 1.0,
        channels,
        attributes: vec![("software".into(), "relievo, examples/pathtrace.rs".into())],
        chromaticities: None,
        compression: Default::default(),
    };
    write_atomically(path, Replace::IfWritable, |w| write_results(w, path, &part))
}

fn layers(
    size: [usize; 2],
    pixels: &[Pixel],
    middles: &[Option<Middle>],
    extras: Extras,
) -> Vec<Layer> {
    let [width, height] = size;
    let plane =
        |value: &dyn Fn(usize) -> f32| Plane::from_fn(width, height, |x, y| value(y * width + x));
    let vector = |value: &dyn Fn(usize) -> Vec3| -> Vec<Plane> {
        (0..3).map(|c| plane(&|i| value(i)[c])).collect()
    };
    let color = |name, value: &dyn Fn(&Pixel) -> Vec3| Layer {
        name,
        components: &["R", "G", "B"],
        sample_type: OutputType::Half,
        planes: vector(&|i| value(&pixels[i])),
    };
    let place = |name, value: &dyn Fn(&Middle) -> Option<Vec3>| Layer {
        name,
        components: &["X", "Y", "Z"],
        sample_type: OutputType::Float,
        planes: vector(&|i| middles[i].as_ref().and_then(value).unwrap_or(Vec3::ZERO)),
    };
    // Light before the surface's colour: black reflects none.
    let light = |light: Vec3, albedo: Vec3| {
        let inverse = albedo.map(|a| if a > 0.0 { 1.0 / a } else { 0.0 });
        light * inverse
    };
    // The background is left out, as on a transparent film.
    let mut combined = vector(&|i| pixels[i].passes.sum() - pixels[i].passes.background);
    combined.push(plane(&|i| pixels[i].coverage));
    let mut layers = vec![
        Layer {
            name: "Combined",
            components: &["R", "G", "B", "A"],
            sample_type: OutputType::Half,
            planes: combined,
        },
        place("Normal", &|middle| Some(middle.normal)),
        place("Position", &|middle| Some(middle.position)),
        Layer {
            name: "Depth",
            components: &["Z"],
            sample_type: OutputType::Float,
            planes: vec![plane(&|i| middles[i].map_or(NO_DEPTH, |m| m.depth))],
        },
        color("DiffDir", &|p| light(p.passes.direct[0], p.albedo)),
        color("DiffInd", &|p| light(p.passes.indirect[0], p.albedo)),
        color("DiffCol", &|p| p.albedo),
        color("GlossDir", &|p| p.passes.direct[1]),
        color("GlossInd", &|p| p.passes.indirect[1]),
        // Lobes hold their own reflectance, mirrors their tint.
        color("GlossCol", &|p| Vec3::splat(p.coverage)),
        color("Emit", &|p| p.passes.emission),
        color("AO", &|p| Vec3::splat(p.ambient)),
    ];
    if extras.hit_positions {
        layers.push(place("HitPosition", &|middle| middle.seen_by_way));
    }
    layers
}
