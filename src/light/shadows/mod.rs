//! Cast shadows over a height: the share of a round lamp that each pixel sees.
//!
//! Toward the lamp the surface rises to a horizon, and the lamp is seen as far as it stands above that. Horizons of all
//! pixels along one azimuth follow from sweeps away from the light, each with the upper hull of the heights that it has
//! passed, in a time linear in pixels (the idea of Timonen, Westerholm: Scalable Height Field Self-Shadowing, Eurographics
//! 2010, section 3). Changes: a sweep goes through every column, between two pixels of it, and these look at their horizon
//! from where it passes the plane of their own surface, so that no bias keeps one from shadowing itself; hulls have the
//! crossings of rows too, so that the edge of a step is where it is at any azimuth; and several azimuths across the lamp
//! soften shadows beside their caster.

pub(crate) mod cast;
pub(crate) mod casting;
pub(crate) mod horizons;
mod hull;
pub(crate) mod keys;
mod lamp;
mod march;
mod strips;
mod sweep;

use crate::frame::Plane;
use crate::frame::memory::Memory;
use crate::kernel::fast_math::{atan, atan2};
use crate::kernel::simd::wide;
use crate::shape::occlusion::NOTHING;
use lamp::Chord;
pub(crate) use lamp::Lamp;
use strips::Heights;
use sweep::Azimuth;

/// The most azimuths across a lamp.
const MOST_AZIMUTHS: usize = 15;

/// The share of `lamp` that each pixel of a surface of these heights sees, 0..1. Heights are in pixels of their mean size,
/// [`NOTHING`] where there is none; pixels are `shape` times as wide as high.
pub(crate) fn shares(height: &Plane, lamp: &Lamp, shape: f32, memory: &Memory) -> Plane {
    let chords = lamp.chords(azimuths(height, lamp));
    let total: f32 = chords.iter().map(|chord| chord.weight).sum();
    let mut shares = Plane::filled(height.width(), height.height(), 0.0);
    for is_transposed in [false, true] {
        let of_way = chords
            .iter()
            .map(|chord| (chord, Azimuth::of(chord.azimuth, shape)));
        let of_way = of_way.filter(|(_, azimuth)| azimuth.is_transposed == is_transposed);
        let mut of_way = of_way.peekable();
        if of_way.peek().is_none() {
            continue;
        }
        let heights = Heights::of(height, is_transposed);
        let mut sum = heights.found();
        for (chord, azimuth) in of_way {
            if memory.is_cancelled() {
                return shares;
            }
            let share = chord.weight / total;
            let see = |slopes: &mut [f32], per_column, seen: &mut [f32]| {
                wide!(seen_row(slopes, chord, per_column, share));
                seen.copy_from_slice(slopes);
            };
            azimuth.sweep(&heights, chord.is_disc, see, &mut sum);
        }
        shares.each_with(&heights.turned_back(sum), |share, more| *share += more);
    }
    shares
}

/// Azimuths across a lamp from which the longest shadow has no steps in its penumbra: an odd number.
fn azimuths(height: &Plane, lamp: &Lamp) -> usize {
    let penumbra = lamp.radius as f32 * longest_px(height, lamp.elevation.tan() as f32);
    penumbra.ceil().clamp(1.0, MOST_AZIMUTHS as f32) as usize | 1
}

/// The length of the longest shadow that heights can cast in light of this slope, in pixels.
fn longest_px(height: &Plane, slope: f32) -> f32 {
    let [low, high] = range(height);
    (high - low).max(0.0) / slope.max(1e-3)
}

/// The lowest and the highest height.
fn range(height: &Plane) -> [f32; 2] {
    let heights = height.samples().iter().filter(|&&h| h > NOTHING);
    heights.fold([f32::MAX, f32::MIN], |[low, high], &h| {
        [low.min(h), high.max(h)]
    })
}

/// Slopes to the horizon per column, turned into shares of what is seen of a chord of a lamp above it, or of the lamp.
#[inline(always)]
fn seen_row(slopes: &mut [f32], chord: &Chord, per_column: f32, share: f32) {
    let Chord {
        slope: own,
        per_half,
        is_disc,
        ..
    } = *chord;
    for slope in slopes {
        let there = *slope * per_column;
        // The tangent of the difference of the two angles, from 0 to 180 degrees.
        let (difference, along) = (there - own, 1.0 + there * own);
        let tangent = if along > 0.0 {
            difference / along
        } else {
            difference.signum() * FAR
        };
        let above = atan(tangent) * per_half;
        let seen = if is_disc {
            disc_above(above)
        } else {
            (0.5 - 0.5 * above).clamp(0.0, 1.0)
        };
        *slope = share * seen;
    }
}

/// The tangent of an angle that is far above or below a lamp.
const FAR: f32 = 1e6;

/// The share of a disc of radius 1 above a line at this height over its middle.
#[inline(always)]
fn disc_above(line: f32) -> f32 {
    let u = line.clamp(-1.0, 1.0);
    let half = ((1.0 - u) * (1.0 + u)).sqrt();
    (atan2(half, u) - u * half) * std::f32::consts::FRAC_1_PI
}

#[cfg(test)]
mod tests;
