//! Occlusion from height: how much of the sky each pixel sees, and from where on average.
//!
//! The sky is cut into slices, planes through the sight line. In a slice the sky is seen between two horizons, the
//! steepest rises of the height to either side within a radius. The cosine-weighted share that is seen, and the mean
//! direction of that light, then have closed forms (after Bavoil, Sainz, Dimitrov, *Image-space horizon-based ambient
//! occlusion*, SIGGRAPH 2008; the weight by the cosine to the normal is our own integral).
//!
//! With the angle t from the sight line, positive along the slice's direction d, horizons -a and b, and a normal with n_z
//! and n_d in the slice, the light is `|sin t| (n_z cos t + n_d sin t) dt`. For one side, with c and s the cosine and
//! sine of its horizon, it adds up to `n_z s^2 / 2 + n_d (b - s c) / 2`.

pub(crate) mod cpu;
pub(crate) mod stage;

use crate::frame::{Mask, Plane, Vector3Planes, parallel_rows};
use crate::kernel::fast_math::atan;
use crate::kernel::simd::wide;
use rayon::prelude::*;
use std::f32::consts::PI;
use std::ops::Range;

/// A direction in which horizons are looked for, to both sides.
struct Slice {
    /// x right, y up.
    direction: [f32; 2],
    steps: Vec<SliceStep>,
}

/// A step along a slice: to a whole column or row, between two pixels of it.
pub(crate) struct SliceStep {
    /// Columns to the right and rows down to the first pixel, and to the second.
    pixels: [[isize; 2]; 2],
    /// Share of the second.
    share: f32,
    /// Columns and rows to the place between, and the reciprocal of its distance.
    offset: [f32; 2],
    inverse: f32,
}

/// Each step is longer than the one before by this factor, and by a pixel at least.
const GROWTH: f32 = 1.25;

impl Slice {
    /// `count` slices, evenly spread, that reach `radius` pixels.
    fn all(count: u32, radius: f32) -> Vec<Self> {
        let slice = |i: u32| {
            let angle = PI * (i as f32 + 0.5) / count as f32;
            let direction = [angle.cos(), angle.sin()];
            // One step along the longer axis.
            let longer = direction[0].abs().max(direction[1].abs());
            let mut steps = Vec::new();
            let mut length = 1.0_f32;
            while length / longer <= radius.max(1.0 / longer) {
                steps.push(SliceStep::along(direction, length / longer));
                length = (length * GROWTH).round().max(length + 1.0);
            }
            Self { direction, steps }
        };
        (0..count).map(slice).collect()
    }
}

impl SliceStep {
    pub(crate) fn along(direction: [f32; 2], length: f32) -> Self {
        let offset = [length * direction[0], -length * direction[1]];
        let whole = offset.map(f32::round);
        // The axis along which the step is whole, up to rounding.
        let axis = usize::from(direction[1].abs() > direction[0].abs());
        let other = 1 - axis;
        let first = offset[other].floor();
        let mut pixels = [[0; 2]; 2];
        for (pixel, along) in pixels.iter_mut().zip([first, first + 1.0]) {
            pixel[axis] = whole[axis] as isize;
            pixel[other] = along as isize;
        }
        Self {
            pixels,
            share: offset[other] - first,
            offset,
            inverse: length.recip(),
        }
    }

    /// The same to the other side.
    fn opposite(&self) -> Self {
        Self {
            pixels: self.pixels.map(|pixel| pixel.map(|v| -v)),
            share: self.share,
            offset: self.offset.map(|v| -v),
            inverse: self.inverse,
        }
    }

    /// The columns of `span` from which both pixels lie inside `width`.
    fn columns(&self, span: &Range<usize>, width: usize) -> Range<usize> {
        let [a, b] = self.pixels.map(|[dx, _]| dx);
        let from = (-a.min(b)).max(span.start as isize);
        let to = (width as isize - a.max(b)).min(span.end as isize);
        from as usize..to.max(from) as usize
    }
}

/// The sky seen over a height.
pub(crate) struct Sky {
    /// The share of its light that arrives, 0..1; 0 outside the mask.
    pub(crate) seen: Plane,
    /// The unit direction from which it arrives on average, in view space.
    pub(crate) bent: Vector3Planes,
}

impl Sky {
    /// The same of planes that `change` makes of these.
    fn mapped(&self, change: impl Fn(&Plane) -> Plane) -> Self {
        Self {
            seen: change(&self.seen),
            bent: self.bent.mapped(change),
        }
    }
}

/// The sky seen from each pixel of a surface with this height, in pixels, and these normals, within a radius in pixels.
/// What is higher than a pixel hides the sky behind it; outside the mask and the picture is nothing.
pub(crate) fn sky(
    height: &Plane,
    normal: &Vector3Planes,
    mask: &Mask,
    radius: f32,
    slices: u32,
) -> Sky {
    let (width, rows) = (mask.width(), mask.height());
    let slices = Slice::all(slices, radius);
    let mut planes = [(); 4].map(|()| Plane::filled(width, rows, 0.0));
    let scratch = || [(); 4].map(|()| vec![0.0; width]);
    parallel_rows(planes.each_mut()).for_each_init(scratch, |scratch, (row, [seen, x, y, z])| {
        let span = mask.span(row);
        if span.is_empty() {
            return;
        }
        let normal = [&normal.x, &normal.y, &normal.z].map(|plane| plane.row(row));
        let [plus, minus, p, q] = &mut *scratch;
        wide!(tangent_row(p, q, normal));
        for slice in &slices {
            plus.fill(0.0);
            minus.fill(0.0);
            for step in &slice.steps {
                for (horizon, step) in [(&mut *plus, step), (&mut *minus, &step.opposite())] {
                    let there = step.pixels.map(|[_, dy]| row as isize + dy);
                    let at = step.columns(&span, width);
                    if at.is_empty() || there.iter().any(|y| !(0..rows as isize).contains(y)) {
                        continue;
                    }
                    let beyond = |i: usize| {
                        let from = at.start as isize + step.pixels[i][0];
                        &height.row(there[i] as usize)[from as usize..][..at.len()]
                    };
                    let heights = [&height.row(row)[at.clone()], beyond(0), beyond(1)];
                    let tangent = [&p[at.clone()], &q[at.clone()]];
                    wide!(raise_row(&mut horizon[at], heights, tangent, step));
                }
            }
            let out = [&mut *seen, &mut *x, &mut *y, &mut *z];
            let above = [&plus[..], &minus[..], &p[..], &q[..]];
            wide!(add_slice_row(out, normal, above, slice.direction));
        }
        let scale = (slices.len() as f32).recip();
        wide!(finish_row([seen, x, y, z], normal, mask.row(row), scale));
    });
    let [seen, x, y, z] = planes;
    Sky {
        seen,
        bent: Vector3Planes { x, y, z },
    }
}

