//! Paper sizes for print.

use super::strokes::{Enlargement, MAX_TIMES, MM_PER_INCH};
use crate::error::{Error, Result, bad};
use crate::params::table::Kind;
use crate::params::value::{Value, finite};
use crate::params::{Param, Params, StrokeParams, StrokeScale};
use serde::Serialize;

/// The paper that a drawing is fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PaperSize {
    /// Width in millimetres.
    pub width_mm: f32,
    /// Height in millimetres.
    pub height_mm: f32,
}

/// Smallest and largest side of a paper, in millimetres.
const SIDES_MM: [f32; 2] = [1.0, 10_000.0];

/// Units accepted for a size, in millimetres.
const UNITS: [(&str, f32); 3] = [("mm", 1.0), ("cm", 10.0), ("in", MM_PER_INCH)];

impl Value for PaperSize {
    const KIND: Kind = Kind::Text;

    fn parse(text: &str, _: &Param) -> std::result::Result<Self, String> {
        let [least, most] = SIDES_MM;
        let text = match text {
            "A3" => "297x420mm",
            "A4" => "210x297mm",
            _ => text,
        };
        let in_unit = |&(unit, mm): &(&str, f32)| {
            let (width, height) = text.strip_suffix(unit)?.split_once('x')?;
            let [width_mm, height_mm] = [finite(width)? * mm, finite(height)? * mm];
            let is_paper = |side| (least..=most).contains(side);
            [width_mm, height_mm].iter().all(is_paper).then_some(Self {
                width_mm,
                height_mm,
            })
        };
        let expected = format!(
            "expected A3, A4, or width and height as in 210x297mm, 21x29.7cm or 8.5x11in, {least} to {most} mm each"
        );
        UNITS.iter().find_map(in_unit).ok_or(expected)
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(format!("{}x{}mm", self.width_mm, self.height_mm))
    }
}

impl PaperSize {
    /// Enlargement of a picture, 1 to 16, that makes its drawing just fit the paper. The picture has `size_px` columns
    /// and rows of pixels with aspect ratio `pixel_aspect` (width / height); the print has `dpi` pixels per inch
    /// vertically.
    ///
    /// # Errors
    /// [`Error::BadParameter`] where the paper takes fewer pixels than the picture has, or too many, with a suitable
    /// dpi.
    pub fn factor(self, size_px: [usize; 2], pixel_aspect: f32, dpi: f32) -> Result<f64> {
        let [width_px, height_px] = size_px.map(|side| side.max(1) as f64);
        let per_mm = f64::from(dpi) / f64::from(MM_PER_INCH);
        let across = f64::from(self.width_mm) * per_mm / (width_px * f64::from(pixel_aspect));
        let factor = whole(across.min(f64::from(self.height_mm) * per_mm / height_px));
        let refused = |what: &str, limit: &str| {
            let [width, height] = size_px.map(|side| (side as f64 * factor) as usize);
            Error::BadParameter {
                name: "--size",
                found: format!(
                    "is {width}x{height} pixels at {dpi} per inch, {what} the picture's {}x{}",
                    size_px[0], size_px[1]
                ),
                remedy: format!("give {limit}, or another size"),
            }
        };
        let (dpi, most) = (f64::from(dpi), f64::from(MAX_TIMES));
        if factor < 1.0 {
            let fits = whole(dpi / factor).ceil();
            return Err(refused("fewer than", &format!("--dpi {fits} or more")));
        }
        if factor > most {
            let fits = whole(dpi * most / factor).floor();
            let what = format!("more than {MAX_TIMES} times");
            return Err(refused(&what, &format!("--dpi {fits} or less")));
        }
        Ok(factor)
    }
}

choices! {
    /// When the long side of a page lies across.
    pub enum Landscape {
        /// For pictures that are wider than high.
        Auto = "auto",
        /// Always.
        On = "on",
        /// Never.
        Off = "off",
    }
}

impl Params {
    /// Enlargement of a picture with so many columns and rows of pixels before it is drawn.
    ///
    /// # Errors
    /// As [`PaperSize::factor`], where a paper is given.
    pub(crate) fn times(&self, size_px: [usize; 2], pixel_aspect: f32) -> Result<f64> {
        match self.size {
            Some(paper) => paper.factor(size_px, pixel_aspect, self.line.strokes.print_dpi()),
            None => {
                let [width, height] = size_px;
                let times = self.enlarge.unwrap_or(Enlargement::Times(1));
                Ok(times.times(((width * height) as f32).sqrt()) as f64)
            }
        }
    }

