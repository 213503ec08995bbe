//! The pictures of the guide: figures 9 of [LW], 10 and 11 of [RS], of our own things.

use super::common::{codes, write};
use super::enhancement::{Bounces, Enhancement};
use super::path::{Direct, Tracing};
use super::render::Job;
use super::scene::Scene;
use super::stage::{self, Setting};
use super::{MAX_BOUNCES, planes, the_urn};
use glam::Vec3;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use relievo::frame::{ColorPlanes, Plane};
use std::error::Error;
use std::path::Path;

/// White lines between the pictures, in pixels.
const GAP: usize = 6;

const JPEG_QUALITY: u8 = 82;

/// A picture of the sheet.
type Picture = ColorPlanes;

/// Renders all of them and writes one JPEG.
pub(crate) fn write_sheet(output: &Path, samples: u32, width: usize) -> Result<(), Box<dyn Error>> {
    // Check the output before an hour of rendering.
    relievo::io::output::check_writable(output, relievo::io::output::Replace::IfWritable)?;
    let warped = (Bounces::First, Bounces::None);
    let scaled = |bounces| (Bounces::None, bounces);
    let plain = scaled(Bounces::None);
    let first = [
        (Setting::Clay, vec![plain, warped]),
        (Setting::Glazed, vec![plain, warped]),
    ];
    // Widths are such that all rows are as wide.
    let whole = 4 * width + 3 * GAP;
    let narrow = [width, width * 5 / 4];
    let third = [(whole - 2 * GAP) / 3, width * 5 / 4];
    let half = [(whole - GAP) / 2, width * 5 / 4];
    let mut row_of_figure_9 = Vec::new();
    for (setting, kinds) in first {
        row_of_figure_9.extend(pictures(setting, &kinds, narrow, samples));
    }
    let all = [Bounces::None, Bounces::First, Bounces::All].map(scaled);
    // Light that mirrors throw on other things is met by chance alone.
    let row_of_figure_10 = pictures(Setting::Mirrors, &all, third, 2 * samples);
    let row_of_figure_11 = pictures(
        Setting::Lamp,
        &[plain, scaled(Bounces::First)],
        half,
        samples,
    );
    let sheet = column(
        &[row_of_figure_9, row_of_figure_10, row_of_figure_11],
        whole,
    );
    let is_jpeg = ["jpg", "jpeg"].map(|known| output.extension().is_some_and(|e| e == known));
    if !is_jpeg.contains(&true) {
        return Ok(write(&output.to_string_lossy(), &sheet)?);
    }
    let (width, height) = (sheet.r.width() as u32, sheet.r.height() as u32);
    let mut file = std::fs::File::create(output)?;
    let encoder = JpegEncoder::new_with_quality(&mut file, JPEG_QUALITY);
    encoder.write_image(&codes(&sheet), width, height, ExtendedColorType::Rgb8)?;
    Ok(())
}

/// One scene rendered with warping and scaling at various bounces.
fn pictures(
    setting: Setting,
    kinds: &[(Bounces, Bounces)],
    size: [usize; 2],
    samples: u32,
) -> Vec<Picture> {
    let scene = stage::scene(setting, the_urn());
    let kinds = kinds.iter();
    kinds
        .map(|&(warp, scale)| picture(&scene, setting, size, samples, warp, scale))
        .collect()
}

fn picture(
    scene: &Scene,
    setting: Setting,
    size: [usize; 2],
    samples: u32,
    warp: Bounces,
    scale: Bounces,
) -> Picture {
    let job = Job {
        scene,
        camera: stage::camera(setting, size),
        tracing: Tracing {
            enhancement: Enhancement {
                warp,
                scale,
                ..Enhancement::default()
            },
            direct: Direct::Both,
            max_bounces: MAX_BOUNCES,
        },
        samples,
        seed: 1,
    };
    let shown: Vec<Vec3> = job.pixels().into_iter().map(shown).collect();
    planes(&shown, size)
}

/// Value from which highlights are compressed.
const SHOULDER: f32 = 0.6;

/// Displayed light: values above the shoulder approach white without reaching it.
fn shown(light: Vec3) -> Vec3 {
    light.map(|v| {
        let above = (v - SHOULDER).max(0.0) / (1.0 - SHOULDER);
        v.min(SHOULDER) + (1.0 - SHOULDER) * (1.0 - (-above).exp())
    })
}

/// Rows of pictures below one another, white between.
fn column(rows: &[Vec<Picture>], width: usize) -> Picture {
    let gaps = GAP * (rows.len() - 1);
    let height = rows.iter().map(|row| row[0].r.height()).sum::<usize>() + gaps;
    let mut sheet = [0; 3].map(|_| Plane::filled(width, height, 1.0));
    let mut top = 0;
    for row in rows {
        let mut left = 0;
        for picture in row {
            for (to, from) in sheet.iter_mut().zip([&picture.r, &picture.g, &picture.b]) {
                for y in 0..from.height() {
                    to.row_mut(top + y)[left..left + from.width()].copy_from_slice(from.row(y));
                }
            }
            left += picture.r.width() + GAP;
        }
        top += row[0].r.height() + GAP;
    }
    let [r, g, b] = sheet;
    ColorPlanes { r, g, b }
}
