//! Bounds of the distance of a surface in the cells of a grid, which spare a search most of its looks at the surface.

use super::search::Bounded;
use super::texels::TangentPlane;

/// The least and the largest distance of the surface in each cell.
#[derive(Debug, Clone)]
pub(super) struct Bounds(Vec<[f32; 2]>);

/// No surface: all is in front of it.
const NOWHERE: [f32; 2] = [f32::INFINITY, 0.0];

/// Share by which bounds are wider than they would be without rounding.
const ROUNDING: f64 = 1e-6;

impl Bounds {
    /// As many cells without a surface.
    pub(super) fn new(count: usize) -> Self {
        Self(vec![NOWHERE; count])
    }

    /// As many cells that leave everything open.
    #[cfg(test)]
    pub(super) fn open(count: usize) -> Self {
        Self(vec![[0.0, f32::INFINITY]; count])
    }

    /// Number of cells.
    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    /// Widens the bounds of a cell to hold others.
    #[inline]
    pub(super) fn widen(&mut self, cell: usize, others: [f32; 2]) {
        widen(&mut self.0[cell], others);
    }

    /// Compares a position in a cell with the surface there; its distance is `above / below`.
    #[inline]
    pub(super) fn compared(&self, cell: usize, above: f64, below: f64) -> Bounded {
        let [least, most] = self.0[cell].map(f64::from);
        if above < below * least {
            Bounded::InFront
        } else if above > below * most {
            Bounded::Behind
        } else {
            Bounded::Open
        }
    }
}

/// The bounds of some planes.
pub(super) fn of_planes<'a>(planes: impl IntoIterator<Item = &'a TangentPlane>) -> [f32; 2] {
    let mut bounds = NOWHERE;
    for [least, most] in planes.into_iter().filter_map(TangentPlane::range) {
        let wider = [least * (1.0 - ROUNDING), most * (1.0 + ROUNDING)];
        widen(&mut bounds, wider.map(|d| d as f32));
    }
    bounds
}

#[inline]
fn widen(bounds: &mut [f32; 2], [least, most]: [f32; 2]) {
    *bounds = [bounds[0].min(least), bounds[1].max(most)];
}

/// Vectors at random, with components from -1 to 1 (a linear congruential generator).
#[cfg(test)]
pub(super) fn vectors() -> impl FnMut() -> glam::DVec3 {
    let mut state = 1_u32;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    move || glam::DVec3::from([(); 3].map(|()| 2.0 * random() - 1.0))
}
