//! What is made of a picture tile by tile, from each tile and what lies around it.

use super::{Mask, Plane, Window};
use rayon::prelude::*;

/// Columns and rows of a tile, besides those around it that it is made from: so few that its planes stay in a core's
/// cache, and that many show nothing that calls for work.
pub(super) const TILE: [usize; 2] = [256, 64];

/// A tile of the picture, and the part that it is made from.
pub(super) struct Part {
    whole: Window,
    tile: Window,
    around: Window,
}

impl Part {
    /// The part of a plane.
    pub(super) fn plane<T: Copy>(&self, plane: &Plane<T>) -> Plane<T> {
        plane.crop(self.whole, self.around)
    }

    /// The part of a plane, and of the coverage.
    pub(super) fn of(&self, plane: &Plane, mask: &Mask) -> (Plane, Mask) {
        (self.plane(plane), mask.crop(self.whole, self.around))
    }
}

/// A finished tile.
pub(super) struct Made {
    tile: Window,
    pub(super) plane: Plane,
}

impl Made {
    /// Puts the samples where they belong.
    pub(super) fn write_to(&self, whole: &mut Plane) {
        let columns = self.tile.x0 as usize..self.tile.x1 as usize;
        for (y, row) in (self.tile.y0 as usize..).zip(0..self.plane.height()) {
            whole.row_mut(y)[columns.clone()].copy_from_slice(self.plane.row(row));
        }
    }
}

/// What `make` makes of the tiles of a picture of the size of `like`, in parallel, each from the part within `reach`
/// pixels; without those of which it makes nothing.
pub(super) fn of_tiles(
    like: &Plane,
    reach: usize,
    make: impl Fn(&Part) -> Option<Plane> + Sync,
) -> Vec<Made> {
    let (width, height) = (like.width(), like.height());
    let whole = Window::from_size(width, height);
    let [across, down] = [width.div_ceil(TILE[0]), height.div_ceil(TILE[1])];
    (0..across * down)
        .into_par_iter()
        .with_max_len(1)
        .filter_map(|i| {
            let within = |reach: usize| {
                let span = |place: usize, side: usize, length: usize| {
                    let (start, end) = (place * side, (place + 1) * side);
                    start.saturating_sub(reach)..(end + reach).min(length)
                };
                let columns = span(i % across, TILE[0], width);
                let rows = span(i / across, TILE[1], height);
                let (x, y) = (columns.start as i32, rows.start as i32);
                Window::at(x, y, columns.len(), rows.len())
            };
            let part = Part {
                whole,
                tile: within(0),
                around: within(reach),
            };
            let plane = make(&part)?.crop(part.around, part.tile);
            let tile = part.tile;
            Some(Made { tile, plane })
        })
        .collect()
}
