//! How large what a picture shows is: the size of a pixel, and a bar that shows it.

use super::line::MM_PER_INCH;
use super::table::Kind;
use super::value::{Value, finite};
use super::{Param, Params};
use crate::error::{Error, Result};
use serde::Serialize;

/// The width of a pixel of the input on the surface that it shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PixelSize {
    /// In millimetres.
    pub mm: f32,
}

/// The least and the largest, in millimetres: a nanometre and a hundred kilometres.
const SIZES_MM: [f32; 2] = [1e-6, 1e8];

/// Units that it can be given in, and their millimetres: longer names first.
const UNITS: [(&str, f32); 5] = [
    ("mm", 1.0),
    ("cm", 10.0),
    ("um", 1e-3),
    ("µm", 1e-3),
    ("m", 1000.0),
];

impl Value for PixelSize {
    const KIND: Kind = Kind::Text;

    fn parse(text: &str, _: &Param) -> std::result::Result<Self, String> {
        let in_unit = |&(unit, mm): &(&str, f32)| finite(text.strip_suffix(unit)?).map(|n| n * mm);
        let [least, most] = SIZES_MM;
        let mm = UNITS.iter().find_map(in_unit);
        mm.filter(|mm| (least..=most).contains(mm))
            .map(|mm| Self { mm })
            .ok_or_else(|| {
                format!("expected a length as in 0.05mm, 12um, 0.4cm or 2m, {least} to {most} mm")
            })
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(format!("{}mm", self.mm))
    }
}

impl PixelSize {
    /// Pixels per inch of a print that is as large as what it shows.
    pub fn dpi(self) -> f32 {
        MM_PER_INCH / self.mm
    }
}

choices! {
    /// Where a picture has a bar of a round length.
    #[derive(Default)]
    pub enum ScaleBar {
        /// Nowhere.
        Off = "off" [default],
        /// In its quietest corner.
        On = "on",
        /// In a white strip below it.
        Outside = "outside",
    }
}

impl Params {
    /// Refuses a bar of a length that is not known.
    pub(super) fn relations(&self) -> Result<()> {
        match (self.scale_bar, self.pixel_size) {
            (ScaleBar::On | ScaleBar::Outside, None) => Err(Error::BadParameter {
                name: "--scale-bar",
                found: "is wanted, and how large a pixel is is not known".into(),
                remedy: "give --pixel-size, as in --pixel-size 0.05mm".into(),
            }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Parameters;

    #[test]
    fn lengths_are_read_in_their_units() {
        let parsed = |text: &str| {
            let mut params = Params::default();
            params
                .set("pixel-size", text)
                .map(|_| params.pixel_size.unwrap().mm)
        };
        for (text, mm) in [
            ("0.05mm", 0.05),
            ("2cm", 20.0),
            ("0.5m", 500.0),
            ("12um", 0.012),
            ("12µm", 0.012),
        ] {
            let found = parsed(text).unwrap();
            assert!((found / mm - 1.0).abs() < 1e-6, "{text}: {found}");
        }
        for text in ["0.05", "mm", "0mm", "-1mm", "nanmm", "1km", "1e9m"] {
            assert!(parsed(text).unwrap_err().contains("0.05mm"), "{text}");
        }
        // 25.4 mm of 0.05 mm each.
        assert!((PixelSize { mm: 0.05 }.dpi() - 508.0).abs() < 1e-3);
        let mut params = Params::default();
        params.set("scale-bar", "outside").unwrap();
        assert!(
            params
                .check()
                .unwrap_err()
                .to_string()
                .contains("--pixel-size")
        );
        params.set("pixel-size", "1mm").unwrap();
        assert!(params.check().is_ok());
    }
}
