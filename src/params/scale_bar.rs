//! Physical scale: the size of a pixel, and a scale bar.

use super::line::MM_PER_INCH;
use super::table::Kind;
use super::value::{Value, finite};
use super::{Param, Params};
use crate::error::{Error, Result};
use serde::Serialize;

/// Width of an input pixel on the surface shown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PixelSize {
    /// Width in millimetres.
    pub mm: f32,
    /// Millimetres of the unit that it is given in, as heights without another are.
    pub unit_mm: f32,
}

/// Smallest and largest size in millimetres: a nanometre and a hundred kilometres.
const SIZES_MM: [f32; 2] = [1e-6, 1e8];

/// Units accepted, in millimetres; longer names first.
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
        let in_unit = |&(unit, unit_mm): &(&str, f32)| {
            let mm = finite(text.strip_suffix(unit)?)? * unit_mm;
            Some(Self { mm, unit_mm })
        };
        let [least, most] = SIZES_MM;
        let size = UNITS.iter().find_map(in_unit);
        size.filter(|size| (least..=most).contains(&size.mm))
            .ok_or_else(|| {
                format!("expected a length as in 0.05mm, 12um, 0.4cm or 2m, {least} to {most} mm")
            })
    }

    fn text(&self, _: &Param) -> Option<String> {
        let (unit, _) = UNITS.iter().find(|(_, mm)| *mm == self.unit_mm)?;
        Some(format!("{}{unit}", self.mm / self.unit_mm))
    }
}

impl PixelSize {
    /// Resolution of a life-size print, in pixels per inch.
    pub fn dpi(self) -> f32 {
        MM_PER_INCH / self.mm
    }
}

choices! {
    /// Placement of a scale bar of a round length.
    #[derive(Default)]
    pub enum ScaleBar {
        /// No bar.
        Off = "off" [default],
        /// In the quietest corner of the picture.
        On = "on",
        /// In a white strip below the picture.
        Outside = "outside",
    }
}

impl Params {
    /// A scale bar requires a pixel size; and the relations of a page.
    pub(super) fn relations(&self) -> Result<()> {
        self.page_relations()?;
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
        // 25.4 mm / 0.05 mm = 508 pixels per inch.
        assert!(
            (PixelSize {
                mm: 0.05,
                unit_mm: 1.0,
            }
            .dpi()
                - 508.0)
                .abs()
                < 1e-3
        );
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
