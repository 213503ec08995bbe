//! From one frame to the next: the previous position of every pixel's surface, and its places there.

use crate::frame::memory::Memory;
use crate::frame::rows::map_covered;
use crate::frame::{Frame, Plane, Vector2Planes, Window};
use crate::kernel::quantile::quantile;
use crate::line::texture_coordinates::hidden::Hidden;
use crate::line::texture_coordinates::is_one_depth;
use crate::line::texture_coordinates::is_one_motion;
use crate::line::texture_coordinates::origin::Origin;
use crate::line::texture_coordinates::places::{
    MovingSurface, PlaceMap, calmed_at, jacobian_at, origin_in, place_at,
};
use crate::line::texture_coordinates::{extrapolated, is_joined};

/// Rounds of averaging places with their neighbours in each frame. That removes a thousandth of a pixel from the
/// curvature of a map, and most of its roughness up to eight pixels in size.
const CALMINGS: usize = 2;

/// Pixels along each axis from one to the next that is looked at for the change of all depth.
const STRIDE: usize = 8;

/// Smaller weights are due to rounding.
const LEAST_WEIGHT: f32 = 1e-4;

/// From one frame to the next.
pub(crate) struct FrameStep<'a> {
    window_before: Window,
    before: MovingSurface<'a>,
    frame: &'a Frame,
    motion: &'a Vector2Planes,
    /// Depth now over depth before, in the median.
    depth_ratio: f32,
}

impl<'a> FrameStep<'a> {
    pub(crate) fn new(
        window_before: Window,
        before: MovingSurface<'a>,
        frame: &'a Frame,
        motion: &'a Vector2Planes,
    ) -> Self {
        let size = |plane: &Plane| (plane.width(), plane.height());
        let expected = (frame.mask.width(), frame.mask.height());
        assert!(
            size(&motion.x) == expected && size(&motion.y) == expected,
            "motion has the size of its frame"
        );
        let mut step = Self {
            window_before,
            before,
            frame,
            motion,
            depth_ratio: 1.0,
        };
        step.depth_ratio = step.median_depth_ratio();
        step
    }

    /// Between which pixels the surface of a pixel was; `None` outside all of them.
    #[inline(always)]
    fn between(&self, x: usize, y: usize) -> Option<Origin> {
        let (now, then) = (self.frame.data_window, self.window_before);
        let from = |at: usize, shift: i32, moved: f32, length: usize| {
            let from = at as f64 + f64::from(shift) - f64::from(moved);
            // NaN motion leads nowhere either.
            (from > -1.0 && from < length as f64).then(|| (from.floor(), from))
        };
        let (width, height) = (self.before.covered.width(), self.before.covered.height());
        let (left, u) = from(x, now.x0 - then.x0, self.motion.x.at(x, y), width)?;
        let (top, v) = from(y, now.y0 - then.y0, -self.motion.y.at(x, y), height)?;
        Some(Origin {
            left: left as i32,
            top: top as i32,
            across: (u - left) as f32,
            down: (v - top) as f32,
            seen: 0,
            whole: false,
        })
    }

    /// The same, with the pixels among these that show that surface.
    #[inline(always)]
    fn origin(&self, x: usize, y: usize) -> Origin {
        let Some(mut origin) = self.between(x, y) else {
            return Origin::default();
        };
        let covered = self.before.covered;
        origin.whole = true;
        for k in 0..4 {
            if origin.weight(k) < LEAST_WEIGHT {
                continue;
            }
            let pixel = origin.pixel(k, covered.width(), covered.height());
            let seen =
                pixel.filter(|&[u, v]| covered.at(u, v) && self.is_same_surface([x, y], [u, v]));
            origin.seen |= u8::from(seen.is_some()) << k;
            origin.whole &= seen.is_some();
        }
        origin
    }

