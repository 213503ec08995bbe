//! Amounts of ink in cells of the paper, which keep the ink drawn near its target on local average.

use crate::frame::Plane;
use glam::Vec2;

/// Amounts of ink, in pixels, in square cells of the paper.
pub(super) struct InkCells {
    amounts: Plane,
    side: f32,
}

impl InkCells {
    /// The ink of a plane, 0..1 per pixel, in cells of `side` pixels, smoothed with their neighbours.
    pub(super) fn of_plane(ink: &Plane, side: f32) -> Self {
        let cell = |pixel: usize| (pixel as f32 / side) as usize;
        let mut amounts = Plane::filled(cell(ink.width()) + 1, cell(ink.height()) + 1, 0.0);
        let columns: Vec<usize> = (0..ink.width()).map(cell).collect();
        for y in 0..ink.height() {
            let row = amounts.row_mut(cell(y));
            for (&ink, &column) in ink.row(y).iter().zip(&columns) {
                if ink > 0.0 {
                    row[column] += ink.min(1.0);
                }
            }
        }
        Self { amounts, side }.evened()
    }

    /// The same cells without ink.
    pub(super) fn blank(&self) -> Self {
        Self {
            amounts: self.amounts.map(|_| 0.0),
            side: self.side,
        }
    }

    /// Adds ink at a place.
    pub(super) fn add(&mut self, at: Vec2, amount: f32) {
        let [x, y] = self.amounts.pixel_at(at / self.side);
        self.amounts.row_mut(y)[x] += amount;
    }

    /// The amounts smoothed with their neighbours.
    pub(super) fn evened(&self) -> Self {
        let (width, height) = (self.amounts.width(), self.amounts.height());
        let evened = |x: usize, y: usize| {
            let mut sum = 0.0;
            for ny in y.saturating_sub(1)..(y + 2).min(height) {
                for nx in x.saturating_sub(1)..(x + 2).min(width) {
                    let weight =
                        [1.0, 2.0][usize::from(nx == x)] * [1.0, 2.0][usize::from(ny == y)];
                    sum += weight * self.amounts.at(nx, ny);
                }
            }
            sum
        };
        Self {
            amounts: Plane::from_fn(width, height, evened),
            side: self.side,
        }
    }

    /// The amount at a place, interpolated between the cells around it.
    pub(super) fn at(&self, at: Vec2) -> f32 {
        let place = (at / self.side - 0.5).max(Vec2::ZERO);
        let [x, y] = self.amounts.pixel_at(place);
        let [right, below] = self.amounts.pixel_at(Vec2::new(x as f32, y as f32) + 1.0);
        let share = (place - Vec2::new(x as f32, y as f32)).clamp(Vec2::ZERO, Vec2::ONE);
        let of = |x: usize, y: usize| self.amounts.at(x, y);
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
