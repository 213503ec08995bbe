//! Planes fit to cells, from the border of the picture.

use super::regions::{opened, outer_pieces};
use crate::frame::Plane;
use crate::line::random::Random;
use glam::{DMat3, DVec3, Vec2};

/// What is linear over planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Linear {
    /// In perspective.
    InverseDepth,
    /// Under parallel lines of sight.
    Depth,
}

/// How far cells may be off a plane, as a share of their value.
const TOLERANCE: f32 = 0.012;

/// The most planes, and the share of cells that each holds at the least.
const MOST: usize = 3;
const LEAST: f32 = 0.04;

/// DepthCells that are looked at, along the picture's size.
const LOOKED_AT: f32 = 160.0;

/// How often three cells are tried for a plane, and how far from the first the others are, in those looked at.
const TRIALS: usize = 250;
const REACHES: [usize; 3] = [12, 30, 60];

/// Rounds of least squares over the cells of a plane.
const ROUNDS: usize = 3;

/// Pieces of a plane inside the picture are larger than this share of it.
const LEAST_PIECE: f32 = 0.0015;

/// A value that is linear over the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlaneFit {
    /// Its change per cell to the right and down.
    pub(super) slope: Vec2,
    /// Its value in the first cell.
    first: f32,
}

impl PlaneFit {
    pub(super) fn at(&self, x: usize, y: usize) -> f32 {
        self.first + self.slope.dot(Vec2::new(x as f32, y as f32))
    }

    /// The direction along which it stays the same, x right, y up, if it changes over a picture of this size in cells.
    pub(super) fn level(&self, size: f32) -> Option<Vec2> {
        let middle = self.at((0.5 * size) as usize, (0.5 * size) as usize);
        let changes = self.slope.length() * size > super::FACING * middle.abs();
        changes.then(|| Vec2::new(self.slope.y, self.slope.x).normalize())
    }

    /// Whether the value of a cell is on it, but for `slack` shares of [`TOLERANCE`] and the distance in cells over which
    /// values are the same.
    pub(super) fn holds(&self, [x, y]: [usize; 2], value: f32, (slack, same): (f32, f32)) -> bool {
        (value - self.at(x, y)).abs() < slack * TOLERANCE * value.abs() + same * self.slope.length()
    }

    /// The plane through three cells, if they are not in line.
    fn through(cells: [([usize; 2], f32); 3]) -> Option<Self> {
        let rows = cells.map(|([x, y], _)| DVec3::new(x as f64, y as f64, 1.0));
        let matrix = DMat3::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose();
        let values = DVec3::from_array(cells.map(|(_, value)| f64::from(value)));
        (matrix.determinant().abs() > 8.0).then(|| Self::of(matrix.inverse() * values))
    }

    /// The plane that is nearest to cells, relative to their values.
    fn nearest<'a>(cells: impl Iterator<Item = &'a ([usize; 2], f32)>) -> Option<Self> {
        let (mut matrix, mut sums) = (DMat3::ZERO, DVec3::ZERO);
        for &([x, y], value) in cells {
            let row = DVec3::new(x as f64, y as f64, 1.0) / f64::from(value);
            matrix += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
            sums += row;
        }
        let found = matrix.inverse() * sums;
        found.is_finite().then(|| Self::of(found))
    }

    fn of(found: DVec3) -> Self {
        let [x, y, first] = found.as_vec3().to_array();
        Self {
            slope: Vec2::new(x, y),
            first,
        }
    }
}

/// The planes of values over cells that begin at the border of the picture, the largest first, and the cells in each;
/// NaN is none. Values are the same over so many cells where depth was enlarged by steps.
pub(super) fn planes(values: &Plane, same: f32) -> Vec<(PlaneFit, Plane<bool>)> {
    let (width, height) = (values.width(), values.height());
    let size = ((width * height) as f32).sqrt();
    let step = ((size / LOOKED_AT) as usize).max(1);
    let places = (0..height).step_by(step);
    let places = places.flat_map(|y| (0..width).step_by(step).map(move |x| [x, y]));
    let known = places.map(|[x, y]| ([x, y], values.at(x, y)));
    let mut left: Vec<([usize; 2], f32)> = known.filter(|(_, value)| value.is_finite()).collect();
    let least = LEAST * left.len() as f32;
    let mut random = Random::new(1);
    let mut found = Vec::new();
    while found.len() < MOST {
        let Some(best) = best(&left, (step, same), [width, height], &mut random) else {
            break;
        };
        let mut fit = best;
        for _ in 0..ROUNDS {
            let own = left
                .iter()
                .filter(|(at, value)| fit.holds(*at, *value, (1.0, same)));
            fit = PlaneFit::nearest(own).unwrap_or(fit);
        }
        let before = left.len();
        left.retain(|(at, value)| !fit.holds(*at, *value, (1.5, same)));
        if ((before - left.len()) as f32) < least {
            break;
        }
        let within = Plane::from_fn(width, height, |x, y| {
            fit.holds([x, y], values.at(x, y), (1.0, same))
        });
        let within = outer_pieces(&opened(&within, 1.0), LEAST_PIECE * size * size);
        found.push((fit, within));
    }
    found
}

/// The plane through a cell on the border and two others that holds most of the cells.
fn best(
    cells: &[([usize; 2], f32)],
    (step, same): (usize, f32),
    [width, height]: [usize; 2],
    random: &mut Random,
) -> Option<PlaneFit> {
    let near = 3 * step;
    let is_border =
        |[x, y]: [usize; 2]| x < near || y < near || x + near >= width || y + near >= height;
    let border: Vec<_> = cells.iter().filter(|(at, _)| is_border(*at)).collect();
    if border.is_empty() {
        return None;
    }
    let mut one_of = |count: usize| ((random.unit() * count as f32) as usize).min(count - 1);
    let mut best = None;
    for _ in 0..TRIALS {
        let first = *border[one_of(border.len())];
        let reach = step * REACHES[one_of(REACHES.len())];
        let mut beside = || {
            let other = cells[one_of(cells.len())];
            let away = |axis: usize| first.0[axis].abs_diff(other.0[axis]) < reach;
            (away(0) && away(1)).then_some(other)
        };
        let mut found = || (0..TRIALS).find_map(|_| beside());
        let (Some(second), Some(third)) = (found(), found()) else {
            continue;
        };
        let Some(fit) = PlaneFit::through([first, second, third]) else {
            continue;
        };
        let held = cells
            .iter()
            .filter(|(at, value)| fit.holds(*at, *value, (1.0, same)))
            .count();
        if best.is_none_or(|(most, _)| held > most) {
            best = Some((held, fit));
        }
    }
    best.map(|(_, fit)| fit)
}