    #[inline(always)]
    fn is_same_surface(&self, now: [usize; 2], then: [usize; 2]) -> bool {
        if let (Some(depth), Some(before)) = (&self.frame.depth, self.before.depth) {
            let before = self.depth_ratio * before.at(then[0], then[1]);
            return is_one_depth(depth.at(now[0], now[1]), before);
        }
        let Some(before) = self.before.motion else {
            return true;
        };
        let at =
            |motion: &Vector2Planes, [x, y]: [usize; 2]| place_at(motion, y * motion.x.width() + x);
        is_one_motion(at(self.motion, now), at(before, then))
    }

    /// The change of depth of most of the frame: a camera may move fast.
    fn median_depth_ratio(&self) -> f32 {
        let (Some(depth), Some(before)) = (&self.frame.depth, self.before.depth) else {
            return 1.0;
        };
        let covered = self.before.covered;
        let mut ratios = Vec::new();
        for y in (0..self.frame.mask.height()).step_by(STRIDE) {
            for x in (0..self.frame.mask.width()).step_by(STRIDE) {
                let is_seen = self.frame.mask.at(x, y);
                let origin = self.between(x, y).filter(|_| is_seen);
                let pixel = origin.and_then(|o| o.pixel(0, covered.width(), covered.height()));
                if let Some([u, v]) = pixel.filter(|&[u, v]| covered.at(u, v)) {
                    ratios.push(depth.at(x, y) / before.at(u, v));
                }
            }
        }
        ratios.retain(|ratio| ratio.is_finite() && *ratio > 0.0);
        quantile(&mut ratios, 0.5, f32::total_cmp).unwrap_or(1.0)
    }

    /// The previous position of every covered pixel's surface.
    pub(crate) fn origins(&self) -> Plane<Origin> {
        Plane::of_covered(&self.frame.mask, |y| move |x| self.origin(x, y))
    }

    /// The places of `map`, moved to this frame.
    pub(crate) fn carried(
        &self,
        map: &PlaceMap,
        origins: &Plane<Origin>,
        hidden: &Hidden,
        memory: &Memory,
    ) -> Vector2Planes {
        let mask = &self.frame.mask;
        let [left, top] = origin_in(map.generation, self.frame.data_window);
        let [x, y] = map_covered(mask, memory, |y| {
            move |x| {
                let still = [left + x as f32, top + y as f32];
                self.place(map, &origins.row(y)[x]).unwrap_or(still)
            }
        });
        let mut moved = Vector2Planes { x, y };
        hidden.fill(&mut moved);
        let surface = MovingSurface::of(self.frame, Some(self.motion));
        for _ in 0..CALMINGS {
            let [x, y] = map_covered(mask, memory, |y| {
                let (moved, surface) = (&moved, &surface);
                move |x| calmed_at(moved, surface, x, y)
            });
            let rough = std::mem::replace(&mut moved, Vector2Planes { x, y });
            memory.recycle([rough.x, rough.y]);
        }
        moved
    }

    /// The place that a surface had before.
    #[inline(always)]
    fn place(&self, map: &PlaceMap, origin: &Origin) -> Option<[f32; 2]> {
        if origin.seen == 0 {
            return None;
        }
        let (width, height) = (map.place.x.width(), map.place.x.height());
        let nearest = (0..4).filter(|&k| origin.is_seen(k));
        let nearest = nearest.max_by(|&a, &b| origin.weight(a).total_cmp(&origin.weight(b)))?;
        let [x, y] = origin.pixel(nearest, width, height)?;
        let here = place_at(&map.place, y * width + x);
        let (mut moved, mut joined) = (here, origin.whole);
        for k in (0..4).filter(|&k| origin.is_seen(k) && k != nearest) {
            let [u, v] = origin.pixel(k, width, height)?;
            let there = place_at(&map.place, v * width + u);
            joined &= is_joined(here, there);
            let weight = origin.weight(k);
            moved[0] += weight * (there[0] - here[0]);
            moved[1] += weight * (there[1] - here[1]);
        }
        if joined {
            return Some(moved);
        }
        let by = jacobian_at(&map.place, &self.before, x, y);
        Some(extrapolated(here, &by, origin.offset(nearest)))
    }
}
