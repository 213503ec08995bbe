//! A small scene whose light is in layers: lobes of a coloured surface, and the picture that they add up to.

use super::{channels, colors};
use glam::Vec3;
use relievo::frame::{ColorPlanes, Frame, LightLayers, Lobe, LobeLayers, Mask, Plane};
use relievo::scenes::{ExactScene, Surface};

pub const WIDTH: usize = 61;
pub const HEIGHT: usize = 40;

/// Waves across the picture, a strip at its right uncovered, under white light on a coloured surface, with
/// warm highlights; the picture is their sum and a little light that no layer holds.
pub fn scene() -> Frame {
    let surface = Surface::sine_relief(2.0, 19.0, 0.4);
    let mut frame = ExactScene::orthographic(surface, 30.0, 20.0).frame(WIDTH, HEIGHT);
    frame.mask = Mask::new(Plane::from_fn(WIDTH, HEIGHT, |x, _| x < WIDTH - 5));
    let facing =
        |x: usize, y: usize, to: Vec3| normal_at(&frame, x, y).dot(to.normalize()).max(0.0);
    let light = |tint: [f32; 3], value: &dyn Fn(usize, usize) -> f32| {
        color(|i, x, y| tint[i] * value(x, y))
    };
    let lit = |x, y| facing(x, y, Vec3::new(1.0, 1.0, 1.0));
    let stripes = |x: usize, _| if x % 9 < 4 { 1.0 } else { 0.2 };
    let diffuse = LobeLayers {
        lobe: Lobe::Diffuse,
        direct: Some(light([0.9; 3], &lit)),
        indirect: Some(light([0.1; 3], &|_, y| 0.5 + y as f32 / 80.0)),
        color: Some(light([0.6, 0.3, 0.1], &stripes)),
        albedo: None,
    };
    let glint = |x, y| facing(x, y, Vec3::new(0.3, 0.2, 1.0)).powi(60);
    let specular = LobeLayers {
        lobe: Lobe::Specular,
        direct: Some(light([3.0, 2.5, 2.0], &glint)),
        indirect: None,
        color: Some(light([0.04; 3], &|_, _| 1.0)),
        albedo: None,
    };
    let lobes = vec![diffuse, specular];
    frame.color = Some(color(|i, x, y| {
        0.001 + lobes.iter().map(|l| radiance(l, i, x, y)).sum::<f32>()
    }));
    frame.light = LightLayers {
        lobes,
        ..LightLayers::default()
    };
    frame
}

pub fn color(value: impl Fn(usize, usize, usize) -> f32) -> ColorPlanes {
    colors([WIDTH, HEIGHT], value)
}

pub fn normal_at(frame: &Frame, x: usize, y: usize) -> Vec3 {
    frame.normal.at(x, y).as_vec3()
}

pub fn light(lobe: &LobeLayers, i: usize, x: usize, y: usize) -> f32 {
    let layers = [&lobe.direct, &lobe.indirect].into_iter().flatten();
    layers.map(|planes| channels(planes)[i].at(x, y)).sum()
}

pub fn radiance(lobe: &LobeLayers, i: usize, x: usize, y: usize) -> f32 {
    let color = lobe.color.as_ref().map_or(1.0, |p| channels(p)[i].at(x, y));
    light(lobe, i, x, y) * color
}
