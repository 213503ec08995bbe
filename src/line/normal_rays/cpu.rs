//! Directions of the surface's own curvature, from its normal rays.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::rows::map_covered;
use crate::frame::{Frame, PixelLines, Plane, Vector2Planes};
use crate::line::direction::fill::{Parts, fill};
use crate::line::normal_rays::setting::{RaySetting, STEP_GROWTH};
use crate::line::normal_rays::{
    LocalShape, Noise, NormalRay, PrincipalCurvatures, Sides, principal_curvatures,
};
use crate::plan::Plan;
use glam::{DVec2, DVec3, Vec2};

/// Unit directions in the picture where covered, 0 elsewhere.
pub(crate) fn directions(
    plan: &Plan,
    frame: &Frame,
    conductance: &Plane,
    memory: &Memory,
) -> Vector2Planes {
    let surface = WalkedSurface::new(plan, frame, conductance);
    let [x, y, flat] = map_covered(&frame.mask, memory, |y| {
        let surface = &surface;
        move |x| match surface.direction(x, y) {
            Found::Direction(t) => [t.x, t.y, 0.0],
            Found::Plane => [0.0, 0.0, 1.0],
            Found::Nothing => [0.0; 3],
        }
    });
    let mut found = Vector2Planes { x, y };
    let parts = Parts {
        conductance,
        mask: &frame.mask,
        flat: &flat,
    };
    fill(&mut found, &parts, |x, y| surface.fixed_direction(x, y));
    found
}

/// The direction of a pixel, if known.
enum Found {
    /// Unit, in the picture.
    Direction(Vec2),
    /// The surface is a plane here.
    Plane,
    /// Nothing: an edge, an umbilic, or a direction that points at the eye.
    Nothing,
}

/// What a pixel shows.
struct Seen {
    at: (usize, usize),
    normal: DVec3,
    /// Where points are taken from depth.
    point: Option<DVec3>,
}

/// The surface that a frame shows, to be walked over.
struct WalkedSurface<'a> {
    frame: &'a Frame,
    conductance: &'a Plane,
    setting: RaySetting<'a>,
    lines: PixelLines,
}

impl<'a> WalkedSurface<'a> {
    fn new(plan: &Plan, frame: &'a Frame, conductance: &'a Plane) -> Self {
        let setting = RaySetting::new(plan, frame);
        Self {
            frame,
            conductance,
            lines: PixelLines::new(&setting.sight, frame),
            setting,
        }
    }

    fn direction(&self, x: usize, y: usize) -> Found {
        if self.conductance.at(x, y) == 0.0 {
            return Found::Nothing;
        }
        let Some(curvatures) = self.curvatures(x, y) else {
            return Found::Nothing;
        };
        let at = self.position(x, y);
        let seen = |tangent| self.setting.sight.picture_direction(at.x, at.y, tangent);
        match (curvatures.form, curvatures.direction().and_then(seen)) {
            (LocalShape::Planar, _) => Found::Plane,
            (_, Some(direction)) => Found::Direction(direction.as_vec2()),
            (_, None) => Found::Nothing,
        }
    }

    /// The curvatures at the shortest step that gives a direction, else at the longest.
    fn curvatures(&self, x: usize, y: usize) -> Option<PrincipalCurvatures> {
        let offset = self.setting.depth.map_or(0.0, |depth| {
            self.setting.offset_noise * f64::from(depth.at(x, y))
        });
        let noise = Noise {
            normal: self.setting.normal_noise,
            offset,
        };
        let here = Seen {
            at: (x, y),
            normal: self.normal(x, y),
            point: self.point(x, y),
        };
        let [mut step, most] = self.setting.steps_px;
        loop {
            let sides = [self.along_x(&here, step), self.along_y(&here, step)];
            let found = principal_curvatures(here.normal, sides, noise)?;
            if found.direction().is_some() || step >= most {
                return Some(found);
            }
            step = (STEP_GROWTH * step).min(most);
        }
    }

    fn fixed_direction(&self, x: usize, y: usize) -> Vec2 {
        let at = self.position(x, y);
        crate::line::direction::fixed_direction(self.normal(x, y), &self.setting.sight, at.x, at.y)
    }

    /// The rays left and right of a pixel, at most `step_px` away.
    fn along_x(&self, here: &Seen, step_px: usize) -> Sides {
        let (x, y) = here.at;
        let row = self.conductance.row(y);
        let is_open = |x: &usize| row[*x] > 0.0;
        let left = (0..x).rev().take(step_px).take_while(is_open).count();
        let right = (x + 1..row.len()).take(step_px).take_while(is_open).count();
        self.sides(here, [left, right], |far| {
            [(x.wrapping_sub(far), y), (x + far, y)]
        })
    }

    /// The rays below and above a pixel (y points up), at most `step_px` away.
    fn along_y(&self, here: &Seen, step_px: usize) -> Sides {
        let (x, y) = here.at;
        let is_open = |y: &usize| self.conductance.at(x, *y) > 0.0;
        let height = self.conductance.height();
        let above = (0..y).rev().take(step_px).take_while(is_open).count();
        let below = (y + 1..height).take(step_px).take_while(is_open).count();
        self.sides(here, [below, above], |far| {
            [(x, y + far), (x, y.wrapping_sub(far))]
        })
    }

    /// Rays equally far on both sides, as far as the surface continues on each; on one side alone if it ends at once on
    /// the other.
    #[inline(always)]
    fn sides(
        &self,
        here: &Seen,
        [before, after]: [usize; 2],
        at: impl Fn(usize) -> [(usize, usize); 2],
    ) -> Sides {
        let both = before.min(after);
        let step = if both > 0 { both } else { before.max(after) };
        let [minus, plus] = at(step);
        let ray = |open: usize, to| if open > 0 { self.ray(here, to) } else { None };
        Sides {
            before: ray(before, minus),
            after: ray(after, plus),
            step_px: step as f64,
        }
    }

    #[inline(always)]
    fn ray(&self, here: &Seen, (x, y): (usize, usize)) -> Option<NormalRay> {
        let normal = self.normal(x, y);
        let offset = match (self.point(x, y), here.point) {
            (Some(point), Some(own)) => point - own,
            _ => {
                let [start, end] = [here.at, (x, y)].map(|(x, y)| self.position(x, y));
                self.setting.sight.step(start, here.normal, end, normal)?
            }
        };
        Some(NormalRay { offset, normal })
    }

    /// The point seen at a pixel, where points are taken from depth.
    #[inline]
    fn point(&self, x: usize, y: usize) -> Option<DVec3> {
        let depth = self.setting.depth?;
        let kind = self.frame.source.depth_kind;
        Some(self.lines.point(x, y, f64::from(depth.at(x, y)), kind))
    }

    /// The centre of a pixel in the picture.
    fn position(&self, x: usize, y: usize) -> DVec2 {
        self.frame.data_window.middle(x, y)
    }

    fn normal(&self, x: usize, y: usize) -> DVec3 {
        self.frame.normal.at(x, y)
    }
}
