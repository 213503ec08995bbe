//! Noise of depth, by which thresholds of gaps rise: in defocus and motion blur each pixel has the depth of another sample.

use crate::frame::Frame;
#[cfg(feature = "gpu")]
use crate::frame::Plane;
use crate::kernel::quantile::quantile;
#[cfg(feature = "gpu")]
use rayon::prelude::*;
use std::sync::OnceLock;

/// Columns and rows of a tile whose noise is one number, in half pixels: the unit of all positions here, from the middle of
/// the display window. Tiles are told from there, so that a mirrored frame has the same ones.
pub(crate) const TILE: i32 = 32;

/// Fewest gaps that tell noise.
const FEWEST: usize = 8;

/// Less noise than this, in pixels, is none: curvature alone.
pub(crate) const CALM: f32 = 0.1;

/// Gaps of a tile that are looked at, at most.
const PROBES: usize = 32;

/// No gap farther than this many pixels affects a threshold: the middle of a tile that counts is less than a tile away, and
/// half a tile lies beyond it.
pub(crate) const NOISE_REACH: usize = 3 * TILE as usize / 4;

/// Noise of depth in pixels: one number for each tile, interpolated between their middles. A tile is looked at when its
/// number is asked for first: few have a gap.
#[derive(Debug)]
pub(crate) struct GapNoise {
    tiles: Vec<OnceLock<f32>>,
    /// Columns and rows of tiles.
    counts: [usize; 2],
    /// Columns and rows of the frame.
    size: [usize; 2],
    /// The middle of the first pixel, from the corner of the first tile.
    first: [i32; 2],
}

impl GapNoise {
    /// The noise of a frame, not looked at yet.
    pub(crate) fn of(frame: &Frame) -> Self {
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
        let counts =
            [0, 1].map(|axis| (first[axis] as usize + 2 * size[axis]).div_ceil(TILE as usize));
        Self {
            tiles: vec![OnceLock::new(); counts[0] * counts[1]],
            counts,
            size,
            first,
        }
    }

    /// The noise of a tile; `stray` is what a gap from a pixel to the next along an axis counts, in pixels.
    fn tile(
        &self,
        [column, row]: [usize; 2],
        stray: &impl Fn([usize; 2], usize) -> Option<f32>,
    ) -> f32 {
        let tile = &self.tiles[row * self.counts[0] + column];
        *tile.get_or_init(|| {
            let corner = [column, row].map(|tile| tile as i32 * TILE);
            // The pixel whose middle is there.
            let pixel = |place: [i32; 2]| {
                let at = [0, 1].map(|axis| {
                    let from_first = corner[axis] + place[axis] - self.first[axis];
                    let at = usize::try_from(from_first).ok().map(|halves| halves / 2);
                    at.filter(|&at| at < self.size[axis])
                });
                Some([at[0]?, at[1]?])
            };
            let parities = self.first.map(|first| first % 2);
            let places = [0, 1].into_iter().flat_map(|axis| probes(axis, parities));
            let (mut strays, mut calm) = (Vec::with_capacity(PROBES), 0);
            for (axis, place) in places {
                let found = pixel(place).and_then(|at| stray(at, axis));
                let Some(px) = found.filter(|px| px.is_finite()) else {
                    continue;
                };
                strays.push(px);
                calm += usize::from(px < CALM);
                // The median of all will not reach it.
                if calm > PROBES / 2 {
                    return 0.0;
                }
            }
            if strays.len() < FEWEST {
                return 0.0;
            }
            let middle = quantile(&mut strays, 0.5, f32::total_cmp);
            middle.filter(|&px| px >= CALM).unwrap_or(0.0)
        })
    }

    /// The noise of the gap from a pixel to the next along an axis.
    pub(crate) fn after(
        &self,
        at: [usize; 2],
        axis: usize,
        stray: &impl Fn([usize; 2], usize) -> Option<f32>,
    ) -> f32 {
        let [(columns, across), (rows, down)] =
            [0, 1].map(|of| self.between(of, at[of], i32::from(of == axis)));
        let of =
            |r: usize, c: usize| self.tile([columns[c], rows[r]], stray) * (down[r] * across[c]);
        // In this order a transposed or mirrored frame has the same noise to the bit.
        (of(0, 0) + of(1, 1)) + (of(0, 1) + of(1, 0))
    }

    /// The two tiles around a position along an axis, so far after the middle of a pixel, and their shares.
    fn between(&self, axis: usize, at: usize, after: i32) -> ([usize; 2], [f32; 2]) {
        let count = self.counts[axis];
        // From the middle of the first tile.
        let place = 2 * at as i32 + self.first[axis] + after - TILE / 2;
        let first = place.div_euclid(TILE);
        let past = place.rem_euclid(TILE) as f32 / TILE as f32;
        let tile = |i: i32| i.clamp(0, count as i32 - 1) as usize;
        ([tile(first), tile(first + 1)], [1.0 - past, past])
    }

    /// The numbers of all tiles, and the middle of the first pixel among them: for the device.
    #[cfg(feature = "gpu")]
    pub(crate) fn tiles(
        &self,
        stray: &(impl Fn([usize; 2], usize) -> Option<f32> + Sync),
    ) -> (Plane, [i32; 2]) {
        let [columns, rows] = self.counts;
        let tiles = 0..self.tiles.len();
        let numbers = tiles
            .into_par_iter()
            .map(|i| self.tile([i % columns, i / columns], stray));
        (
            Plane::from_samples(columns, rows, numbers.collect()),
            self.first,
        )
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
