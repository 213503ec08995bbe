//! What hides light from all around: the horizons of each pixel along a ring of azimuths.
//!
//! They are found once, and each light of an environment is seen as far as it stands above the horizons of the two azimuths
//! beside it. A light stands for a piece of the environment about as wide as azimuths are apart, and sets
//! gradually. What is seen of an even sky has a closed form by azimuth, that of [`crate::shape::occlusion`].

use super::strips::Heights;
use super::sweep::Azimuth;
use crate::frame::Plane;
use crate::kernel::fast_math::{atan, atan2, polynomial};
use crate::kernel::simd::wide;
use crate::light::batch::{BATCH, Lanes, Vectors};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Azimuths, evenly all around from the right of the picture.
pub(crate) const AZIMUTHS: usize = 16;

/// Half of the angle within which a light sets.
const SETTING: f32 = PI / AZIMUTHS as f32 / 1.5;

/// The unit of stored elevations, in radians.
const UNIT: f32 = PI / 255.0;

/// The slope of the lowest horizons that are looked for around a tile: that of 2 degrees.
pub(super) const LOWEST: f32 = 0.035;

/// The elevations of all horizons over the picture plane, from -90 degrees in steps of [`UNIT`].
pub(crate) struct Horizons([Plane<u8>; AZIMUTHS]);

/// The horizons of a batch of pixels, in radians.
pub(crate) type HorizonLanes = [Lanes; AZIMUTHS];

impl Horizons {
    /// Of a surface of heights in pixels of their mean size, which are `shape` times as wide as high, by what `cut` makes of
    /// each plane.
    pub(crate) fn of(height: &Plane, shape: f32, cut: impl Fn(Plane<u8>) -> Plane<u8>) -> Self {
        let along = |k| Azimuth::of(f64::from(azimuth(k)), shape);
        let azimuths: [_; AZIMUTHS] = std::array::from_fn(along);
        let mut planes = [(); AZIMUTHS].map(|()| Plane::filled(0, 0, 0));
        for is_transposed in [false, true] {
            let heights = Heights::of(height, is_transposed);
            let pairs = planes.iter_mut().zip(&azimuths);
            for (plane, azimuth) in pairs.filter(|(_, of)| of.is_transposed == is_transposed) {
                let mut found = heights.found();
                let see = |slopes: &mut [f32], per_column, seen: &mut [u8]| {
                    wide!(to_elevations(slopes, per_column, seen));
                };
                azimuth.sweep(&heights, false, see, &mut found);
                *plane = cut(heights.turned_back(found));
            }
        }
        Self(planes)
    }

    /// Sets lanes to the horizons of pixels of a row.
    pub(crate) fn copy_to(
        &self,
        lanes: &mut HorizonLanes,
        from: usize,
        (y, columns): (usize, std::ops::Range<usize>),
    ) {
        for (lanes, plane) in lanes.iter_mut().zip(&self.0) {
            let stored = &plane.row(y)[columns.clone()];
            for (lane, &elevation) in lanes[from..].iter_mut().zip(stored) {
                *lane = f32::from(elevation) * UNIT - FRAC_PI_2;
            }
        }
    }
}

/// Slopes per column to elevations in [`UNIT`], from -90 degrees.
#[inline(always)]
fn to_elevations(slopes: &[f32], per_column: f32, elevations: &mut [u8]) {
    for (elevation, slope) in elevations.iter_mut().zip(slopes) {
        let units = (atan(slope * per_column) + FRAC_PI_2) * UNIT.recip();
        // Rounded into the last bits of a float so large that it is whole: done for many at a time, as no conversion is.
        *elevation = (units + (1 << 23) as f32).to_bits() as u8;
    }
}

fn azimuth(k: usize) -> f32 {
    TAU * k as f32 / AZIMUTHS as f32
}

/// Where a light stands among the azimuths.
pub(crate) struct Bearing {
    beside: [usize; 2],
    /// The share of the second of them.
    share: f32,
    elevation: f32,
}

impl Bearing {
    /// Of a light in this direction.
    pub(crate) fn of([x, y, z]: [f32; 3]) -> Self {
        let turn = y.atan2(x).rem_euclid(TAU) / TAU * AZIMUTHS as f32;
        let first = turn as usize % AZIMUTHS;
        Self {
            beside: [first, (first + 1) % AZIMUTHS],
            share: turn.fract(),
            elevation: z.atan2(x.hypot(y)),
        }
    }

    /// Takes off `light` what horizons hide.
    #[inline(always)]
    pub(crate) fn hide(&self, horizons: &HorizonLanes, light: &mut Lanes) {
        let [a, b] = self.beside.map(|k| &horizons[k]);
        for i in 0..BATCH {
            light[i] *= seen([a[i], b[i]], self.share, self.elevation);
        }
    }
}

/// Takes off `share` what horizons hide of light from another direction in each pixel.
#[inline(always)]
pub(crate) fn hide_each(horizons: &HorizonLanes, [x, y, z]: &Vectors, share: &mut Lanes) {
    for i in 0..BATCH {
        let turn = atan2(y[i], x[i]) * (AZIMUTHS as f32 / TAU) + AZIMUTHS as f32;
        let first = turn as usize;
        let [a, b] = [first, first + 1].map(|k| horizons[k % AZIMUTHS][i]);
        let elevation = atan2(z[i], (x[i] * x[i] + y[i] * y[i]).sqrt());
        share[i] *= seen([a, b], turn - first as f32, elevation);
    }
}

/// What is seen of a light between two azimuths: the mean of what would be seen in each. Above the mean of two horizons a
/// light beside a corner would be seen whole, or not at all.
#[inline(always)]
fn seen(horizons: [f32; 2], share: f32, elevation: f32) -> f32 {
    let [a, b] = horizons.map(|horizon| above((horizon - elevation) / SETTING));
    a + share * (b - a)
}

/// The share of a disc of radius 1 above a line at this height over its middle, within 0.01: the mean of a ramp and of a
/// smooth step.
#[inline(always)]
fn above(line: f32) -> f32 {
    let t = (0.5 - 0.5 * line).clamp(0.0, 1.0);
    0.5 * t * (1.0 + t * (3.0 - 2.0 * t))
}

/// The share of an even sky that each pixel sees, of what its own plane leaves of it: `share` gets it.
#[inline(always)]
pub(crate) fn see_sky(horizons: &HorizonLanes, normal: &Vectors, share: &mut Lanes) {
    let [x, y, z] = normal;
    *share = [0.0; BATCH];
    for (k, horizons) in horizons.iter().enumerate() {
        let (sine, cosine) = azimuth(k).sin_cos();
        for i in 0..BATCH {
            let toward = x[i] * cosine + y[i] * sine;
            // The surface hides what is below its own plane.
            let own = atan((-toward / z[i].max(1e-3)).max(0.0));
            let elevation = horizons[i].max(own);
            // Of the angle from the sight line, which is the rest of a right one.
            let c = elevation * polynomial(elevation * elevation, SINE);
            let s = (1.0 - c * c).max(0.0).sqrt();
            share[i] += z[i] * s * s + toward * (FRAC_PI_2 - elevation - s * c);
        }
    }
    for i in 0..BATCH {
        let open = AZIMUTHS as f32 * 0.5 * (1.0 + z[i]);
        share[i] = (share[i] / open.max(1e-3)).clamp(0.0, 1.0);
    }
}

/// Coefficients of sin(t) / t in powers of t^2, to 90 degrees: the beginning of its series, within 2e-4.
const SINE: [f32; 4] = [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0];