    /// The strokes in a picture of this size: those in millimetres have the resolution of its page.
    pub(crate) fn strokes_on_page(&self, size_px: [f64; 2], pixel_aspect: f32) -> StrokeParams {
        let mut strokes = self.line.strokes;
        let page = self.page_for(size_px, pixel_aspect);
        if let (StrokeScale::Millimetres(_), Some((_, dpi))) = (strokes.scale, page) {
            strokes.dpi = Some(dpi);
        }
        strokes
    }

    /// The page of an SVG of a picture of this size, as in [`PaperSize::factor`]: its width and height in millimetres,
    /// and the resolution that makes the drawing fit.
    pub fn page_for(&self, size_px: [f64; 2], pixel_aspect: f32) -> Option<([f32; 2], f32)> {
        let paper = self.page?;
        let [width_px, height_px] = size_px.map(|side| side as f32);
        let width_px = width_px * pixel_aspect;
        let is_across = match self.landscape {
            Landscape::Auto => width_px > height_px,
            Landscape::On => true,
            Landscape::Off => false,
        };
        let mut sides = [paper.width_mm, paper.height_mm];
        sides.sort_by(f32::total_cmp);
        if is_across {
            sides.reverse();
        }
        let [across, down] = sides.map(|side| side - 2.0 * self.margin_mm);
        let per_mm = (width_px / across).max(height_px / down);
        Some((sides, per_mm * MM_PER_INCH))
    }

    /// A page has room for a drawing, and a resolution of its own.
    pub(crate) fn page_relations(&self) -> Result<()> {
        let Some(page) = self.page else {
            return Ok(());
        };
        if self.line.strokes.dpi.is_some() {
            let found = "sets the pixels per inch, and --dpi gives others";
            return Err(bad("--page", found, "leave one out"));
        }
        if 2.0 * self.margin_mm >= page.width_mm.min(page.height_mm) {
            let found = format!("is {} mm, and leaves nothing of the page", self.margin_mm);
            return Err(bad("--margin", found, "give less"));
        }
        Ok(())
    }
}

/// Rounds numbers that are whole up to the rounding of millimetres.
fn whole(number: f64) -> f64 {
    let whole = number.round();
    if (number - whole).abs() < 1e-6 * whole {
        whole
    } else {
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Parameters, Params};

    fn parsed(text: &str) -> std::result::Result<Option<PaperSize>, String> {
        let mut params = Params::default();
        params.set("size", text).map(|_| params.size)
    }

    #[test]
    fn sizes_are_read_in_three_units() {
        let a4 = PaperSize {
            width_mm: 210.0,
            height_mm: 297.0,
        };
        assert_eq!(parsed("210x297mm"), Ok(Some(a4)));
        assert_eq!(parsed("21x29.7cm"), Ok(Some(a4)));
        let letter = parsed("8.5x11in").unwrap().unwrap();
        assert_eq!((letter.width_mm, letter.height_mm), (215.9, 279.4));
        for text in [
            "210x297", "210mm", "0x297mm", "-1x5in", "axbmm", "x", "infx1cm", "1x99m",
        ] {
            assert!(parsed(text).unwrap_err().contains("210x297mm"), "{text}");
        }
    }

    #[test]
    fn a_drawing_just_fits_its_paper() {
        let size = |text| parsed(text).unwrap().unwrap();
        // 4 inches at 300 dpi are 1200 pixels, 3.75 times 320; 4 inches down would be 5 times 240.
        let factor = size("4x4in").factor([320, 240], 1.0, 300.0).unwrap();
        assert!((factor - 3.75).abs() < 1e-6, "{factor}");
        // With a pixel aspect of 2 the paper fits half the factor: 1.875.
        let factor = size("4x4in").factor([320, 240], 2.0, 300.0).unwrap();
        assert!((factor - 1.875).abs() < 1e-6, "{factor}");
        assert_eq!(size("1x1in").factor([300, 200], 1.0, 300.0).unwrap(), 1.0);
        // 100 pixels of 400: four times the dpi would do. 6400 of 320: 16 times is 5120, four fifths of the dpi.
        for (text, dpi, found, remedy) in [
            ("1x1in", 100.0, "is 100x75 pixels", "give --dpi 400 or more"),
            (
                "10x10in",
                1000.0,
                "more than 16 times",
                "give --dpi 640 or less",
            ),
        ] {
            let refused = size(text).factor([400, 300], 1.0, dpi).unwrap_err();
            let line = refused.to_string();
            assert!(line.contains(found) && line.contains(remedy), "{line}");
        }
    }
}
