//! The gaps of a frame, one by one, with the noise of its depth.

use crate::frame::facing;
use crate::frame::gap::noise::{CALM, GapNoise};
use crate::frame::gap::pair::{Gap, Side};
use crate::frame::gap::rows::GapSamples;
use crate::frame::gap::scale::GapScale;
use crate::frame::{Frame, Plane, ToEye};
use crate::params::SoftThreshold;
use glam::Vec2;

/// The gaps of a frame.
pub(crate) struct Gaps<'a> {
    frame: &'a Frame,
    depth: &'a Plane,
    pub(crate) scale: GapScale,
    to_eye: ToEye,
    noise: GapNoise,
}

impl<'a> Gaps<'a> {
    /// The gaps of `depth`, a plane of `frame`. `threshold` is in longer sides of its display window.
    pub(crate) fn new(frame: &'a Frame, depth: &'a Plane, threshold: SoftThreshold) -> Self {
        let scale = GapScale::of(frame, threshold);
        let to_eye = ToEye::of(frame.data_window, Some(scale.projection));
        Self {
            frame,
            depth,
            scale,
            to_eye,
            noise: GapNoise::of(frame),
        }
    }

    /// The samples of row `y` where it has a surface.
    pub(crate) fn samples(&self, y: usize) -> GapSamples<'_> {
        let (mask, normal) = (&self.frame.mask, &self.frame.normal);
        let span = mask.span(y);
        GapSamples {
            first: span.start,
            depth: &self.depth.row(y)[span.clone()],
            covered: &mask.row(y)[span.clone()],
            normal: [&normal.x, &normal.y, &normal.z].map(|plane| &plane.row(y)[span.clone()]),
            to_eye: (&self.to_eye.x[span], self.to_eye.y[y]),
        }
    }

    /// The gap between a pixel and the next along an axis, 0 to the right and 1 downward, if both are covered.
    pub(crate) fn after(&self, at: [usize; 2], axis: usize) -> Option<Gap> {
        let [a, b] = self.sides_after(at, axis)?;
        let beyond = |by: isize| {
            let at = moved(at, axis, by).filter(|&at| self.is_covered(at));
            at.map_or(f32::NAN, |at| self.scale.linear(self.planar(at)))
        };
        let (before, behind) = (beyond(-1), beyond(2));
        let [a, b] = [
            Side {
                beyond: before,
                ..a
            },
            Side {
                beyond: behind,
                ..b
            },
        ];
        Some(Gap::between(a, b, self.scale.unit(axis)))
    }

    /// A pixel and the next along an axis, if both are covered; what lies beyond them is not looked at.
    fn sides_after(&self, at: [usize; 2], axis: usize) -> Option<[Side; 2]> {
        let next = moved(at, axis, 1)?;
        if !(self.is_covered(at) && self.is_covered(next)) {
            return None;
        }
        let side = |[x, y]: [usize; 2]| {
            let normal = &self.frame.normal;
            let normal = [normal.x.at(x, y), normal.y.at(x, y), normal.z.at(x, y)];
            let depth = self.planar([x, y]);
            Side {
                depth,
                linear: self.scale.linear(depth),
                beyond: f32::NAN,
                facing: -facing(normal.into(), Vec2::new(self.to_eye.x[x], self.to_eye.y[y])),
                along: normal[axis] * self.scale.step[axis],
            }
        };
        Some([side(at), side(next)])
    }

    /// What [`GapNoise`] takes of a gap, in pixels: the lesser of its size and of what the slopes beside it do not explain,
    /// beyond rounding; of one that is [`CALM`] by its size, that.
    fn stray_after(&self, at: [usize; 2], axis: usize) -> Option<f32> {
        let [a, b] = self.sides_after(at, axis)?;
        let px = Gap::px_between(&a, &b, self.scale.unit(axis));
        if px < CALM {
            return Some(px);
        }
        let gap = self.after(at, axis)?;
        Some((gap.px.min(gap.bend) - gap.rounding).max(0.0))
    }

    #[inline]
    fn is_covered(&self, [x, y]: [usize; 2]) -> bool {
        self.frame.mask.has(x, y)
    }

    /// The gap after a pixel, in pixels, where it makes a silhouette.
    pub(crate) fn seen_after(&self, at: [usize; 2], axis: usize) -> Option<f32> {
        let gap = self.after(at, axis)?;
        let strength = gap.strength(self.noise_after(at, axis), self.scale.threshold);
        (strength > 0.0).then_some(gap.px)
    }

    /// Whether a silhouette lies after a pixel. Where a normal is unknown, NaN, depth alone tells.
    pub(crate) fn parts_after(&self, at: [usize; 2], axis: usize) -> bool {
        let Some(mut gap) = self.after(at, axis) else {
            return false;
        };
        if gap.px.is_nan() {
            gap.px = gap.bend.min(self.jump_after(at, axis));
        }
        gap.strength(self.noise_after(at, axis), self.scale.threshold) > 0.0
    }

    /// The strength after a pixel, where it has `calm` without the noise of depth.
    pub(crate) fn strength_after(&self, at: [usize; 2], axis: usize, calm: f32) -> f32 {
        let noise = self.noise_after(at, axis);
        let gap = (noise > 0.0).then(|| self.after(at, axis));
        gap.flatten()
            .map_or(calm, |gap| gap.strength(noise, self.scale.threshold))
    }

    /// The jump of depth after a pixel that is not the last, in pixels.
    fn jump_after(&self, at: [usize; 2], axis: usize) -> f32 {
        let next = moved(at, axis, 1).unwrap_or(at);
        let depths = [at, next].map(|at| self.planar(at));
        self.scale.jump_px(depths, axis)
    }

    /// The noise of depth between a pixel and the next along an axis, in pixels.
    pub(crate) fn noise_after(&self, at: [usize; 2], axis: usize) -> f32 {
        self.noise
            .after(at, axis, &|at, axis| self.stray_after(at, axis))
    }

    /// The noise of all tiles, for the device: see [`GapNoise::tiles`]; `None` if there is none.
    #[cfg(feature = "gpu")]
    pub(crate) fn noise_tiles(&self) -> Option<(Plane, [i32; 2])> {
        let tiles = self.noise.tiles(&|at, axis| self.stray_after(at, axis));
        let is_any = tiles.0.samples().iter().any(|&noise| noise > 0.0);
        is_any.then_some(tiles)
    }

    /// Depth of a pixel along the view axis.
    #[inline]
    fn planar(&self, [x, y]: [usize; 2]) -> f32 {
        let eye = [self.to_eye.x[x], self.to_eye.y[y]];
        self.scale.planar(self.depth.at(x, y), eye)
    }
}

