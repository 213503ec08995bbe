//! Two neighbouring pixels, compared.

use crate::params::SoftThreshold;

/// Shares of a jump of depth by which it departs from the slopes on both sides: up to the first it is a slope, from the
/// second on a gap.
pub(crate) const DEPARTS: SoftThreshold = SoftThreshold { lo: 0.1, hi: 0.3 };

/// Sines of the angle between a tangent plane and the step across, likewise: a blurred jump departs little from the
/// slopes that it makes itself. Bumps in the normals of a floor stay below.
pub(crate) const TURNS: SoftThreshold = SoftThreshold { lo: 0.3, hi: 0.5 };

/// Thresholds rise by this many times the noise of depth.
pub(crate) const NOISES: f32 = 4.0;

/// Jumps beyond this, in pixels, count as such.
pub(crate) const STEEPEST: f32 = 1e15;

/// From this weight on a silhouette closes in full: a fit between pixels that are nearly closed would magnify the rounding
/// of what is left of them.
pub(crate) const CLOSED: f32 = 0.95;

/// What turns depths into pixels along an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapUnit {
    pub(crate) is_perspective: bool,
    /// Pixels per unit of length, in perspective at depth 1.
    pub(crate) pitch: f32,
    /// Twice the rounding error of depth: as a share of it, and in its own unit.
    pub(crate) rounding: [f32; 2],
}

impl GapUnit {
    /// Pixels per unit of length at the nearer of two pixels.
    #[inline(always)]
    fn px_per_unit(self, a: &Side, b: &Side) -> f32 {
        match self.is_perspective {
            true => self.pitch * larger(a.linear, b.linear),
            false => self.pitch,
        }
    }
}

/// The larger of two numbers: one instruction, unlike `f32::max`, which passes over what is not a number.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers, likewise.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// A pixel beside the border between it and its neighbour. What is unknown is NaN.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub(crate) depth: f32,
    /// [`GapScale::linear`] of the depth.
    pub(crate) linear: f32,
    /// The same of the next pixel away from the neighbour.
    pub(crate) beyond: f32,
    /// The sight line of z = -1 times the normal, which is negative where it is seen from the front.
    pub(crate) facing: f32,
    /// The step from the first to the second pixel at depth 1, times the normal.
    pub(crate) along: f32,
}

/// Two neighbouring pixels, compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// The distance between their surfaces, in pixels.
    pub(crate) px: f32,
    /// The part of the jump of depth that the slopes beside it do not explain, in pixels.
    pub(crate) bend: f32,
    /// How surely the pixels are on different surfaces, or on parts that are turned apart, 0..1.
    pub(crate) gate: f32,
    /// Smallest gap that rounding of depth makes, in pixels.
    pub(crate) rounding: f32,
}

impl Gap {
    /// The distance between the surfaces of two pixels, in pixels, without what is beyond them.
    #[inline(always)]
    pub(crate) fn px_between(a: &Side, b: &Side, unit: GapUnit) -> f32 {
        let step = b.depth - a.depth;
        let (past_a, past_b) = match unit.is_perspective {
            true => (b.depth, a.depth),
            false => (1.0, 1.0),
        };
        let off_a = (step * a.facing + past_a * a.along).abs();
        let off_b = (step * b.facing + past_b * b.along).abs();
        unit.px_per_unit(a, b) * larger(off_a, off_b)
    }

    /// Compares two pixels.
    #[inline(always)]
    pub(crate) fn between(a: Side, b: Side, unit: GapUnit) -> Self {
        let px = Self::px_between(&a, &b, unit);
        let per_linear = match unit.is_perspective {
            true => unit.pitch * larger(a.depth, b.depth),
            false => unit.pitch,
        };
        let jump = (b.linear - a.linear) * per_linear;
        let chords = [a.linear - a.beyond, b.beyond - b.linear].map(|chord| chord * per_linear);
        let (least, most) = (chords[0].min(chords[1]), chords[0].max(chords[1]));
        let bend = match least.is_nan() {
            true => jump.abs(),
            false => (least - jump).max(jump - most).max(0.0),
        };
        let departs = DEPARTS.weight(bend / jump.abs().max(f32::MIN_POSITIVE));
        // Where its square would not fit, all is a jump.
        let steep = jump.abs().min(STEEPEST);
        let turns = TURNS.weight(px / (1.0 + steep * steep).sqrt());
        let size = larger(a.depth.abs(), b.depth.abs());
        Self {
            px,
            bend,
            gate: departs.max(turns),
            rounding: unit.px_per_unit(&a, &b) * (unit.rounding[0] * size + unit.rounding[1]),
        }
    }

    /// The strength of the silhouette between them, where the depth around has this much noise, in pixels: up to 1 its
    /// weight, and beyond the size of a gap that closes in full, which tells the largest of several in a row.
    #[inline(always)]
    pub(crate) fn strength(&self, noise: f32, threshold: SoftThreshold) -> f32 {
        let more = self.rounding + NOISES * noise;
        let raised = SoftThreshold {
            lo: threshold.lo + more,
            hi: threshold.hi + more,
        };
        let weight = self.gate * raised.weight(self.px);
        if weight > CLOSED {
            self.px.max(1.0)
        } else {
            weight
        }
    }
}
