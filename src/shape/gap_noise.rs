//! Noise of depth, by which thresholds of gaps rise: in defocus and motion blur each pixel has the depth of another sample.

use crate::frame::{Frame, Plane};
use crate::quantile::quantile;
use crate::shape::gap::Gap;
use rayon::prelude::*;

/// Columns and rows of a tile whose noise is one number, in half pixels: the unit of all positions here, from the middle of
/// the display window. Tiles are told from there, so that a mirrored frame has the same ones.
pub(crate) const TILE: i32 = 32;

/// Fewest gaps that tell noise.
const FEWEST: usize = 8;

/// Less noise than this, in pixels, is none: curvature alone.
const LEAST: f32 = 0.1;

/// Number of rows within which a depth can affect a threshold: those of the tile, and of half the next.
pub(crate) const NOISE_REACH: usize = TILE as usize;

/// Noise of depth in pixels: one number for each tile, interpolated between their middles.
#[derive(Debug, Clone)]
pub(crate) struct GapNoise {
    tiles: Plane,
    /// The middle of the first pixel, from the corner of the first tile.
    first: [i32; 2],
}

impl GapNoise {
    /// The noise of a frame whose gaps from a pixel to the next along an axis these are; `None` if there is none.
    pub(crate) fn of(
        frame: &Frame,
        gap: impl Fn([usize; 2], usize) -> Option<Gap> + Sync,
    ) -> Option<Self> {
        let (data, display) = (frame.data_window, frame.display_window);
        let size = [data.width(), data.height()];
        let first = [
            [data.x0, display.x0, display.x1],
            [data.y0, display.y0, display.y1],
        ]
        .map(|[start, from, to]| {
            (2 * i64::from(start) + 1 - i64::from(from) - i64::from(to)).rem_euclid(TILE.into())
                as i32
        });
        let [columns, rows] =
            [0, 1].map(|axis| (first[axis] as usize + 2 * size[axis]).div_ceil(TILE as usize));
        let mut tiles = Plane::filled(columns, rows, 0.0);
        let found = tiles.samples_mut().par_iter_mut().enumerate();
        found.for_each_init(Vec::new, |gaps, (i, noise)| {
            gaps.clear();
            let corner = [i % columns, i / columns].map(|tile| tile as i32 * TILE);
            // The pixel whose middle is there.
            let pixel = |place: [i32; 2]| {
                let at = [0, 1].map(|axis| {
                    usize::try_from((corner[axis] + place[axis] - first[axis]) / 2).ok()
                });
                let inside = |axis: usize| {
                    at[axis]
                        .filter(|&at| at < size[axis] && corner[axis] + place[axis] >= first[axis])
                };
                Some([inside(0)?, inside(1)?])
            };
            for axis in 0..2 {
                for (line, start) in probes(first[1 - axis] % 2, first[axis] % 2) {
                    let place = if axis == 0 {
                        [start, line]
                    } else {
                        [line, start]
                    };
                    let found = pixel(place).and_then(|at| gap(at, axis));
                    gaps.extend(
                        found
                            .map(|gap| gap.px.min(gap.bend))
                            .filter(|px| px.is_finite()),
                    );
                }
            }
            if gaps.len() >= FEWEST {
                let middle = quantile(gaps, 0.5, f32::total_cmp);
                *noise = middle.filter(|&px| px >= LEAST).unwrap_or(0.0);
            }
        });
        let is_any = tiles.samples().iter().any(|&noise| noise > 0.0);
        is_any.then_some(Self { tiles, first })
    }

    /// The noise of the gaps from the pixels of a row, `first` and those to its right, to the next ones along an axis.
    pub(crate) fn fill_row(&self, [first, y]: [usize; 2], axis: usize, row: &mut [f32]) {
        let after = [0, 1].map(|of| i32::from(of == axis));
        let ([above, below], down) = self.between(1, y, after[1]);
        let tiles = [above, below].map(|y| self.tiles.row(y));
        for (i, noise) in row.iter_mut().enumerate() {
            let (columns, across) = self.between(0, first + i, after[0]);
            let at = |r: usize, c: usize| tiles[r][columns[c]] * (down[r] * across[c]);
            // In this order a transposed or mirrored frame has the same noise to the bit.
            *noise = (at(0, 0) + at(1, 1)) + (at(0, 1) + at(1, 0));
        }
    }

    /// The two tiles around a position along an axis, so far after the middle of a pixel, and their shares.
    fn between(&self, axis: usize, at: usize, after: i32) -> ([usize; 2], [f32; 2]) {
        let count = [self.tiles.width(), self.tiles.height()][axis];
        // From the middle of the first tile.
        let place = 2 * at as i32 + self.first[axis] + after - TILE / 2;
        let first = place.div_euclid(TILE);
        let past = place.rem_euclid(TILE) as f32 / TILE as f32;
        let tile = |i: i32| i.clamp(0, count as i32 - 1) as usize;
        ([tile(first), tile(first + 1)], [1.0 - past, past])
    }

    /// Its numbers, and the middle of the first pixel among them: for the device.
    #[cfg(feature = "gpu")]
    pub(crate) fn tiles(&self) -> (&Plane, [i32; 2]) {
        (&self.tiles, self.first)
    }
}

/// The gaps of a tile that are looked at: the line they are on, and where they start along it. Mirrored they are the same,
/// for pixels whose middles are at odd places, or at even ones.
fn probes(parity_of_line: i32, parity: i32) -> impl Iterator<Item = (i32, i32)> {
    let line = 6 + parity_of_line;
    let starts = (0..4).flat_map(move |i| {
        // From the middle of the gap to either end of the tile.
        let middle = 3 - parity + 4 * i;
        [middle - 1, TILE - middle - 1]
    });
    let lines = [line, TILE - line];
    lines
        .into_iter()
        .flat_map(move |line| starts.clone().map(move |start| (line, start)))
}
