//! Noise of depth, by which thresholds of gaps rise: in defocus and motion blur each pixel has the depth of another sample.

use crate::frame::{Frame, Plane};
use crate::quantile::quantile;
use rayon::prelude::*;

/// Columns and rows of a tile whose noise is one number, in half pixels: the unit of all positions here, from the middle of
/// the display window. Tiles are told from there, so that a mirrored frame has the same ones.
pub(crate) const TILE: i32 = 32;

/// Fewest gaps that tell noise.
const FEWEST: usize = 8;

/// Less noise than this, in pixels, is none: curvature alone.
pub(crate) const CALM: f32 = 0.1;

/// Gaps of a tile that are looked at.
const PROBES: usize = 32;

/// No gap farther than this many pixels affects a threshold: the middle of a tile that counts is less than a tile away, and
/// half a tile lies beyond it.
pub(crate) const NOISE_REACH: usize = 3 * TILE as usize / 4;

/// Noise of depth in pixels: one number for each tile, interpolated between their middles.
#[derive(Debug, Clone)]
pub(crate) struct GapNoise {
    tiles: Plane,
    /// The middle of the first pixel, from the corner of the first tile.
    first: [i32; 2],
}

impl GapNoise {
    /// The noise of a frame; `stray` is what a gap from a pixel to the next along an axis counts, in pixels. `None` if there
    /// is none.
    pub(crate) fn of(
        frame: &Frame,
        stray: impl Fn([usize; 2], usize) -> Option<f32> + Sync,
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
        found.for_each_init(Vec::new, |strays, (i, noise)| {
            strays.clear();
            let corner = [i % columns, i / columns].map(|tile| tile as i32 * TILE);
            // The pixel whose middle is there.
            let pixel = |place: [i32; 2]| {
                let at = [0, 1].map(|axis| {
                    let from_first = corner[axis] + place[axis] - first[axis];
                    let at = usize::try_from(from_first).ok().map(|halves| halves / 2);
                    at.filter(|&at| at < size[axis])
                });
                Some([at[0]?, at[1]?])
            };
            let parities = first.map(|first| first % 2);
            for (axis, place) in [0, 1].into_iter().flat_map(|axis| probes(axis, parities)) {
                let found = pixel(place).and_then(|at| stray(at, axis));
                strays.extend(found.filter(|px| px.is_finite()));
                // The median of all will not reach it.
                let calm = strays.iter().filter(|&&px| px < CALM).count();
                if calm > PROBES / 2 {
                    return;
                }
            }
            if strays.len() >= FEWEST {
                let middle = quantile(strays, 0.5, f32::total_cmp);
                *noise = middle.filter(|&px| px >= CALM).unwrap_or(0.0);
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
        let mut done = 0;
        while done < row.len() {
            // Up to the next middle of a tile, the same four are around.
            let (columns, across) = self.between(0, first + done, after[0]);
            let left = (across[0] * (TILE / 2) as f32).ceil() as usize;
            let end = row.len().min(done + left.max(1));
            let of = |r: usize, c: usize| tiles[r][columns[c]];
            let corners = [of(0, 0), of(1, 1), of(0, 1), of(1, 0)];
            for (i, noise) in row[done..end].iter_mut().enumerate() {
                let right = across[1] + i as f32 * (2.0 / TILE as f32);
                let across = [1.0 - right, right];
                let [a, b, c, d] = corners;
                // In this order a transposed or mirrored frame has the same noise to the bit.
                let ends = a * (down[0] * across[0]) + b * (down[1] * across[1]);
                *noise = ends + (c * (down[0] * across[1]) + d * (down[1] * across[0]));
            }
            done = end;
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

/// The gaps along an axis that are looked at in a tile: the axis, and the middles of their first pixels. Mirrored or
/// transposed they are the same, for pixels whose middles are at odd places, or at even ones.
fn probes(axis: usize, parities: [i32; 2]) -> impl Iterator<Item = (usize, [i32; 2])> {
    let line = 6 + parities[1 - axis];
    let starts = (0..PROBES as i32 / 8).flat_map(move |i| {
        // From the middle of the gap to either end of the tile.
        let middle = 3 - parities[axis] + 4 * i;
        [middle - 1, TILE - middle - 1]
    });
    let places = [line, TILE - line].into_iter().flat_map(move |line| {
        starts.clone().map(move |start| match axis {
            0 => [start, line],
            _ => [line, start],
        })
    });
    places.map(move |place| (axis, place))
}
