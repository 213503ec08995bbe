//! Frames of a shot, for the program to read.

use crate::common::exr::Part;
use relievo::frame::{ColorPlanes, Plane};
use relievo::io::output::{Replace, write_atomically};
use relievo::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
use std::fs;
use std::io::Cursor;
use std::path::Path;

/// Writes frame `number`: bumps under a light of this luminance, `size` pixels on a side.
pub(crate) fn write_frame(directory: &Path, number: i32, size: usize, luminance: f32) {
    let path = directory.join(format!("in.{number:04}.exr"));
    write_bumps(&path, number, [size, size], luminance, |_| false);
}

/// Writes bumps that are a plane in some rows.
pub(crate) fn write_bumps(
    path: &Path,
    number: i32,
    [width, height]: [usize; 2],
    luminance: f32,
    is_plane: impl Fn(usize) -> bool,
) {
    // z = cos(x) cos(y) with a period of 24 px: slopes are its derivatives, up to 0.5.
    let wave = |x: usize| x as f32 * std::f32::consts::TAU / 24.0 + number as f32;
    let normal = |x: usize, y: usize| {
        if is_plane(y) {
            return glam::Vec3::Z;
        }
        let (x, y) = (wave(x), wave(y));
        glam::Vec3::new(0.5 * x.sin() * y.cos(), -0.5 * x.cos() * y.sin(), 1.0).normalize()
    };
    let plane = |value: &dyn Fn(usize, usize) -> f32| Plane::from_fn(width, height, value);
    let lit = plane(&|x, y| luminance * normal(x, y).z);
    let normals = [0, 1, 2].map(|axis| plane(&|x, y| normal(x, y)[axis]));
    let [x, y, z] = &normals;
    let depth = Plane::filled(width, height, 5.0);
    let picture = ["R", "G", "B"].map(|name| (name, &lit));
    let layers = [("N.X", x), ("N.Y", y), ("N.Z", z), ("Z", &depth)];
    // As pbrt writes it: nothing else shows which way x points.
    let part = Part::of(picture.into_iter().chain(layers));
    part.text("samplesPerPixel", "64").write(path);
}

/// Writes a picture of these planes, in the format of its extension.
pub(crate) fn write_planes(
    path: &Path,
    [r, g, b]: [Plane; 3],
    alpha: Option<&Plane>,
    bits: u8,
    transform: ViewTransform,
) {
    let color = ColorPlanes { r, g, b };
    let picture = Picture {
        alpha,
        bits,
        ..Picture::of(&color, transform)
    };
    let format = PictureFormat::of_path(path).unwrap();
    write_atomically(path, Replace::IfWritable, |w| {
        write_picture(w, path, format, &picture)
    })
    .unwrap();
}

/// A desk with frames of these numbers, each with its own brightness.
pub(crate) fn desk(numbers: std::ops::RangeInclusive<i32>) -> tempfile::TempDir {
    let desk = tempfile::tempdir().unwrap();
    for number in numbers {
        write_frame(desk.path(), number, 64, 0.5 + 0.1 * number as f32);
    }
    desk
}

/// The bytes of a file; for a PNG those of its pixels, since the others record its settings.
pub(crate) fn bytes(directory: &Path, name: &str) -> Vec<u8> {
    let file = fs::read(directory.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    shown(&file).unwrap_or(file)
}

/// The samples of a PNG.
fn shown(file: &[u8]) -> Option<Vec<u8>> {
    let mut reader = png::Decoder::new(Cursor::new(file)).read_info().ok()?;
    let mut samples = vec![0; reader.output_buffer_size()?];
    reader.next_frame(&mut samples).ok()?;
    Some(samples)
}
