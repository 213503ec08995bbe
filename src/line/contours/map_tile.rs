//! The map in which silhouettes are searched, computed only where there may be any: the logarithm of depth, or an
//! occlusion map.

use crate::engine::cpu::simd::Simd;
use crate::fast_math::ln;
use crate::frame::{Frame, Plane};
use crate::params::{ShapeParams, SoftThreshold};

/// Columns computed together.
pub(crate) const BLOCK: usize = 64;

/// Rows above and below a row of corners that its cracks read.
const REACH: usize = 3;

/// The quantity that jumps at silhouettes, and the size of a jump.
pub(crate) struct Map<'a> {
    plane: &'a Plane,
    pub(crate) is_depth: bool,
    pub(crate) threshold: SoftThreshold,
}

impl<'a> Map<'a> {
    /// The map of a frame, if it has any.
    pub(crate) fn of(frame: &'a Frame, shape: &ShapeParams) -> Option<Self> {
        let depth = frame.depth.as_ref().map(|plane| Self {
            plane,
            is_depth: true,
            threshold: shape.silhouette,
        });
        let occlusion = || {
            frame.occlusion.as_ref().map(|plane| Self {
                plane,
                is_depth: false,
                threshold: shape.occlusion_silhouette,
            })
        };
        depth.or_else(occlusion)
    }

    /// The map at a pixel that is covered.
    pub(crate) fn at(&self, x: usize, y: usize) -> f32 {
        let value = self.plane.at(x, y);
        if self.is_depth { ln(value) } else { value }
    }
}

/// The map around a band of rows, with only the requested blocks computed.
pub(crate) struct MapTile {
    width: usize,
    /// The first row held; it may be above the picture.
    top: i64,
    rows: usize,
    values: Vec<f32>,
    is_made: Vec<bool>,
    simd: Simd,
}

impl MapTile {
    /// A tile for bands of `rows` rows of corners.
    pub(crate) fn new(width: usize, rows: usize) -> Self {
        let rows = rows + 2 * REACH;
        Self {
            width,
            top: 0,
            rows,
            values: vec![0.0; width * rows],
            is_made: vec![false; width.div_ceil(BLOCK) * rows],
            simd: Simd::widest(),
        }
    }

    /// Discards its content, to hold the map around the rows of corners from `y` on.
    pub(crate) fn move_to(&mut self, y: usize) {
        self.top = y as i64 - REACH as i64;
        self.is_made.fill(false);
    }

    /// Makes the map around the corners of row `y` in block `block`.
    pub(crate) fn make(&mut self, map: &Map, frame: &Frame, y: usize, block: usize) {
        let blocks = self.width.div_ceil(BLOCK);
        for y in y.saturating_sub(REACH)..(y + REACH).min(frame.mask.height()) {
            for block in block.saturating_sub(1)..(block + 2).min(blocks) {
                let row = (y as i64 - self.top) as usize;
                if std::mem::replace(&mut self.is_made[row * blocks + block], true) {
                    continue;
                }
                let columns = block * BLOCK..((block + 1) * BLOCK).min(self.width);
                let out = &mut self.values[row * self.width..][columns.clone()];
                let (values, covered) = (map.plane.row(y), frame.mask.row(y));
                if map.is_depth {
                    self.simd.log_depth_row(
                        out,
                        &values[columns.clone()],
                        &covered[columns.clone()],
                    );
                } else {
                    out.copy_from_slice(&values[columns.clone()]);
                }
                for (out, &covered) in out.iter_mut().zip(&covered[columns]) {
                    *out = if covered { *out } else { f32::NAN };
                }
            }
        }
    }

    /// The map at a pixel, if it is covered and there is a map.
    #[inline]
    pub(crate) fn value(&self, [x, y]: [i64; 2]) -> Option<f32> {
        let (x, row) = (
            usize::try_from(x).ok()?,
            usize::try_from(y - self.top).ok()?,
        );
        let inside = x < self.width && row < self.rows;
        // Rows beyond the picture are never computed: their content belongs to another band.
        let blocks = self.width.div_ceil(BLOCK);
        let is_made = inside && self.is_made[row * blocks + x / BLOCK];
        let value = is_made.then(|| self.values[row * self.width + x])?;
        value.is_finite().then_some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes};
    use glam::DVec3;

    #[test]
    fn nothing_is_told_of_rows_beyond_the_picture_whatever_was_held_before() {
        let (width, height) = (70, 20);
        let normal = Vector3Planes::from_fn(width, height, |_, _| DVec3::Z);
        let mut frame = Frame::of_normals(normal, Mask::full(width, height));
        frame.depth = Some(Plane::filled(width, height, 5.0));
        let map = Map::of(&frame, &ShapeParams::default()).unwrap();
        let mut tile = MapTile::new(width, 16);
        for (band, inside, beyond) in [(0, 0, -1), (16, 19, 20), (0, 0, -2)] {
            tile.move_to(band);
            for y in band..(band + 16).min(height + 1) {
                (0..2).for_each(|block| tile.make(&map, &frame, y, block));
            }
            assert_eq!(tile.value([69, inside]), Some(ln(5.0)));
            assert_eq!(tile.value([69, beyond]), None);
            assert_eq!(tile.value([70, inside]), None);
        }
    }
}
