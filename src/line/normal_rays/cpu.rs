//! Directions of the surface's own curvature, from its normal rays.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::rows::map_covered;
use crate::frame::{Frame, Plane, Vector2Planes};
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

/// The surface that a frame shows, to be walked over.
struct WalkedSurface<'a> {
    frame: &'a Frame,
    conductance: &'a Plane,
    setting: RaySetting<'a>,
}

impl<'a> WalkedSurface<'a> {
    fn new(plan: &Plan, frame: &'a Frame, conductance: &'a Plane) -> Self {
        Self {
            frame,
            conductance,
            setting: RaySetting::new(plan, frame),
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
        let normal = self.normal(x, y);
        let [mut step, most] = self.setting.steps_px;
        loop {
            let sides = [self.along_x(x, y, step), self.along_y(x, y, step)];
            let found = principal_curvatures(normal, sides, noise)?;
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
    fn along_x(&self, x: usize, y: usize, step_px: usize) -> Sides {
        let row = self.conductance.row(y);
        let open = |columns: &mut dyn Iterator<Item = usize>| {
            columns.take(step_px).take_while(|&x| row[x] > 0.0).count()
        };
        let left = open(&mut (0..x).rev());
        let right = open(&mut (x + 1..row.len()));
        self.sides((x, y), [left, right], |far| {
            [(x.wrapping_sub(far), y), (x + far, y)]
        })
    }

    /// The rays below and above a pixel (y points up), at most `step_px` away.
    fn along_y(&self, x: usize, y: usize, step_px: usize) -> Sides {
        let open = |rows: &mut dyn Iterator<Item = usize>| {
            rows.take(step_px)
                .take_while(|&y| self.conductance.at(x, y) > 0.0)
                .count()
        };
        let above = open(&mut (0..y).rev());
        let below = open(&mut (y + 1..self.conductance.height()));
        self.sides((x, y), [below, above], |far| {
            [(x, y + far), (x, y.wrapping_sub(far))]
        })
    }

    /// Rays equally far on both sides, as far as the surface continues on each; on one side alone if it ends at once on
    /// the other.
    fn sides(
        &self,
        from: (usize, usize),
        [before, after]: [usize; 2],
        at: impl Fn(usize) -> [(usize, usize); 2],
    ) -> Sides {
        let both = before.min(after);
        let step = if both > 0 { both } else { before.max(after) };
        let [minus, plus] = at(step);
        let ray = |open: usize, to| (open > 0).then(|| self.ray(from, to)).flatten();
        Sides {
            before: ray(before, minus),
            after: ray(after, plus),
            step_px: step as f64,
        }
    }

    fn ray(&self, from: (usize, usize), to: (usize, usize)) -> Option<NormalRay> {
        let (start, end) = (self.position(from.0, from.1), self.position(to.0, to.1));
        let normal = self.normal(to.0, to.1);
        let offset = match self.setting.depth {
            Some(depth) => {
                let kind = self.frame.source.depth_kind;
                let point = |at: DVec2, (x, y): (usize, usize)| {
                    self.setting
                        .sight
                        .point(at.x, at.y, f64::from(depth.at(x, y)), kind)
                };
                point(end, to) - point(start, from)
            }
            None => self
                .setting
                .sight
                .step(start, self.normal(from.0, from.1), end, normal)?,
        };
        Some(NormalRay { offset, normal })
    }

    /// The centre of a pixel in the picture.
    fn position(&self, x: usize, y: usize) -> DVec2 {
        self.frame.data_window.middle(x, y)
    }

    fn normal(&self, x: usize, y: usize) -> DVec3 {
        self.frame.normal.at(x, y)
    }
}
