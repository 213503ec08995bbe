//! Anisotropic diffusion of the gradient: the scale of the descriptor.
//!
//! Theory: dg/ds = div(c grad g) ([LW] section 4.3), Neumann at the border of the picture and of
//! coverage. Changes: face conductances are harmonic means, so the operator is conservative and a
//! closed silhouette leaks exactly nothing. Practice: one sweep of the operator serves both solvers,
//! the paper's explicit steps, stable up to a time step of 1/4, and [`super::chebyshev`].

use crate::shape::Rows;
use std::ops::Range;

/// Face conductances around one row of pixels.
#[derive(Debug, Clone, Copy)]
pub struct Faces<'a> {
    /// `left[x]` joins column `x - 1` and `x`; one longer than the row, both ends 0.
    pub left: &'a [f32],
    /// `above[x]` joins this row and the row above; 0 in the first row.
    pub above: &'a [f32],
    /// `below[x]` joins this row and the row below; 0 in the last row.
    pub below: &'a [f32],
}

/// Pixels read to each side by one step.
pub const REACH: usize = 1;

/// One sweep of the diffusion operator over the columns of `span`: `out = combine(out, g, Lg)` with
/// `Lg = sum c_ij (g_j - g_i)` over the 4 neighbours.
///
/// An explicit step combines to `g + dt Lg`; a Chebyshev recurrence to `-Lg/2 - 2g - out`.
#[inline(always)]
pub fn sweep_row(
    out: &mut [f32],
    g: &Rows,
    faces: &Faces,
    span: Range<usize>,
    combine: impl Fn(f32, f32, f32) -> f32,
) {
    if span.is_empty() {
        return;
    }
    let last = g.at.len() - 1;
    let edge = |x: usize| {
        let sides = [
            g.at[x.saturating_sub(1)],
            g.at[(x + 1).min(last)],
            g.above[x],
            g.below[x],
        ];
        let joined = [
            faces.left[x],
            faces.left[x + 1],
            faces.above[x],
            faces.below[x],
        ];
        flux(g.at[x], sides, joined)
    };
    if span.start == 0 {
        out[0] = combine(out[0], g.at[0], edge(0));
    }
    if span.end == last + 1 && last > 0 {
        out[last] = combine(out[last], g.at[last], edge(last));
    }
    let (first, end) = (span.start.max(1), span.end.min(last));
    if first >= end {
        return;
    }
    // Slices of one length: the loop below is vectorised.
    let n = end - first;
    let (out, at) = (&mut out[first..end], &g.at[first..end]);
    let (west, east) = (&g.at[first - 1..][..n], &g.at[first + 1..][..n]);
    let (north, south) = (&g.above[first..end], &g.below[first..end]);
    let (to_west, to_east) = (&faces.left[first..end], &faces.left[first + 1..][..n]);
    let (to_north, to_south) = (&faces.above[first..end], &faces.below[first..end]);
    for x in 0..n {
        let sides = [west[x], east[x], north[x], south[x]];
        let joined = [to_west[x], to_east[x], to_north[x], to_south[x]];
        out[x] = combine(out[x], at[x], flux(at[x], sides, joined));
    }
}

/// What flows into a sample from its neighbours west, east, north and south through faces of the given
/// conductances. Opposite neighbours are summed first: a mirrored or turned picture gives the same
/// bits.
#[inline(always)]
fn flux(g: f32, sides: [f32; 4], joined: [f32; 4]) -> f32 {
    let through = |i: usize| joined[i] * (sides[i] - g);
    (through(0) + through(1)) + (through(2) + through(3))
}
