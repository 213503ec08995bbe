//! A photo and a render lit by `relievo relight`: the contact sheet in the README.
//!
//! `cargo run --release -p examples --example relight_sheet -- OUT.jpg`, from the folder that holds `fixtures`.

mod common;

use common::{grid, light_from, load, over_backdrop, relit};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::io::{read_environment, read_lit_sphere};
use relievo::light::lights::Illumination;
use relievo::params::{Material, MaterialParams, Method, RelightParams, ScalingParams};
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

/// Columns of the bust that are shown: four of these are as wide as six tablets.
const BUST_COLUMNS: std::ops::Range<usize> = 48..432;

/// A page is read before its pictures are: two thirds of the bytes at no loss that shows.
const JPEG_QUALITY: u8 = 85;

fn main() -> ExitCode {
    common::exit(run())
}

fn run() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1);
    let output = output.ok_or("usage: relight_sheet OUT.jpg")?;
    let normal = Some("fixtures/tablet.normal.png");
    let tablet = row_of_the_tablet(&load("fixtures/tablet.color.jpg", normal)?)?;
    let bust = rows_of_the_bust(&load("fixtures/bust.exr", None)?)?;
    let sheet = above(&grid(&tablet, 6), &grid(&bust, 4));
    let (width, height) = (sheet.r.width() as u32, sheet.r.height() as u32);
    let mut file = std::fs::File::create(output)?;
    let encoder = JpegEncoder::new_with_quality(&mut file, JPEG_QUALITY);
    encoder.write_image(
        &common::codes(&sheet),
        width,
        height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(())
}

/// The photo, raking light by each method, and specular enhancement.
fn row_of_the_tablet(frame: &Frame) -> Result<Vec<ColorPlanes>, Box<dyn Error>> {
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
    row.push(shown(
        frame,
        &light_from(135.0, 45.0),
        Method::Plain,
        polished,
    )?);
    Ok(row)
}

/// An environment, altered and not; materials; lit spheres.
fn rows_of_the_bust(frame: &Frame) -> Result<Vec<ColorPlanes>, Box<dyn Error>> {
    let room = Illumination {
        environment: Some(read_environment(Path::new("fixtures/room.hdr"))?.into()),
        ..Illumination::default()
    };
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
        Ok(columns(&picture, BUST_COLUMNS))
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

fn columns(picture: &ColorPlanes, columns: std::ops::Range<usize>) -> ColorPlanes {
    let height = picture.r.height();
    let cut = |plane: &Plane| {
        Plane::from_fn(columns.len(), height, |x, y| plane.at(columns.start + x, y))
    };
    ColorPlanes {
        r: cut(&picture.r),
        g: cut(&picture.g),
        b: cut(&picture.b),
    }
}

/// Two pictures of one width.
fn above(upper: &ColorPlanes, lower: &ColorPlanes) -> ColorPlanes {
    let join = |upper: &Plane, lower: &Plane| {
        let samples = [upper.samples(), lower.samples()].concat();
        Plane::from_samples(upper.width(), upper.height() + lower.height(), samples)
    };
    ColorPlanes {
        r: join(&upper.r, &lower.r),
        g: join(&upper.g, &lower.g),
        b: join(&upper.b, &lower.b),
    }
}