/// Whether a silhouette lies between each pixel and the next to the right, and the one below; `None` without depth.
/// `threshold` is in longer sides of the display window.
pub(crate) fn parted(frame: &Frame, threshold: SoftThreshold) -> Option<Plane<[bool; 2]>> {
    let depth = frame.depth.as_ref()?;
    let gaps = Gaps::new(frame, depth, threshold);
    Some(Plane::of_pixels(depth.width(), depth.height(), |x, y| {
        [0, 1].map(|axis| gaps.parts_after([x, y], axis))
    }))
}

/// The pixels left, right, above and below, and whether a silhouette lies between.
pub(crate) fn is_beside(
    parted: &Plane<[bool; 2]>,
    [x, y]: [usize; 2],
) -> impl Iterator<Item = ([usize; 2], bool)> {
    let before = [(x.wrapping_sub(1), y, 0), (x, y.wrapping_sub(1), 1)];
    let after = [(x + 1, y, 0), (x, y + 1, 1)];
    let before = before.map(|(i, k, axis)| Some(([i, k], parted.get(i, k)?[axis])));
    let own = parted.at(x, y);
    let after = after.map(|(i, k, axis)| parted.get(i, k).map(|_| ([i, k], own[axis])));
    before.into_iter().chain(after).flatten()
}

/// The pixel so many further along an axis.
#[inline]
fn moved(mut at: [usize; 2], axis: usize, by: isize) -> Option<[usize; 2]> {
    at[axis] = at[axis].checked_add_signed(by)?;
    Some(at)
}
