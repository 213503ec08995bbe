//! What is made of a picture tile by tile, from each tile and what lies around it.

use crate::frame::{Mask, Plane, Window};
use rayon::prelude::*;

/// Columns and rows of a tile, besides those around it that it is made from: so few that its planes stay in a core's
/// cache, and that many show nothing that calls for work.
pub(super) const TILE: [usize; 2] = [256, 64];

/// A tile, and the part of the picture that something is made of it from.
pub(super) struct PictureTile {
    whole: Window,
    pub(super) window: Window,
    around: Window,
}

impl PictureTile {
    /// The part of a plane.
    pub(super) fn part<T: Copy>(&self, plane: &Plane<T>) -> Plane<T> {
        plane.crop(self.whole, self.around)
    }

    /// The parts of a plane and of the mask.
    pub(super) fn parts(&self, plane: &Plane, mask: &Mask) -> (Plane, Mask) {
        (self.part(plane), mask.crop(self.whole, self.around))
    }
}

/// The tiles of a picture of the size of `like` of which `make` makes something of the part within `reach`, with what it
/// makes of them, in parallel.
pub(super) fn of_tiles(
    like: &Plane,
    reach: usize,
    make: impl Fn(&PictureTile) -> Option<Plane> + Sync,
) -> Vec<(Window, Plane)> {
    let whole = Window::from_size(like.width(), like.height());
    let across = whole.width().div_ceil(TILE[0]);
    let down = whole.height().div_ceil(TILE[1]);
    let made = |i: usize| {
        let corner = [i % across * TILE[0], i / across * TILE[1]].map(|from| from as i32);
        let window = Window::at(corner[0], corner[1], TILE[0], TILE[1]).common(&whole)?;
        let around = window.grown(reach).common(&whole)?;
        let tile = PictureTile {
            whole,
            window,
            around,
        };
        Some((window, make(&tile)?.crop(around, window)))
    };
    let tiles = (0..across * down).into_par_iter().with_max_len(1);
    tiles.filter_map(made).collect()
}

/// Puts finished tiles where they belong.
pub(super) fn lay_tiles(tiles: &[(Window, Plane)], picture: &mut Plane) {
    let whole = Window::from_size(picture.width(), picture.height());
    for (window, made) in tiles {
        picture.paste(whole, *window, made, *window);
    }
}
