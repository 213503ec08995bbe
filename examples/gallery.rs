//! The pictures of docs/guide/gallery.md: runs its commands and reduces what they make.
//!
//! `cargo run --release -p examples --example gallery`, from the folder that holds `fixtures`.

mod common;

use image::codecs::jpeg::JpegEncoder;
use image::imageops::{FilterType, overlay};
use image::{DynamicImage, Rgba, RgbaImage};
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

/// Width of a picture on the page, and the most height.
const SIZE: [u32; 2] = [480, 480];

const QUALITY: u8 = 80;

fn main() -> ExitCode {
    common::exit(run())
}

fn run() -> Result<(), Box<dyn Error>> {
    let page = fs::read_to_string("docs/guide/gallery.md")?;
    let place = tempfile::tempdir()?;
    let commands = page.lines().filter(|line| line.starts_with("relievo "));
    for command in commands {
        let mut words: Vec<String> = command.split_whitespace().map(String::from).collect();
        let output = words.iter().position(|word| word == "-o");
        let output = output.and_then(|at| words.get_mut(at + 1));
        let output = output.ok_or_else(|| format!("no output: {command}"))?;
        let made = place.path().join(&output);
        *output = made.to_string_lossy().into();
        if relievo::cli::run_words(words.into_iter().map(Into::into)) != 0 {
            return Err(format!("failed: {command}").into());
        }
        reduce(&made)?;
    }
    Ok(())
}

/// Writes the small copy of a picture for the page.
fn reduce(made: &Path) -> Result<(), Box<dyn Error>> {
    let picture = image::open(made)?;
    let is_color = picture.color().has_color();
    // JPEG has no alpha: the page is white.
    let mut page = RgbaImage::from_pixel(picture.width(), picture.height(), Rgba([255; 4]));
    overlay(&mut page, &picture.to_rgba8(), 0, 0);
    let small = DynamicImage::from(page).resize(SIZE[0], SIZE[1], FilterType::Triangle);
    let name = made.with_extension("jpg");
    let name = name.file_name().ok_or("an output without a name")?;
    let file = fs::File::create(Path::new("docs/gallery").join(name))?;
    let encoder = JpegEncoder::new_with_quality(file, QUALITY);
    match is_color {
        true => small.to_rgb8().write_with_encoder(encoder)?,
        false => small.to_luma8().write_with_encoder(encoder)?,
    }
    Ok(())
}
