//! Windows: rectangles of pixels in absolute coordinates.

use glam::DVec2;
use serde::Serialize;

/// A half-open rectangle of pixels, `x0 <= x < x1` and `y0 <= y < y1`, rows running down.
///
/// Coordinates are absolute: a crop keeps those of the picture it was cut from, and they may be
/// negative (overscan). Only `io` knows the inclusive corners that EXR files store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Window {
    /// Leftmost column inside.
    pub x0: i32,
    /// Topmost row inside.
    pub y0: i32,
    /// First column to the right of the window.
    pub x1: i32,
    /// First row below the window.
    pub y1: i32,
}

impl Window {
    /// The window of `width` x `height` pixels whose top-left pixel is (0, 0).
    pub fn from_size(width: usize, height: usize) -> Self {
        Self::at(0, 0, width, height)
    }

    /// The window of `width` x `height` pixels whose top-left pixel is (`x0`, `y0`).
    pub fn at(x0: i32, y0: i32, width: usize, height: usize) -> Self {
        Self {
            x0,
            y0,
            x1: x0 + width as i32,
            y1: y0 + height as i32,
        }
    }

    /// Number of columns; 0 if the corners are crossed.
    pub fn width(&self) -> usize {
        (i64::from(self.x1) - i64::from(self.x0)).max(0) as usize
    }

    /// Number of rows; 0 if the corners are crossed.
    pub fn height(&self) -> usize {
        (i64::from(self.y1) - i64::from(self.y0)).max(0) as usize
    }

    /// The size of a picture of this window in pixels: the root of its area.
    pub(crate) fn size_px(&self) -> f32 {
        ((self.width() * self.height()) as f32).sqrt()
    }

    /// The picture position of the centre of the pixel in column `x` and row `y` of the window.
    #[inline]
    pub fn middle(&self, x: usize, y: usize) -> DVec2 {
        let corner = DVec2::new(self.x0.into(), self.y0.into());
        corner + DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
    }

    /// The point halfway between its edges.
    pub(crate) fn center(&self) -> DVec2 {
        let [x0, y0, x1, y1] = [self.x0, self.y0, self.x1, self.y1].map(f64::from);
        DVec2::new(0.5 * (x0 + x1), 0.5 * (y0 + y1))
    }

    /// The same pixels, counted from the corner of `whole`.
    pub(crate) fn relative_to(&self, whole: Window) -> Window {
        Window {
            x0: self.x0 - whole.x0,
            y0: self.y0 - whole.y0,
            x1: self.x1 - whole.x0,
            y1: self.y1 - whole.y0,
        }
    }

    /// The window with `by` more pixels on every side, as far as there are coordinates.
    pub(crate) fn grown(&self, by: usize) -> Window {
        let by = i32::try_from(by).unwrap_or(i32::MAX);
        Window {
            x0: self.x0.saturating_sub(by),
            y0: self.y0.saturating_sub(by),
            x1: self.x1.saturating_add(by),
            y1: self.y1.saturating_add(by),
        }
    }

    /// The smallest window that encloses both.
    pub(crate) fn joined(&self, other: &Window) -> Window {
        Window {
            x0: self.x0.min(other.x0),
            y0: self.y0.min(other.y0),
            x1: self.x1.max(other.x1),
            y1: self.y1.max(other.y1),
        }
    }

    /// The intersection, if there is one.
    pub fn common(&self, other: &Window) -> Option<Window> {
        let both = Window {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        };
        (both.x0 < both.x1 && both.y0 < both.y1).then_some(both)
    }

    /// Whether every pixel of `other` lies inside.
    pub fn encloses(&self, other: &Window) -> bool {
        self.x0 <= other.x0 && self.y0 <= other.y0 && other.x1 <= self.x1 && other.y1 <= self.y1
    }
}

impl std::fmt::Display for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [width, height] = [self.width(), self.height()];
        write!(f, "{width}x{height} at ({}, {})", self.x0, self.y0)
    }
}
