//! What is cut into a flat surface of grain, as letters are into stone: the stone is to be quieter than they are.

use super::cpu::{CellMeans, Cells};
use crate::frame::percentile::percentile;
use crate::frame::{Plane, Vector2Planes};
use crate::line::grid::Grid;
use crate::line::smooth_step::smooth_step;
use glam::Vec3;

/// A surface is flat that bends by less than this, in radians, between means of normals over squares of this share of the
/// picture's size: 3 degrees. Rocks and tablets bend by twice as much.
const FLAT: f32 = 0.052;
const FLAT_SHARE: f32 = 1.0 / 15.0;

/// It has grain if half of all normals turn, smoothed by the second share, by less than this share of what half of them do
/// smoothed by the first: of stone half, and of rendered forms three quarters and more.
const GRAIN: f32 = 0.65;
const GRAIN_SHARES: [f32; 2] = [1.0 / 900.0, 1.0 / 450.0];

/// Between these turns, in usual ones, something is cut into grain: grain itself hardly turns by twice what is usual. One
/// cell of a hundred turns by more than so many at the least: of an inscription by 11, and of bricks and rocks by 5. How wide
/// what is cut is taken to be, as a share of the picture's size, and between which shares of such turns about it.
const CUT: [f32; 2] = [2.0, 3.5];
const MOST_CUT: f32 = 8.0;
const CUT_SHARE: f32 = 1.0 / 170.0;
const CUT_AROUND: [f32; 2] = [0.1, 0.35];

impl Cells<'_> {
    /// How much cells are cut into a flat surface of grain, 0..1, as letters are; none if the surface is none such. Turns of
    /// grain fall where normals are smoothed, and those of forms stay.
    pub(super) fn cut_into_grain(&self, seen: &CellMeans, turn: &Plane) -> Option<Plane> {
        let mask = &self.grid.mask;
        let is_flat = self.bend(seen) < FLAT;
        let of = |turn: &Plane, percent| percentile(mask, percent, |x, y| Some(turn.at(x, y)));
        let (usual, most) = of(turn, 50).zip(of(turn, 99)).filter(|_| is_flat)?;
        if usual <= 0.0 || most < MOST_CUT * usual {
            return None;
        }
        let [own, smooth] = GRAIN_SHARES.map(|share| of(&self.turn(seen, share), 50));
        own.zip(smooth)
            .filter(|(own, smooth)| *smooth < GRAIN * own)?;
        let clear = turn.map(|turn| smooth_step(CUT, turn / usual));
        let (zero, sigma) = (self.memory.plane(mask), self.size * CUT_SHARE);
        let clear = self
            .spread(Vector2Planes { x: clear, y: zero }, &seen.before, sigma)
            .x;
        Some(clear.map(|clear| smooth_step(CUT_AROUND, clear)))
    }

    /// By how much the surface as a whole bends: how far means of normals are from their own in the root mean square.
    fn bend(&self, seen: &CellMeans) -> f32 {
        let blocks = Grid::new(&self.grid.mask, (FLAT_SHARE * self.size).max(1.0) as usize);
        let [x, y, z] = &seen.normal;
        let means = blocks.means(&self.grid.mask, self.memory, |row| {
            let [x, y, z] = [x, y, z].map(|plane| plane.row(row));
            move |i| [x[i], y[i], z[i]]
        });
        let normal = |x, y| Vec3::from(means.each_ref().map(|mean| mean.at(x, y)));
        let rows = 0..blocks.mask.height();
        let cells = rows.flat_map(|y| blocks.mask.runs(y).flatten().map(move |x| (x, y)));
        let sum: Vec3 = cells.map(|(x, y)| normal(x, y).normalize_or_zero()).sum();
        // Of unit vectors the mean is shorter by half of their mean square distance from it.
        let length = sum.length() / blocks.mask.count() as f32;
        (2.0 * (1.0 - length)).max(0.0).sqrt()
    }
}
