//! Directions of the surface's own curvature, from its normal rays.

use crate::frame::memory::Memory;
use crate::frame::rows::map_rows;
use crate::frame::{Frame, PixelLines, Plane, SightLines, Vector2Planes};
use crate::kernel::simd::wide;
use crate::line::direction::fill::fill;
use crate::line::direction::fixed_direction;
use crate::line::normal_rays::LocalShape;
use crate::line::normal_rays::bundle;
use crate::line::normal_rays::bundle::{Bundle, BundlePixels, Directions, LANES, PointSource};
use crate::line::normal_rays::setting::{RaySetting, STEP_GROWTH};
use crate::plan::Plan;

/// Unit directions in the picture where covered, 0 elsewhere.
pub(crate) fn directions(
    plan: &Plan,
    frame: &Frame,
    conductance: &Plane,
    memory: &Memory,
) -> Vector2Planes {
    let surface = WalkedSurface::new(plan, frame, conductance);
    let [x, y, flat] = map_rows(&frame.mask, memory, |y, row| surface.fill_row(y, row));
    let found = filled(Vector2Planes { x, y }, &flat, frame, conductance);
    memory.recycle([flat]);
    found
}

/// Directions with those of their neighbours in pixels that have none; `flat` is 1 where the surface is a plane.
pub(crate) fn filled(
    mut directions: Vector2Planes,
    flat: &Plane,
    frame: &Frame,
    conductance: &Plane,
) -> Vector2Planes {
    let sight = SightLines::of(frame);
    fill(&mut directions, conductance, flat, &frame.mask, |x, y| {
        let at = frame.data_window.middle(x, y);
        fixed_direction(frame.normal.at(x, y), &sight, at.x, at.y)
    });
    directions
}

/// The surface that a frame shows, to be walked over.
struct WalkedSurface<'a> {
    frame: &'a Frame,
    conductance: &'a Plane,
    setting: RaySetting<'a>,
    lines: PixelLines,
    source: PointSource,
}

impl<'a> WalkedSurface<'a> {
    fn new(plan: &Plan, frame: &'a Frame, conductance: &'a Plane) -> Self {
        let setting = RaySetting::new(plan, frame);
        Self {
            frame,
            conductance,
            lines: PixelLines::new(&setting.sight, frame),
            source: PointSource {
                depth: setting.depth.map(|_| frame.source.depth_kind),
                is_perspective: setting.sight.is_perspective(),
                pixel_shape: setting.sight.pixel_shape(),
                normal_noise: setting.normal_noise,
                offset_noise: setting.offset_noise,
            },
            setting,
        }
    }

    /// Writes the directions of a row, and 1 where the surface is a plane: at the shortest step that gives a direction,
    /// else at the longest.
    fn fill_row(&self, y: usize, [to_x, to_y, flat]: [&mut [f32]; 3]) {
        for run in self.frame.mask.runs(y) {
            for row in [&mut *to_x, &mut *to_y, &mut *flat] {
                row[run.clone()].fill(0.0);
            }
        }
        let open = self.conductance.row(y);
        let covered = self.frame.mask.runs(y).flatten();
        let mut pixels: Vec<usize> = covered.filter(|&x| open[x] > 0.0).collect();
        let (mut bundle, mut found) = (Bundle::default(), Directions::default());
        let [mut step, most] = self.setting.steps_px;
        while !pixels.is_empty() {
            let mut without = Vec::new();
            for pixels in pixels.chunks(LANES) {
                for (lane, &x) in pixels.iter().enumerate() {
                    self.look_around(&mut bundle, lane, (x, y), step);
                }
                wide!(bundle::larger_curvature_directions(
                    &mut found,
                    &bundle,
                    &self.source
                ));
                for (lane, &x) in pixels.iter().enumerate() {
                    match found.forms[lane] {
                        LocalShape::Planar | LocalShape::Umbilic if step < most => without.push(x),
                        LocalShape::Planar => flat[x] = 1.0,
                        _ => (to_x[x], to_y[x]) = (found.x[lane], found.y[lane]),
                    }
                }
            }
            pixels = without;
            step = (STEP_GROWTH * step).min(most);
        }
    }

    /// Takes a pixel and those beside it into a lane: equally far on both sides, at most `most_px`, as far as the surface
    /// continues on each; on one side alone if it ends at once on the other.
    #[inline]
    fn look_around(
        &self,
        bundle: &mut Bundle,
        lane: usize,
        (x, y): (usize, usize),
        most_px: usize,
    ) {
        self.take(&mut bundle.here, lane, (x, y));
        let row = self.conductance.row(y);
        let is_open = |x: &usize| row[*x] > 0.0;
        let left = (0..x).rev().take(most_px).take_while(is_open).count();
        let right = (x + 1..row.len()).take(most_px).take_while(is_open).count();
        let is_open = |y: &usize| self.conductance.at(x, *y) > 0.0;
        let above = (0..y).rev().take(most_px).take_while(is_open).count();
        let below = (y + 1..self.conductance.height())
            .take(most_px)
            .take_while(is_open)
            .count();
        let Bundle {
            beside: [at_left, at_right, at_below, at_above],
            steps_px: [steps_x, steps_y],
            ..
        } = bundle;
        let far = |a: usize, b: usize| if a.min(b) > 0 { a.min(b) } else { a.max(b) };
        let take = |beside: &mut BundlePixels, open: usize, at: (usize, usize)| match open {
            0 => beside.is_there[lane] = 0,
            _ => self.take(beside, lane, at),
        };
        let step = far(left, right);
        take(at_left, left, (x.wrapping_sub(step), y));
        take(at_right, right, (x + step, y));
        steps_x[lane] = step as f32;
        // y points up, rows run down.
        let step = far(below, above);
        take(at_below, below, (x, y + step));
        take(at_above, above, (x, y.wrapping_sub(step)));
        steps_y[lane] = step as f32;
    }

    /// Takes a pixel into a lane.
    #[inline]
    fn take(&self, pixels: &mut BundlePixels, lane: usize, (x, y): (usize, usize)) {
        let normal = &self.frame.normal;
        for (to, plane) in pixels
            .normal
            .iter_mut()
            .zip([&normal.x, &normal.y, &normal.z])
        {
            to[lane] = plane.at(x, y);
        }
        if let Some(depth) = self.setting.depth {
            pixels.depth[lane] = depth.at(x, y);
        }
        pixels.across[lane] = self.lines.across(x..x + 1)[0];
        pixels.up[lane] = self.lines.up(y);
        pixels.is_there[lane] = 1;
    }
}
