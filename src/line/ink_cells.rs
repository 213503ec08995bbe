//! Amounts of ink in cells of the paper, which keep the ink drawn near its target on local average.

use crate::frame::Plane;
use glam::Vec2;

/// Amounts of ink, in pixels, in square cells of the paper.
pub(super) struct InkCells {
    amounts: Vec<f32>,
    size: [usize; 2],
    side: f32,
}

impl InkCells {
    /// The ink of a plane, 0..1 per pixel, in cells of `side` pixels, smoothed with their neighbours.
    pub(super) fn of_plane(ink: &Plane, side: f32) -> Self {
        let size = [ink.width(), ink.height()].map(|length| (length as f32 / side) as usize + 1);
        let mut cells = Self {
            amounts: vec![0.0; size[0] * size[1]],
            size,
            side,
        };
        let columns = (0..ink.width()).map(|x| (x as f32 / side) as usize);
        let columns: Vec<usize> = columns.collect();
        for y in 0..ink.height() {
            let row = (y as f32 / side) as usize * size[0];
            for (&ink, &column) in ink.row(y).iter().zip(&columns) {
                if ink > 0.0 {
                    cells.amounts[row + column] += ink.min(1.0);
                }
            }
        }
        cells.evened()
    }

    /// The same cells without ink.
    pub(super) fn blank(&self) -> Self {
        Self {
            amounts: vec![0.0; self.amounts.len()],
            ..*self
        }
    }

    /// Adds ink at a place.
    pub(super) fn add(&mut self, at: Vec2, amount: f32) {
        let place = at / self.side;
        let [x, y] = [(place.x, self.size[0]), (place.y, self.size[1])]
            .map(|(at, count)| (at.max(0.0) as usize).min(count - 1));
        self.amounts[y * self.size[0] + x] += amount;
    }

    /// The amounts smoothed with their neighbours.
    pub(super) fn evened(&self) -> Self {
        let [width, height] = self.size;
        let mut evened = self.blank();
        for y in 0..height {
            for x in 0..width {
                let mut sum = 0.0;
                for ny in y.saturating_sub(1)..(y + 2).min(height) {
                    for nx in x.saturating_sub(1)..(x + 2).min(width) {
                        let weight =
                            [1.0, 2.0][usize::from(nx == x)] * [1.0, 2.0][usize::from(ny == y)];
                        sum += weight * self.amounts[ny * width + nx];
                    }
                }
                evened.amounts[y * width + x] = sum;
            }
        }
        evened
    }

    /// The amount at a place, interpolated between the cells around it.
    pub(super) fn at(&self, at: Vec2) -> f32 {
        let place = (at / self.side - 0.5).max(Vec2::ZERO);
        let last = [self.size[0] - 1, self.size[1] - 1];
        let (x, y) = (
            (place.x as usize).min(last[0]),
            (place.y as usize).min(last[1]),
        );
        let share = (place - Vec2::new(x as f32, y as f32)).clamp(Vec2::ZERO, Vec2::ONE);
        let (right, below) = ((x + 1).min(last[0]), (y + 1).min(last[1]));
        let of = |x: usize, y: usize| self.amounts[y * self.size[0] + x];
        let above = of(x, y) + share.x * (of(right, y) - of(x, y));
        let under = of(x, below) + share.x * (of(right, below) - of(x, below));
        above + share.y * (under - above)
    }

    /// Factor for the ink drawn at a place to reach the amount in `wanted`, within `limits`; 1 where none is drawn.
    pub(super) fn mend(&self, wanted: &Self, at: Vec2, limits: [f32; 2]) -> f32 {
        match self.at(at) {
            drawn if drawn > 0.0 => (wanted.at(at) / drawn).clamp(limits[0], limits[1]),
            _ => 1.0,
        }
    }
}
