//! The pictures of docs/guide/gallery.md: runs its commands and reduces what they make. Four drawings of them are the
//! contact sheet in the README, fixtures/drawing.png.
//!
//! `cargo run --release -p examples --example gallery`, from the folder that holds `fixtures`.

mod common;

use common::{Outcome, write_jpeg};
use image::imageops::{FilterType, overlay};
use image::{DynamicImage, Rgba, RgbaImage};
use std::fs;
use std::path::Path;
use std::process::ExitCode;

/// Width of a picture on the page, and the most height.
const SIZE: [u32; 2] = [480, 480];

const QUALITY: u8 = 80;

/// The drawings on the contact sheet, and the size of each.
const SHEET: [&str; 4] = ["engraving.png", "gears.png", "pencil.png", "lines.png"];
const CELL: [u32; 2] = [480, 360];

fn main() -> ExitCode {
    common::run(|_| make_all())
}

fn make_all() -> Outcome<()> {
    let page = fs::read_to_string("docs/guide/gallery.md")?;
    let place = tempfile::tempdir()?;
    let [width, height] = CELL;
    let mut sheet = RgbaImage::from_pixel(2 * width, 2 * height, Rgba([255; 4]));
    let commands = page.lines().filter(|line| line.starts_with("relievo "));
    for command in commands {
        let mut words: Vec<String> = command.split_whitespace().map(String::from).collect();
        let output = words.iter().position(|word| word == "-o");
        let output = output.and_then(|at| words.get_mut(at + 1));
        let output = output.ok_or_else(|| format!("no output: {command}"))?;
        let made = place.path().join(&output);
        let cell = SHEET.iter().position(|name| name == output);
        *output = made.to_string_lossy().into();
        if relievo::cli::run_words(words.into_iter().map(Into::into)) != 0 {
            return Err(format!("failed: {command}").into());
        }
        let page = on_white(&made)?;
        write_small(&page, &made)?;
        if let Some(cell) = cell {
            let small = page.resize(width, height, FilterType::Triangle).to_rgba8();
            let [column, row] = [cell as u32 % 2, cell as u32 / 2];
            let x = column * width + (width - small.width()) / 2;
            let y = row * height + (height - small.height()) / 2;
            overlay(&mut sheet, &small, x.into(), y.into());
        }
    }
    DynamicImage::from(sheet)
        .to_luma8()
        .save("fixtures/drawing.png")?;
    Ok(())
}

/// A picture on white: JPEG has no alpha.
fn on_white(made: &Path) -> Outcome<DynamicImage> {
    let picture = image::open(made)?;
    let is_color = picture.color().has_color();
    let mut page = RgbaImage::from_pixel(picture.width(), picture.height(), Rgba([255; 4]));
    overlay(&mut page, &picture.to_rgba8(), 0, 0);
    let page = DynamicImage::from(page);
    Ok(match is_color {
        true => page.to_rgb8().into(),
        false => page.to_luma8().into(),
    })
}

/// Writes the small copy of a picture for the page.
fn write_small(page: &DynamicImage, made: &Path) -> Outcome<()> {
    let small = page.resize(SIZE[0], SIZE[1], FilterType::Triangle);
    let name = made.with_extension("jpg");
    let name = name.file_name().ok_or("an output without a name")?;
    write_jpeg(&Path::new("docs/gallery").join(name), &small, QUALITY)
}
