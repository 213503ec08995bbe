//! The pixels of a frame seen through mirrors and lenses, with the hit points written by a renderer.

use crate::frame::memory::Memory;
use crate::frame::{Frame, SURFACE_JUMP, SightLines, SpecularScene, Vector3Planes, step_between};
use crate::line::linear_camera::seen_by_steps;
use crate::line::normal_rays::{Noise, NormalRay, Sides, principal_curvatures};
use crate::line::specular::seen::SeenPixel;
use crate::line::specular::tangents::Tangents;
use crate::trace::{Hit, HitSurface, VisibleSurface};
use glam::{DQuat, DVec2, DVec3, Vec2};
use rayon::prelude::*;

/// Largest distance of a point from a surface it belongs to, as a share of the distance.
const ON_SURFACE: f64 = 0.01;

/// All pixels with a known hit point, row by row.
pub(crate) fn hit_pixels(
    frame: &Frame,
    scene: &SpecularScene,
    points: &Vector3Planes,
    tangents: &Tangents,
    memory: &Memory,
) -> Vec<SeenPixel> {
    let points = HitPoints {
        frame,
        scene,
        points,
        front: *tangents.tracer.front(),
        sight: SightLines::new(tangents.camera.projection),
    };
    let height = frame.mask.height();
    let rows: Vec<Vec<SeenPixel>> = (0..height)
        .into_par_iter()
        .filter(|_| !memory.is_cancelled())
        .map(|y| {
            let row = frame.mask.runs(y).flatten();
            row.filter_map(|x| points.pixel(x, y, tangents)).collect()
        })
        .collect();
    rows.concat()
}

struct HitPoints<'a> {
    frame: &'a Frame,
    scene: &'a SpecularScene,
    points: &'a Vector3Planes,
    front: VisibleSurface<'a>,
    sight: SightLines,
}

impl HitPoints<'_> {
    /// The point that a pixel shows.
    fn point(&self, x: usize, y: usize) -> Option<DVec3> {
        self.points.x.get(x, y)?;
        let is_specular = self.scene.is_specular(self.frame, x, y);
        Some(self.points.at(x, y)).filter(|point| is_specular && point.is_finite())
    }

    /// Change of the point from pixel to pixel to the right and up.
    fn steps(&self, x: usize, y: usize) -> Option<[DVec3; 2]> {
        let here = self.point(x, y)?;
        Some([
            step_between(self.point(x.wrapping_sub(1), y), here, self.point(x + 1, y))?,
            step_between(self.point(x, y + 1), here, self.point(x, y.wrapping_sub(1)))?,
        ])
    }

    /// The unit normal of the surface seen, toward the specular surface.
    fn normal(&self, x: usize, y: usize) -> Option<DVec3> {
        let [right, up] = self.steps(x, y)?;
        let normal = right.cross(up).try_normalize()?;
        let toward = self.front.point(x, y) - self.point(x, y)?;
        Some(if normal.dot(toward) < 0.0 {
            -normal
        } else {
            normal
        })
    }

    fn pixel(&self, x: usize, y: usize, tangents: &Tangents) -> Option<SeenPixel> {
        let (point, steps) = (self.point(x, y)?, self.steps(x, y)?);
        let normal = self.normal(x, y)?;
        let own = self.curvature(x, y, normal);
        let mut directions = [Vec2::ZERO; 2];
        for (order, direction) in directions[..tangents.families.len()].iter_mut().enumerate() {
            let tangent = self
                .on_known_surface(point, normal, tangents)
                .and_then(|hit| tangents.at(&hit, order))
                .unwrap_or_else(|| match own {
                    Some(larger) => tangents.of_family(larger, normal, order),
                    None => tangents.fallback(normal, order),
                });
            let seen = seen_by_steps(steps, tangent).unwrap_or(DVec2::ZERO);
            *direction = seen.as_vec2();
        }
        let at = self.front.middle(x, y);
        let (start, line) = self.sight.line(at.x, at.y);
        let sight = line.normalize();
        let surface = self.front.point(x, y);
        let length = surface.distance(start) + point.distance(surface);
        let turn = DQuat::from_rotation_arc((point - surface).try_normalize()?, sight);
        Some(SeenPixel {
            x,
            y,
            normal: (turn * normal).as_vec3(),
            depth: (-sight.z * length) as f32,
            directions,
        })
    }

    /// The point as a hit on the surface behind or around, if it is on one of them.
    fn on_known_surface(&self, point: DVec3, normal: DVec3, tangents: &Tangents) -> Option<Hit> {
        let hit = |surface| Hit {
            point,
            normal,
            surface,
            is_seen: true,
        };
        let behind = tangents.tracer.behind().and_then(|surface| {
            let at = self.sight.projection().pixel_of(point)?;
            let depth = surface.depth_at_place(at)?;
            let is_on = (depth / -point.z - 1.0).abs() < ON_SURFACE;
            is_on.then_some(hit(HitSurface::Behind(at)))
        });
        behind.or_else(|| {
            let map = tangents.tracer.around()?;
            let world_from_view = tangents.camera.view_from_world.inverse();
            let world = world_from_view.transform_point3(point);
            let distance = map.distance_of(world)?;
            let own = world.distance(map.surroundings().center);
            let is_on = (distance / own - 1.0).abs() < ON_SURFACE;
            is_on.then_some(hit(HitSurface::Surroundings(world)))
        })
    }

    /// The direction of the larger curvature of the surface seen, from its points alone.
    fn curvature(&self, x: usize, y: usize, normal: DVec3) -> Option<DVec3> {
        let here = self.point(x, y)?;
        let [right, up] = self.steps(x, y)?;
        let ray = |x: usize, y: usize, step: DVec3| {
            let offset = self.point(x, y)? - here;
            let goes_on = offset.length() < SURFACE_JUMP * step.length();
            let normal = self.normal(x, y).filter(|_| goes_on)?;
            Some(NormalRay::new(offset, normal))
        };
        let sides = [
            Sides::of(
                [ray(x.wrapping_sub(1), y, right), ray(x + 1, y, right)],
                1.0,
            ),
            Sides::of([ray(x, y + 1, up), ray(x, y.wrapping_sub(1), up)], 1.0),
        ];
        // A step between two points is off by their rounding, and a normal by that over the step.
        let offset = f64::from(f32::EPSILON) * here.length();
        let noise = Noise {
            normal: offset / right.length().min(up.length()),
            offset,
        };
        principal_curvatures(normal, sides, noise).direction()
    }
}
