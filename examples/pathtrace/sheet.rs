//! The pictures of the guide: figures 9 of [LW], 10 and 11 of [RS], of our own things.

use super::enhancement::{Bounces, Enhancement};
use super::path::Tracing;
use super::render::Job;
use super::stage::{self, Setting};
use crate::common::{is_jpeg, rgb, write_jpeg};
use glam::Vec3;
use image::{Rgb, RgbImage, imageops};
use std::error::Error;
use std::path::Path;

/// White lines between the pictures, in pixels.
const GAP: usize = 6;

const JPEG_QUALITY: u8 = 82;

/// Renders all of them and writes one JPEG.
pub(crate) fn write_sheet(output: &Path, samples: u32, width: usize) -> Result<(), Box<dyn Error>> {
    // Check the output before an hour of rendering.
    relievo::io::output::check_writable(output, relievo::io::output::Replace::IfWritable)?;
    let [none, first, all] = [Bounces::None, Bounces::First, Bounces::All];
    let (plain, warped, scaled) = ((none, none), (first, none), (none, first));
    // Widths are such that all rows are as wide. Light that mirrors throw on other things is met by chance alone.
    let whole = 4 * width + 3 * GAP;
    let (third, half) = ((whole - 2 * GAP) / 3, (whole - GAP) / 2);
    type Cells<'a> = (usize, u32, &'a [(Setting, &'a [(Bounces, Bounces)])]);
    let rows: [Cells; 3] = [
        (
            width,
            samples,
            &[
                (Setting::Clay, &[plain, warped]),
                (Setting::Glazed, &[plain, warped]),
            ],
        ),
        (
            third,
            2 * samples,
            &[(Setting::Mirrors, &[plain, scaled, (none, all)])],
        ),
        (half, samples, &[(Setting::Lamp, &[plain, scaled])]),
    ];
    let height = width * 5 / 4;
    let size = [whole, 3 * height + 2 * GAP].map(|side| side as u32);
    let mut sheet = RgbImage::from_pixel(size[0], size[1], Rgb([255; 3]));
    for (row, (width, samples, scenes)) in rows.into_iter().enumerate() {
        let mut left = 0;
        for &(setting, kinds) in scenes {
            let scene = stage::scene(setting);
            for &(warp, scale) in kinds {
                let job = Job {
                    scene: &scene,
                    camera: stage::camera(setting, [width, height]),
                    tracing: Tracing {
                        enhancement: Enhancement {
                            warp,
                            scale,
                            ..Enhancement::default()
                        },
                        ..Tracing::default()
                    },
                    samples,
                    seed: 1,
                };
                let top = row * (height + GAP);
                let picture = rgb(&job.picture(shown));
                imageops::replace(&mut sheet, &picture, left as i64, top as i64);
                left += width + GAP;
            }
        }
    }
    match is_jpeg(output) {
        true => write_jpeg(output, &sheet.into(), JPEG_QUALITY),
        false => Ok(sheet.save(output)?),
    }
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
