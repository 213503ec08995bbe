//! Stroke directions in space on the surfaces seen in specular pixels.

use crate::frame::{Camera, SightLines, Vector2Planes, Vector3Planes};
use crate::line::direction::fixed_tangents;
use crate::params::Fallback;
use crate::trace::{Hit, HitSurface, Tracer};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// The directions on everything that a trace may meet.
pub(crate) struct Tangents<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) camera: Camera,
    /// On the surface behind: the strokes drawn there, one field for each of the directions wanted.
    pub(crate) behind: Vec<Vector2Planes>,
    /// On the surroundings: the direction of the curvature larger in magnitude, in world space; 0 for none.
    pub(crate) around: Option<Arc<Vector3Planes>>,
    /// The directions wanted: of the larger curvature, 0, or the lesser, 1.
    pub(crate) families: Vec<usize>,
    pub(crate) fallback: Fallback,
}

impl Tangents<'_> {
    /// The tangent at a hit for strokes of the direction wanted with this `order`; of any length.
    pub(crate) fn at(&self, hit: &Hit, order: usize) -> Option<DVec3> {
        match hit.surface {
            HitSurface::Behind(at) => {
                let surface = self.tracer.behind()?;
                let shown = match hit.is_seen {
                    true => hit.point,
                    false => surface.point_at(at)?,
                };
                let direction = surface.direction_at(&self.behind[order], at, shown)?;
                let sight = SightLines::new(self.camera.projection);
                sight.tangent(at.x, at.y, direction, hit.normal)
            }
            HitSurface::Surroundings(world) => {
                let map = self.tracer.around()?;
                let found = map.direction_at(self.around.as_ref()?, world);
                Some(match found {
                    Some(larger) => {
                        let larger = self.camera.view_from_world.transform_vector3(larger);
                        let along = larger - larger.dot(hit.normal) * hit.normal;
                        self.of_family(along, hit.normal, order)
                    }
                    None => self.fallback(hit.normal, order),
                })
            }
        }
    }

    /// The direction wanted in this order, from that of the larger curvature.
    pub(crate) fn of_family(&self, larger: DVec3, normal: DVec3, order: usize) -> DVec3 {
        match self.families[order] {
            0 => larger,
            _ => normal.cross(larger),
        }
    }

    /// On a plane that curvature does not lead: the angle of the fallback from a horizontal, or upright; a second
    /// direction at right angles to the first.
    pub(crate) fn fallback(&self, normal: DVec3, order: usize) -> DVec3 {
        let up = fixed_tangents(normal).next().unwrap_or(DVec3::Y);
        let up = if up.y < 0.0 { -up } else { up };
        let right = up.cross(normal);
        let first = match self.fallback {
            Fallback::Angle(degrees) => DVec2::from_angle(f64::from(degrees).to_radians()),
            Fallback::Surface => DVec2::Y,
        };
        let direction = if order == 0 { first } else { first.perp() };
        direction.x * right + direction.y * up
    }
}
