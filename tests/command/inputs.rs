//! Frames of a shot and pictures, for the program to read.

use crate::common::exr::Part;
use crate::common::program::Desk;
use relievo::frame::{ColorPlanes, Plane};
use relievo::io::output::{Replace, write_atomically};
use relievo::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
use std::f32::consts::TAU;

impl Desk {
    /// A desk with frames of these numbers, each with its own brightness.
    pub(crate) fn of_frames(numbers: std::ops::RangeInclusive<i32>) -> Self {
        let desk = Self::new();
        for number in numbers {
            desk.write_frame(number, 64, 0.5 + 0.1 * number as f32);
        }
        desk
    }

    /// Writes frame `number`: bumps under a light of this luminance, `size` pixels on a side.
    pub(crate) fn write_frame(&self, number: i32, size: usize, luminance: f32) {
        let name = format!("in.{number:04}.exr");
        self.write_bumps(&name, number, [size, size], luminance, |_| false);
    }

    /// Writes bumps that are a plane in some rows.
    pub(crate) fn write_bumps(
        &self,
        name: &str,
        number: i32,
        [width, height]: [usize; 2],
        luminance: f32,
        is_plane: impl Fn(usize) -> bool,
    ) {
        // z = cos(x) cos(y) with a period of 24 px: slopes are its derivatives, up to 0.5.
        let wave = |x: usize| x as f32 * TAU / 24.0 + number as f32;
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
        part.text("samplesPerPixel", "64").write(&self.at(name));
    }

    /// Writes channels of 32 bits.
    pub(crate) fn write_exr(&self, name: &str, channels: &[(&str, &Plane)]) {
        Part::of(channels.iter().copied()).write(&self.at(name));
    }

    /// Writes shares of the largest code, in the format of the name's extension.
    pub(crate) fn write_codes(&self, name: &str, planes: [Plane; 3], bits: u8) {
        self.write_planes(name, planes, None, bits, ViewTransform::None);
    }

    /// Writes light, as sRGB in 8 bits.
    pub(crate) fn write_light(&self, name: &str, planes: [Plane; 3]) {
        self.write_planes(name, planes, None, 8, ViewTransform::Srgb);
    }

    pub(crate) fn write_planes(
        &self,
        name: &str,
        [r, g, b]: [Plane; 3],
        alpha: Option<&Plane>,
        bits: u8,
        transform: ViewTransform,
    ) {
        let (path, color) = (self.at(name), ColorPlanes { r, g, b });
        let picture = Picture {
            alpha,
            bits,
            ..Picture::of(&color, transform)
        };
        let format = PictureFormat::of_path(&path).unwrap();
        write_atomically(&path, Replace::IfWritable, |w| {
            write_picture(w, &path, format, &picture)
        })
        .unwrap();
    }
}

/// A plane for each channel of a grey picture.
pub(crate) fn grey(plane: Plane) -> [Plane; 3] {
    [plane.clone(), plane.clone(), plane]
}