/// A height outside the mask: nothing is hidden by it.
pub(crate) const NOTHING: f32 = -1e30;

/// Surfaces are taken no steeper than with this n_z.
const LEAST_NZ: f32 = 0.05;

/// Slopes of the surface's own plane, per column and per row down.
#[inline(always)]
pub(crate) fn tangent_row(p: &mut [f32], q: &mut [f32], normal: [&[f32]; 3]) {
    let n = p.len();
    let (q, [nx, ny, nz]) = (&mut q[..n], normal.map(|row| &row[..n]));
    for x in 0..n {
        let inverse = 1.0 / nz[x].max(LEAST_NZ);
        (p[x], q[x]) = (-nx[x] * inverse, ny[x] * inverse);
    }
}

/// Raises horizons, slopes over the surface's own plane, to those toward the heights of a step.
#[inline(always)]
pub(crate) fn raise_row(
    horizon: &mut [f32],
    heights: [&[f32]; 3],
    tangent: [&[f32]; 2],
    step: &SliceStep,
) {
    let n = horizon.len();
    let [own, first, second] = heights.map(|row| &row[..n]);
    let [p, q] = tangent.map(|row| &row[..n]);
    let &SliceStep {
        share,
        offset,
        inverse,
        ..
    } = step;
    for x in 0..n {
        let plane = p[x] * offset[0] + q[x] * offset[1];
        let there = first[x] + share * (second[x] - first[x]);
        let slope = ((there - own[x]) - plane) * inverse;
        horizon[x] = if slope > horizon[x] {
            slope
        } else {
            horizon[x]
        };
    }
}

/// Adds the light of one slice, and its direction. Horizons to both sides are slopes over the plane of slopes p and q.
#[inline(always)]
pub(crate) fn add_slice_row(
    out: [&mut [f32]; 4],
    normal: [&[f32]; 3],
    horizons: [&[f32]; 4],
    direction: [f32; 2],
) {
    let [seen, x, y, z] = out;
    let n = seen.len();
    let (x, y, z) = (&mut x[..n], &mut y[..n], &mut z[..n]);
    let [nx, ny, nz] = normal.map(|row| &row[..n]);
    let [plus, minus, p, q] = horizons.map(|row| &row[..n]);
    for i in 0..n {
        let (nz, nd) = (nz[i], nx[i] * direction[0] + ny[i] * direction[1]);
        let own = p[i] * direction[0] - q[i] * direction[1];
        let (plus, minus) = (plus[i] + own, minus[i] - own);
        let [(s2, c2), (s1, c1)] = [plus, minus].map(|slope| {
            let sine = 1.0 / (1.0 + slope * slope).sqrt();
            (sine, slope * sine)
        });
        // Angles from the sight line are pi/2 - atan(slope): their difference lacks pi/2.
        let turned = atan(minus) - atan(plus);
        seen[i] += 0.5 * (nz * (s2 * s2 + s1 * s1) + nd * (turned - s2 * c2 + s1 * c1));
        let [(s2, c2), (s1, c1)] =
            [(s2, c2), (s1, c1)].map(|(s, c)| (s * s * s / 3.0, (c, c * c * c / 3.0)));
        let along = nz * (s2 - s1) + nd * ((4.0 / 3.0 - c2.0 - c1.0) + (c2.1 + c1.1));
        let up = nz * (2.0 / 3.0 - c2.1 - c1.1) + nd * (s2 - s1);
        x[i] += direction[0] * along;
        y[i] += direction[1] * along;
        z[i] += up;
    }
}

/// Turns sums into shares and unit directions: the normal where no light comes; 0 where uncovered.
#[inline(always)]
pub(crate) fn finish_row(out: [&mut [f32]; 4], normal: [&[f32]; 3], covered: &[bool], scale: f32) {
    let [seen, x, y, z] = out;
    let n = seen.len();
    let (x, y, z, covered) = (&mut x[..n], &mut y[..n], &mut z[..n], &covered[..n]);
    let [nx, ny, nz] = normal.map(|row| &row[..n]);
    for i in 0..n {
        let length = (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt();
        let is_lit = length > 1e-6;
        let inverse = 1.0 / length;
        let share = (seen[i] * scale).clamp(0.0, 1.0);
        seen[i] = if covered[i] { share } else { 0.0 };
        x[i] = if is_lit { x[i] * inverse } else { nx[i] };
        y[i] = if is_lit { y[i] * inverse } else { ny[i] };
        z[i] = if is_lit { z[i] * inverse } else { nz[i] };
        if !covered[i] {
            (x[i], y[i], z[i]) = (0.0, 0.0, 0.0);
        }
    }
}

#[cfg(test)]
mod tests;
