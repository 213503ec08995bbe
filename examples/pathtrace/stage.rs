//! The scenes of the pictures: a photographer's table, and things on it.

use super::light::AreaLight;
use super::material::{Glossy, Material};
use super::mesh::Mesh;
use super::render::Camera;
use super::scene::{Scene, SceneBuilder};
use super::urn::urn;
use crate::common::room::room;
use glam::Vec3;
use relievo::light::environment::Environment;
use std::f32::consts::FRAC_PI_2;

/// Columns of the room that lights the table.
const ROOM_WIDTH: usize = 512;

/// Columns and rows of the urn: about two to a pixel of the pictures.
const URN: [usize; 2] = [1100, 800];

/// A thing on the table, and who lights it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Setting {
    /// Unglazed clay in a room: [LW] figure 9.
    Clay,
    /// Glazed, in the same room.
    Glazed,
    /// Bronze before mirrors: [RS] figure 10.
    Mirrors,
    /// Plaster under an area light: [RS] figure 11.
    Lamp,
}

/// The scene: an urn on the table.
pub(crate) fn scene(setting: Setting) -> Scene {
    let glossy = |albedo: [f32; 3], exponent, reflectance| {
        Material::Glossy(Glossy::new(albedo.into(), exponent, reflectance))
    };
    let material = match setting {
        Setting::Clay => Material::Matte(Vec3::new(0.62, 0.36, 0.25)),
        Setting::Glazed => glossy([0.10, 0.26, 0.24], 60.0, 0.09),
        Setting::Mirrors => glossy([0.42, 0.24, 0.11], 40.0, 0.12),
        Setting::Lamp => Material::Matte(Vec3::new(0.78, 0.75, 0.70)),
    };
    let mut builder = SceneBuilder::default().mesh(urn(URN[0], URN[1]), material);
    if setting == Setting::Mirrors {
        let ball = Material::Mirror(Vec3::splat(0.93));
        builder = builder
            .mesh(standing_mirror(), Material::Mirror(Vec3::splat(0.9)))
            .sphere(Vec3::new(-0.62, 0.28, 1.1), 0.28, ball);
    }
    let (builder, table_color) = match setting {
        Setting::Lamp => {
            let dim = Environment::from_fn(1, 1, |_, _| [0.07, 0.09, 0.12]);
            let lamp = lamp(Vec3::new(-3.0, 3.3, 1.9), Vec3::Y);
            let builder = builder.area_light(lamp).surroundings(dim);
            (builder, Vec3::new(0.55, 0.54, 0.52))
        }
        _ => (
            builder.surroundings(room(ROOM_WIDTH)),
            Vec3::new(0.34, 0.33, 0.32),
        ),
    };
    builder.mesh(table(), Material::Matte(table_color)).build()
}

/// The camera of a scene.
pub(crate) fn camera(setting: Setting, size: [usize; 2]) -> Camera {
    let (eye, target, height_deg): ([f32; 3], [f32; 3], _) = match setting {
        Setting::Clay | Setting::Glazed => ([0.0, 2.2, 6.4], [0.0, 0.98, 0.0], 21.0),
        Setting::Mirrors => ([-0.2, 2.1, 6.8], [0.36, 0.93, 0.0], 22.5),
        Setting::Lamp => ([0.0, 2.7, 6.4], [0.45, 0.86, 0.0], 21.5),
    };
    Camera::new(eye.into(), target.into(), height_deg, size)
}

/// A square lamp, 1.1 wide, that faces `target`.
fn lamp(center: Vec3, target: Vec3) -> AreaLight {
    let away = (center - target).normalize();
    let right = Vec3::Y.cross(away).normalize();
    let [a, b] = [away.cross(right), right].map(|side| 1.1 * side);
    AreaLight {
        corner: center - 0.5 * (a + b),
        sides: [a, b],
        radiance: Vec3::new(33.0, 29.5, 25.0),
    }
}

/// An upright mirror behind the object, rotated so that the camera sees its far side.
fn standing_mirror() -> Mesh {
    let foot = Vec3::new(1.42, 0.0, -0.95);
    let normal = Vec3::new(-0.52, 0.0, 0.85).normalize();
    let across = 0.78 * Vec3::Y.cross(normal);
    let corners =
        [0.02, 2.25].map(|height| [-1.0, 1.0].map(|side| foot + height * Vec3::Y + side * across));
    Mesh::grid(corners.concat(), 2, false)
}

/// A sheet of paper that bends up behind the things on it.
fn table() -> Mesh {
    const BEND: usize = 48;
    let (front, back, radius, top, half_width) = (6.0, -2.2, 1.6, 7.0, 9.0);
    let mut section = vec![[front, 0.0]];
    section.extend((0..=BEND).map(|i| {
        let (sin, cos) = (FRAC_PI_2 * i as f32 / BEND as f32).sin_cos();
        [back - radius * sin, radius * (1.0 - cos)]
    }));
    section.push([back - radius, top]);
    let points = section
        .into_iter()
        .flat_map(|[z, y]| [-half_width, half_width].map(|x| Vec3::new(x, y, z)));
    Mesh::grid(points.collect(), 2, false)
}
