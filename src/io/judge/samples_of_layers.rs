//! A bounded sample of the pixels of layers: bands of rows, spread over the picture.

use crate::frame::{Plane, Window};
use crate::io::exr::ExrFile;
use crate::io::roles::Match;
use nalgebra::Vector3;
use std::ops::Range;

/// Pixels of a layer that are read, about.
const PIXELS: usize = 60_000;
/// Most bands of rows that they lie in: of most files a block of 16 or 32 rows is decoded for each.
const BANDS: usize = 8;

/// The pixels of a layer that were read.
pub(crate) struct Sampled {
    pub(crate) found: Match,
    pub(crate) window: Window,
    pub(crate) bands: Vec<Band>,
}

/// Some rows of a layer.
pub(crate) struct Band {
    /// Row of the layer that is the first here.
    pub(crate) top: usize,
    /// A plane for each channel, or for as many as are wanted.
    planes: Vec<Plane>,
}

impl Band {
    pub(crate) fn width(&self) -> usize {
        self.planes[0].width()
    }

    pub(crate) fn height(&self) -> usize {
        self.planes[0].height()
    }

    /// The vector at a pixel; a single channel gives equal components.
    pub(crate) fn at(&self, x: usize, y: usize) -> Vector3<f64> {
        let last = self.planes.len() - 1;
        Vector3::from_fn(|axis, _| f64::from(self.planes[axis.min(last)].at(x, y)))
    }

    /// Its pixels, row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = [usize; 2]> {
        let (width, height) = (self.width(), self.height());
        (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
    }
}

impl Sampled {
    /// All finite vectors.
    pub(crate) fn vectors(&self) -> impl Iterator<Item = Vector3<f64>> {
        let bands = self.bands.iter();
        let all = bands.flat_map(|band| band.pixels().map(move |[x, y]| band.at(x, y)));
        all.filter(|v| v.iter().all(|c| c.is_finite()))
    }
}

/// Samples of the readable `layers` of `file`; those with the same window are adjacent.
pub(crate) fn samples(file: &ExrFile, layers: &[Match]) -> Vec<Sampled> {
    let window = |found: &Match| file.parts[found.part].window;
    let mut windows: Vec<Window> = Vec::new();
    for window in layers.iter().map(window) {
        if !windows.contains(&window) {
            windows.push(window);
        }
    }
    let of_window = |shared: Window| {
        let together: Vec<_> = layers.iter().filter(|l| window(l) == shared).collect();
        let bands = read(file, &together, shared).unwrap_or_default();
        let sampled = together.into_iter().zip(bands);
        sampled.map(move |(found, bands)| Sampled {
            found: found.clone(),
            window: shared,
            bands,
        })
    };
    windows.into_iter().flat_map(of_window).collect()
}

/// The bands of each of `layers`, which share a window; none where one cannot be read.
fn read(file: &ExrFile, layers: &[&Match], window: Window) -> Option<Vec<Vec<Band>>> {
    let ids: Vec<_> = layers.iter().flat_map(|found| found.ids()).collect();
    let mut bands: Vec<Vec<Band>> = layers.iter().map(|_| Vec::new()).collect();
    if ids.is_empty() {
        return Some(bands);
    }
    for rows in rows(window) {
        let top = rows.start;
        let mut planes = file.read_rows(&ids, rows).ok()?.into_iter();
        for (found, bands) in layers.iter().zip(&mut bands) {
            let planes: Vec<_> = planes.by_ref().take(found.channels.len()).collect();
            bands.push(Band { top, planes });
        }
    }
    Some(bands)
}

/// The rows that are read of a window: all of a small one, else bands of two rows or more.
fn rows(window: Window) -> Vec<Range<usize>> {
    let (width, height) = (window.width().max(1), window.height());
    if width * height <= PIXELS {
        return std::iter::once(0..height)
            .filter(|rows| !rows.is_empty())
            .collect();
    }
    let rows = (PIXELS / BANDS / width).clamp(2, height.max(2)).min(height);
    let count = (PIXELS / (width * rows)).clamp(1, BANDS);
    let room = height - rows;
    let top = |i: usize| match count {
        1 => room / 2,
        _ => i * room / (count - 1),
    };
    (0..count).map(|i| top(i)..top(i) + rows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_bounded_and_spread() {
        let rows = |w, h| -> Vec<[usize; 2]> {
            let rows = rows(Window::from_size(w, h)).into_iter();
            rows.map(|rows| [rows.start, rows.end]).collect()
        };
        assert_eq!(rows(1, 1), [[0, 1]]);
        assert_eq!(rows(300, 200), [[0, 200]]);
        // 60,000 pixels in 8 bands are 7 rows of 1,000 each.
        let wide = rows(1000, 1000);
        assert_eq!((wide.len(), wide[0], wide[7]), (8, [0, 7], [993, 1000]));
        // Two rows at the least, where there are two.
        assert_eq!(rows(1_000_000, 9), [[3, 5]]);
        assert_eq!(rows(100_000, 1), [[0, 1]]);
    }
}
