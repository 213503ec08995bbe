//! A photo and a render lit by `relievo relight`: the contact sheet in the README.
//!
//! `cargo run --release -p examples --example relight_sheet -- OUT.jpg`, from the folder that holds `fixtures`.

mod common;

use common::{Outcome, each, grid, light_around, light_from, load, over_backdrop, relit, rgb};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::io::{read_environment, read_lit_sphere};
use relievo::light::lights::Illumination;
use relievo::params::{Material, MaterialParams, Method, RelightParams, ScalingParams};
use std::path::Path;
use std::process::ExitCode;

/// Columns of the bust that are shown: four of these are as wide as six tablets.
const BUST_COLUMNS: std::ops::Range<usize> = 48..432;

/// A page is read before its pictures are: two thirds of the bytes at no loss that shows.
const JPEG_QUALITY: u8 = 85;

fn main() -> ExitCode {
    common::run(|arguments| match arguments {
        [output] => sheet(output),
        _ => Err("usage: relight_sheet OUT.jpg".into()),
    })
}

fn sheet(output: &str) -> Outcome<()> {
    let normal = Some("fixtures/tablet.normal.png");
    let tablet = rgb(&grid(
        &tablet(&load("fixtures/tablet.color.jpg", normal)?)?,
        6,
    ));
    let bust = rgb(&grid(&bust(&load("fixtures/bust.exr", None)?)?, 4));
    let (width, height) = (tablet.width(), tablet.height() + bust.height());
    let samples = [tablet.into_raw(), bust.into_raw()].concat();
    let sheet = image::RgbImage::from_raw(width, height, samples).expect("both are as wide");
    common::write_jpeg(Path::new(output), &sheet.into(), JPEG_QUALITY)
}

/// The photo, raking light by each method, and specular enhancement.
fn tablet(frame: &Frame) -> Outcome<Vec<ColorPlanes>> {
    let photo = frame.color.as_ref().ok_or("the photo has no colour")?;
    let mut row = vec![over_backdrop(photo, frame)];
    for method in [Method::Plain, Method::Warp, Method::Scale, Method::Both] {
        row.push(shown(frame, &light_from(75.0, 25.0), method, matte())?);
    }
    let polished = MaterialParams {
        material: Material::BlinnPhong,
        diffuse_gain: 0.3,
        specular_gain: Some(0.7),
        shininess: 20.0,
        ..matte()
    };
    let light = light_from(135.0, 45.0);
    row.push(shown(frame, &light, Method::Plain, polished)?);
    Ok(row)
}

/// An environment, altered and not; materials; lit spheres.
fn bust(frame: &Frame) -> Outcome<Vec<ColorPlanes>> {
    let room = light_around(read_environment(Path::new("fixtures/room.hdr"))?);
    let spheres = |paths: &[&str]| -> relievo::Result<Illumination> {
        let spheres = paths.iter().map(|path| read_lit_sphere(Path::new(path)));
        Ok(Illumination {
            lit_spheres: spheres.collect::<relievo::Result<_>>()?,
            ..Illumination::default()
        })
    };
    let clay = spheres(&["fixtures/clay.png"])?;
    let clay_and_slate = spheres(&["fixtures/clay.png", "fixtures/slate.png"])?;
    let made_of = |material| MaterialParams {
        material,
        ..matte()
    };
    let glossy = made_of(Material::AshikhminShirley);
    let (mirror, toon) = (made_of(Material::Mirror), made_of(Material::Toon));
    let glass = MaterialParams {
        thin: true,
        ..made_of(Material::Glass)
    };
    let cells = [
        (&room, Method::Plain, matte()),
        (&room, Method::Both, matte()),
        (&room, Method::Both, glossy),
        (&light_from(120.0, 40.0), Method::Both, toon),
        (&room, Method::Both, mirror),
        (&room, Method::Both, glass),
        (&clay, Method::Both, matte()),
        (&clay_and_slate, Method::Both, matte()),
    ];
    let pictures = cells.into_iter().map(|(light, method, material)| {
        let picture = shown(frame, light, method, material)?;
        Ok(each(&picture, |plane| {
            Plane::from_fn(BUST_COLUMNS.len(), plane.height(), |x, y| {
                plane.at(BUST_COLUMNS.start + x, y)
            })
        }))
    });
    pictures.collect()
}

fn matte() -> MaterialParams {
    RelightParams::default().material
}

fn shown(
    frame: &Frame,
    light: &Illumination,
    method: Method,
    material: MaterialParams,
) -> relievo::Result<ColorPlanes> {
    let params = RelightParams {
        method,
        material,
        ..RelightParams::default()
    };
    relit(frame, light, params, ScalingParams::default())
}
