//! Gaps between the surfaces of pixels in double precision, from their points and normals.

use super::surface::Surface;
use super::weight::{EPSILON, Weight, covered};
use crate::frame::{Frame, Plane, SightLines};
use crate::params::SoftThreshold;
use crate::shape::gap::of_frame::Gaps;
use crate::shape::gap::pair::{DEPARTS, NOISES, TURNS};
use glam::DVec3;

/// The weight of the gap between a pixel and the next, and the difference of their depths.
type Pair = (Weight, f64);

/// The gaps of a frame, from each pixel to the next ones to the right and below.
pub(super) struct ExactGaps {
    after: [Plane<Option<Pair>>; 2],
}

impl ExactGaps {
    /// The gaps of a surface with this depth. `threshold` is in longer sides of the display window.
    pub(super) fn new(
        frame: &Frame,
        surface: &Surface,
        depth: &Plane<f64>,
        threshold: SoftThreshold,
    ) -> Self {
        // In single precision: how noisy depth is is no matter of rounding.
        let single = depth.map(|depth| depth as f32);
        let gaps = Gaps::new(frame, &single, threshold);
        let sight = SightLines::new(gaps.scale.projection);
        let (mask, kind) = (&frame.mask, frame.source.depth_kind);
        let places = covered(mask, |x, y| {
            let at = frame.data_window.middle(x, y);
            Some(sight.point(at.x, at.y, depth.at(x, y), kind))
        });
        let after =
            [0, 1].map(|axis| covered(mask, |x, y| pair([x, y], axis, (&places, surface), &gaps)));
        Self { after }
    }

    /// The silhouettes that a pixel is in front of, and that it is beside.
    pub(super) fn silhouettes(&self, [x, y]: [usize; 2]) -> [Weight; 2] {
        let before = [[x.wrapping_sub(1), y], [x, y.wrapping_sub(1)]];
        let mut found = [Weight::default(); 2];
        for (axis, after) in self.after.iter().enumerate() {
            for (at, is_first) in [([x, y], true), (before[axis], false)] {
                let Some((weight, step)) = inside(after, at) else {
                    continue;
                };
                found[1] = found[1].max(weight);
                // Of equal depths the first is the nearer.
                if (step >= 0.0) == is_first {
                    found[0] = found[0].max(weight);
                }
            }
        }
        found
    }
}

/// The sample of a plane, if it is inside and there is one.
fn inside<T: Copy>(plane: &Plane<Option<T>>, [x, y]: [usize; 2]) -> Option<T> {
    let is_inside = x < plane.width() && y < plane.height();
    is_inside.then(|| plane.at(x, y)).flatten()
}

/// The gap between the pixel `at` and the next along an axis, if both are covered.
///
/// Rounding: depths, their differences and products with normals are off by a few ulps of the larger depth.
fn pair(
    at: [usize; 2],
    axis: usize,
    (places, surface): (&Plane<Option<DVec3>>, &Surface),
    gaps: &Gaps,
) -> Option<Pair> {
    let by = |by: usize| {
        let mut at = at;
        at[axis] = at[axis].wrapping_add(by);
        at
    };
    let place = |at| inside(places, at);
    let normal =
        |[x, y]: [usize; 2]| DVec3::from_array(surface.normal.each_ref().map(|n| n.at(x, y)));
    let (a, b) = (place(at)?, place(by(1))?);
    let [depth_a, depth_b] = [-a.z, -b.z];
    let scale = &gaps.scale;
    let pitch = f64::from(scale.pitch[axis]);
    let linear = |depth: f64| {
        if scale.is_perspective {
            1.0 / depth
        } else {
            depth
        }
    };
    let (per_unit, per_linear) = match scale.is_perspective {
        true => (pitch / depth_a.min(depth_b), pitch * depth_a.max(depth_b)),
        false => (pitch, pitch),
    };
    let [off_a, off_b] = [at, by(1)].map(|at| (normal(at).dot(b - a) * per_unit).abs());
    let px = off_a.max(off_b);
    let rise = |from: DVec3, to: DVec3| (linear(-to.z) - linear(-from.z)) * per_linear;
    let jump = rise(a, b);
    let chords = [
        place(by(usize::MAX)).map(|before| rise(before, a)),
        place(by(2)).map(|behind| rise(b, behind)),
    ];
    let known = chords.into_iter().flatten();
    let least = known.clone().reduce(f64::min);
    let bend = least
        .zip(known.reduce(f64::max))
        .map_or(jump.abs(), |(least, most)| {
            (least - jump).max(jump - most).max(0.0)
        });
    let size = depth_a.abs().max(depth_b.abs());
    let rounding = 16.0 * EPSILON * (1.0 + per_unit * size);
    let steep = jump.abs().max(f64::MIN_POSITIVE);
    let departs = Weight::ramp(bend / steep, rounding / steep, DEPARTS);
    let length = jump.hypot(1.0);
    let turns = Weight::ramp(px / length, rounding / length, TURNS);
    let [share, unit] = scale.rounding.map(f64::from);
    let more = per_unit * (share * size + unit) + f64::from(NOISES * gaps.noise_after(at, axis));
    let raised = Weight::ramp(px - more, rounding, scale.threshold);
    Some((departs.max(turns).times(raised).closed(), depth_b - depth_a))
}
