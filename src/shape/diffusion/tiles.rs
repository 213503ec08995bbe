//! Tiles: rectangles of the frame small enough for many sweeps within a core's cache.

use crate::frame::{Mask, Plane};
use crate::params::TileSize;
use std::num::NonZeroUsize;
use std::ops::Range;

/// A rectangle trimmed to the surface it contains.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TrimmedTile {
    pub(crate) columns: Range<usize>,
    pub(crate) rows: Range<usize>,
}

/// The tiles of a frame that contain surface, and the matching division of planes.
#[derive(Debug)]
pub(crate) struct Tiling {
    tiles: Vec<TrimmedTile>,
    /// Rows of a band of tiles; the last band may have fewer.
    band_height: usize,
    /// The tiles of every band, left to right.
    bands: Vec<Range<usize>>,
}

impl Tiling {
    /// The tiles of at most `size` that cover `mask`; tiles without surface are left out.
    pub(crate) fn new(mask: &Mask, size: TileSize) -> Self {
        let (across, down) = (size.width.get(), size.height.get());
        let mut tiles = Vec::new();
        let mut bands = Vec::new();
        for top in (0..mask.height()).step_by(down) {
            let first = tiles.len();
            let cells = (0..mask.width()).step_by(across).map(|left| TrimmedTile {
                columns: left..(left + across).min(mask.width()),
                rows: top..(top + down).min(mask.height()),
            });
            tiles.extend(cells.filter_map(|cell| trimmed(cell, mask)));
            bands.push(first..tiles.len());
        }
        Self {
            tiles,
            band_height: down,
            bands,
        }
    }

    pub(crate) fn tiles(&self) -> &[TrimmedTile] {
        &self.tiles
    }

    /// The rows of every tile in `plane`, tile by tile, for writing from different threads.
    pub(crate) fn cut<'a>(&self, plane: &'a mut Plane) -> Vec<Vec<&'a mut [f32]>> {
        let room = |tile: &TrimmedTile| Vec::with_capacity(tile.rows.len());
        let mut cut: Vec<Vec<&mut [f32]>> = self.tiles.iter().map(room).collect();
        let width = plane.width();
        for (y, mut rest) in plane.samples_mut().chunks_mut(width).enumerate() {
            let mut passed = 0;
            for i in self.bands[y / self.band_height].clone() {
                let TrimmedTile { columns, rows } = &self.tiles[i];
                if rows.contains(&y) {
                    let (_, from) = rest.split_at_mut(columns.start - passed);
                    let (part, after) = from.split_at_mut(columns.len());
                    cut[i].push(part);
                    (rest, passed) = (after, columns.end);
                }
            }
        }
        cut
    }
}

/// Minimum number of rows when tiles are shrunk for more threads.
const FEWEST_ROWS: usize = 64;
/// Tiles for each of several threads, where that leaves this many rows for each sweep: a thread that waits for memory
/// leaves tiles to others, while the rim takes less than a sixteenth of the time.
const TILES_OF_THREAD: usize = 4;
const AMPLE_ROWS_PER_SWEEP: usize = 16;

/// Tiles within `size` that give each of `threads` the same number, for a frame of `width` by `height` pixels: the
/// largest, or where this many sweeps waste little work on their rims, smaller ones and several for each.
pub(crate) fn even_tiles(
    size: TileSize,
    [width, height]: [usize; 2],
    threads: usize,
    sweeps: usize,
) -> TileSize {
    let across = width.div_ceil(size.width.get()).max(1);
    let several = match threads {
        1 => 1,
        _ => (TILES_OF_THREAD * threads).div_ceil(across),
    };
    let most = height / (AMPLE_ROWS_PER_SWEEP * sweeps).max(FEWEST_ROWS);
    let least = height.div_ceil(size.height.get()).max(1);
    let mut down = least.max(several.min(most));
    while !(across * down).is_multiple_of(threads) && height / (down + 1) >= FEWEST_ROWS {
        down += 1;
    }
    let share = |pixels: usize, of: usize| {
        NonZeroUsize::new(pixels.div_ceil(of)).unwrap_or(NonZeroUsize::MIN)
    };
    TileSize {
        width: share(width, across),
        height: share(height, down),
    }
}

/// The smallest rectangle with all surface of `cell`; `None` if it has none.
fn trimmed(cell: TrimmedTile, mask: &Mask) -> Option<TrimmedTile> {
    let (mut columns, mut rows) = (cell.columns.end..cell.columns.start, None);
    for y in cell.rows {
        let row = &mask.row(y)[cell.columns.clone()];
        let Some(first) = row.iter().position(|&c| c) else {
            continue;
        };
        let last = row.iter().rposition(|&c| c).unwrap_or(first);
        columns.start = columns.start.min(cell.columns.start + first);
        columns.end = columns.end.max(cell.columns.start + last + 1);
        let start = rows.as_ref().map_or(y, |rows: &Range<usize>| rows.start);
        rows = Some(start..y + 1);
    }
    rows.map(|rows| TrimmedTile { columns, rows })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(width: usize, height: usize) -> TileSize {
        let size = |n| NonZeroUsize::new(n).expect("above 0");
        TileSize {
            width: size(width),
            height: size(height),
        }
    }

    #[test]
    fn tiles_hold_every_covered_pixel_once_and_skip_the_rest() {
        let covered = |x: usize, y: usize| (x * 7 + y * 3).is_multiple_of(11) && x < 9;
        let mask = Mask::new(Plane::from_fn(23, 9, covered));
        let tiling = Tiling::new(&mask, size(5, 4));
        let mut seen = Plane::filled(23, 9, 0.0);
        for rows in tiling.cut(&mut seen) {
            for row in rows {
                row.iter_mut().for_each(|v| *v += 1.0);
            }
        }
        for y in 0..9 {
            for x in 0..23 {
                assert!(seen.at(x, y) <= 1.0);
                assert!(!covered(x, y) || seen.at(x, y) == 1.0, "({x}, {y})");
            }
        }
        assert!(tiling.tiles().iter().all(|tile| tile.columns.end <= 9));
    }

    #[test]
    fn every_thread_gets_as_many_tiles() {
        let even = |threads, sweeps| even_tiles(size(2048, 640), [1920, 1080], threads, sweeps);
        assert_eq!(even(2, 64), size(1920, 540));
        assert_eq!(even(3, 64), size(1920, 360));
        // 1080 rows are not cut below 64: 16 bands, not 60.
        assert_eq!(even(60, 64), size(1920, 68));
        // With 16 rows for each of 8 sweeps or fewer, four bands for each of two threads.
        assert_eq!(even(2, 8), size(1920, 135));
        // One thread leaves none to others.
        assert_eq!(even(1, 8), size(1920, 540));
        // Four bands of 256 rows would have 16 for each of 16 sweeps.
        assert_eq!(even(2, 16), size(1920, 270));
        assert_eq!(even_tiles(size(2048, 640), [0, 0], 4, 8), size(1, 1));
    }

    #[test]
    fn an_empty_mask_has_no_tiles() {
        let mask = Mask::new(Plane::filled(40, 40, false));
        assert!(Tiling::new(&mask, size(8, 8)).tiles().is_empty());
    }
}
