//! Sheets of sprites: pictures whose cells are pictures of their own.

use crate::error::{Result, bad};
use crate::frame::Window;
use std::fmt;
use std::str::FromStr;

/// More cells than any sheet has: a smaller cell is a typing error.
const MOST_CELLS: usize = 1 << 16;

/// Columns and rows of the cells of a sheet, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct CellSize(pub(crate) [usize; 2]);

impl FromStr for CellSize {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let sides = text.split_once('x').map(|(width, height)| {
            [width, height].map(|side| side.parse().ok().filter(|side| *side > 0))
        });
        match sides {
            Some([Some(width), Some(height)]) => Ok(Self([width, height])),
            _ => Err("expected columns and rows of a cell, as in 32x32".into()),
        }
    }
}

impl fmt::Display for CellSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

impl CellSize {
    /// The cells of the sheet, from left to right and from top to bottom.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for a sheet that does not consist of whole cells, with what would fit.
    pub(crate) fn cells(self, sheet: Window) -> Result<Vec<Window>> {
        let Self([width, height]) = self;
        let sides = [sheet.width(), sheet.height()];
        let count = [sides[0] / width, sides[1] / height];
        let whole = Self([count[0] * width, count[1] * height]);
        if whole.0 != sides {
            let fits = Self([
                nearest_divisor(sides[0], width),
                nearest_divisor(sides[1], height),
            ]);
            let crop = match count {
                [0, _] | [_, 0] => String::new(),
                _ => format!(", or crop the sheet to {whole}"),
            };
            return Err(bad(
                "--grid",
                format!("{self} does not fit a sheet of {}", Self(sides)),
                format!("give {fits}{crop}"),
            ));
        }
        let all = count[0].saturating_mul(count[1]);
        if all > MOST_CELLS {
            let remedy = format!("give larger ones: up to {MOST_CELLS} are made");
            let found = format!("{self} makes {all} cells");
            return Err(bad("--grid", found, remedy));
        }
        let cell = |i: usize| {
            let [x, y] = [i % count[0] * width, i / count[0] * height];
            Window::at(sheet.x0 + x as i32, sheet.y0 + y as i32, width, height)
        };
        Ok((0..all).map(cell).collect())
    }
}

/// The divisor of `side` that is nearest to `wanted`.
fn nearest_divisor(side: usize, wanted: usize) -> usize {
    let divisors = (1..=side).filter(|divisor| side.is_multiple_of(*divisor));
    divisors
        .min_by_key(|divisor| divisor.abs_diff(wanted))
        .unwrap_or(side)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_is_cut_into_whole_cells() {
        let grid: CellSize = "32x16".parse().unwrap();
        let cells = grid.cells(Window::from_size(64, 48)).unwrap();
        assert_eq!(cells.len(), 6);
        assert_eq!(cells[3], Window::at(32, 16, 32, 16));
        for wrong in ["", "32", "0x32", "32x", "-1x4", "x", "32x32x3", "1.5x2"] {
            assert!(wrong.parse::<CellSize>().is_err(), "{wrong}");
        }
        let refused = |grid: [usize; 2], size: [usize; 2]| {
            let sheet = Window::from_size(size[0], size[1]);
            CellSize(grid).cells(sheet).unwrap_err().to_string()
        };
        // Of 250 the divisors next to 32 are 25 and 50; 7 x 32 = 224.
        assert_eq!(
            refused([32, 32], [250, 128]),
            "--grid 32x32 does not fit a sheet of 250x128; give 25x32, or crop the sheet to 224x128"
        );
        assert_eq!(
            refused([32, 32], [16, 32]),
            "--grid 32x32 does not fit a sheet of 16x32; give 16x32"
        );
        assert!(refused([1, 1], [4096, 4096]).contains("makes 16777216 cells"));
    }
}
