//! What is made of a picture tile by tile, from each tile and what lies around it.

use super::{Mask, Plane, Window};
use rayon::prelude::*;

/// Columns and rows of a tile, besides those around it that it is made from: so few that its planes stay in a core's
/// cache, and that many show nothing that calls for work.
pub(super) const TILE: [usize; 2] = [256, 64];

/// A rectangle of the picture of which something is made, and the part that it is made from.
pub(super) struct Part {
    whole: Window,
    made: Window,
    around: Window,
}

impl Part {
    /// The part of a picture of the size of `like` within `reach` pixels of `made`.
    pub(super) fn around(made: Window, reach: usize, like: &Plane) -> Self {
        let whole = Window::from_size(like.width(), like.height());
        let around = made.grown(reach).common(&whole);
        Self {
            whole,
            made,
            around: around.unwrap_or(made),
        }
    }

    /// The part of a plane.
    pub(super) fn plane<T: Copy>(&self, plane: &Plane<T>) -> Plane<T> {
        plane.crop(self.whole, self.around)
    }

    /// The part of a plane, and of the coverage.
    pub(super) fn of(&self, plane: &Plane, mask: &Mask) -> (Plane, Mask) {
        (self.plane(plane), mask.crop(self.whole, self.around))
    }

    /// The rectangle, of a plane made of the part.
    pub(super) fn cut(&self, plane: &Plane) -> Made {
        Made {
            window: self.made,
            plane: plane.crop(self.around, self.made),
        }
    }
}

/// A finished rectangle of the picture.
pub(super) struct Made {
    window: Window,
    pub(super) plane: Plane,
}

impl Made {
    /// Puts the samples where they belong.
    pub(super) fn write_to(&self, whole: &mut Plane) {
        let columns = self.window.x0 as usize..self.window.x1 as usize;
        for (y, row) in (self.window.y0 as usize..).zip(0..self.plane.height()) {
            whole.row_mut(y)[columns.clone()].copy_from_slice(self.plane.row(row));
        }
    }
}

/// What `make` makes of the tiles of a picture of the size of `like`, in parallel; without those of which it makes
/// nothing.
pub(super) fn of_tiles(like: &Plane, make: impl Fn(Window) -> Option<Made> + Sync) -> Vec<Made> {
    let (width, height) = (like.width(), like.height());
    let [across, down] = [width.div_ceil(TILE[0]), height.div_ceil(TILE[1])];
    let tile = |i: usize| {
        let (x, y) = (i % across * TILE[0], i / across * TILE[1]);
        let size = [TILE[0].min(width - x), TILE[1].min(height - y)];
        Window::at(x as i32, y as i32, size[0], size[1])
    };
    (0..across * down)
        .into_par_iter()
        .with_max_len(1)
        .filter_map(|i| make(tile(i)))
        .collect()
}
