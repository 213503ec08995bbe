//! The tracer: sight lines of a frame, bent by its specular surfaces, and their hits.

use super::{DistanceMap, Reached, SeenSurface, VisibleSurface};
use crate::frame::{Camera, Frame, Ray, SightLines, SpecularScene};
use crate::params::{Bend, SearchParams, SpecularParams};
use glam::{DQuat, DVec2, DVec3};

/// The path of a sight line through a specular object, in view space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    /// Unit direction of the sight line, away from the eye.
    pub sight: DVec3,
    /// Distance from the eye, or the plane of an orthographic camera, to the surface.
    pub length: f64,
    /// The ray from the visible surface on: leaving, or inside the object.
    pub entry: Ray,
    /// The ray that leaves through the back faces, if there are two refractions.
    pub exit: Option<Ray>,
    /// Unit normal of the visible surface.
    pub normal: DVec3,
    bend: Bend,
}

impl Path {
    /// The ray that leaves the object; its direction is a unit vector.
    pub fn leaving(&self) -> Ray {
        self.exit.unwrap_or(self.entry)
    }

    /// Length of the path from the eye to the point where the ray leaves.
    pub fn length_inside(&self) -> f64 {
        let inside = self
            .exit
            .map_or(0.0, |exit| exit.start.distance(self.entry.start));
        self.length + inside
    }

    /// Transforms a direction at the hit of the leaving ray to its apparent orientation: a flat mirror shows its image
    /// behind it, mirrored.
    pub fn as_it_appears(&self, direction: DVec3) -> DVec3 {
        match self.bend {
            Bend::Mirror => direction.reflect(self.normal),
            Bend::Glass { .. } | Bend::Straight => {
                DQuat::from_rotation_arc(self.leaving().direction, self.sight) * direction
            }
        }
    }
}

/// The hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The point, in view space.
    pub point: DVec3,
    /// The unit normal there, facing the ray's origin.
    pub normal: DVec3,
    /// The surface hit.
    pub surface: HitSurface,
    /// Whether the point is visible; otherwise it lies on an extension of the neighbouring surface.
    pub is_seen: bool,
}

/// The surface that a ray hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HitSurface {
    /// The scene behind, at this position in its picture.
    Behind(DVec2),
    /// The surroundings, at this point of world space.
    Surroundings(DVec3),
}

/// Length of a filtered normal below which it mixes two surfaces, as at a rim, and reflects like neither: the length
/// for normals 23 degrees apart.
const MIXED: f32 = 0.98;

/// Bends and traces the sight lines of a frame.
#[derive(Debug)]
pub struct Tracer<'a> {
    frame: &'a Frame,
    scene: &'a SpecularScene,
    sight: SightLines,
    front: VisibleSurface<'a>,
    back: Option<SeenSurface<'a>>,
    behind: Option<SeenSurface<'a>>,
    around: Option<(DistanceMap<'a>, Camera)>,
    bend: Bend,
    search: SearchParams,
}

impl<'a> Tracer<'a> {
    /// A tracer over `frame`. `None` without a camera, or without depth that is a distance.
    pub fn new(
        frame: &'a Frame,
        scene: &'a SpecularScene,
        params: &SpecularParams,
    ) -> Option<Self> {
        let camera = frame.camera?;
        let sight = SightLines::new(camera.projection);
        let surface = |layer: &'a Option<Frame>| SeenSurface::new(layer.as_ref()?, sight);
        Some(Self {
            frame,
            scene,
            sight,
            front: VisibleSurface::new(frame, sight)?,
            back: surface(&scene.back),
            behind: surface(&scene.behind),
            around: scene
                .surroundings
                .as_ref()
                .map(|around| (DistanceMap::new(around), camera)),
            bend: params.bend,
            search: params.search,
        })
    }

    /// The scene behind, if it is known.
    pub(crate) fn behind(&self) -> Option<&SeenSurface<'a>> {
        self.behind.as_ref()
    }

    /// The map of the surroundings, if they are known.
    pub(crate) fn around(&self) -> Option<&DistanceMap<'a>> {
        self.around.as_ref().map(|(map, _)| map)
    }

    /// The surface of the frame itself.
    pub(crate) fn front(&self) -> &VisibleSurface<'a> {
        &self.front
    }

    /// The path of a pixel's sight line through the specular object it shows. `None` if it shows none or a rim, is seen
    /// from behind, at total internal reflection, or if the back faces are not hit.
    pub fn path(&self, x: usize, y: usize) -> Option<Path> {
        self.path_bent(x, y, self.bend)
    }

    /// The same with another way of bending.
    pub fn path_bent(&self, x: usize, y: usize, bend: Bend) -> Option<Path> {
        if !self.scene.is_specular(self.frame, x, y) {
            return None;
        }
        let at = self.front.middle(x, y);
        let (start, line) = self.sight.line(at.x, at.y);
        let sight = line.normalize();
        let point = self.front.point(x, y);
        let normal = self.front.normal(x, y);
        let faces = normal.dot(sight) < 0.0;
        let lengths = self.frame.normal_length.as_ref();
        let is_mixed = lengths.is_some_and(|lengths| lengths.at(x, y) < MIXED);
        if !faces || is_mixed {
            return None;
        }
        let (direction, exit) = match bend {
            Bend::Mirror => (sight.reflect(normal), None),
            Bend::Straight => (sight, None),
            Bend::Glass { ior } => {
                let ior = f64::from(ior);
                let inside = refracted(sight, normal, 1.0 / ior)?;
                let entry = Ray {
                    start: point,
                    direction: inside,
                };
                match &self.back {
                    Some(back) => (inside, Some(self.left(back, &entry, ior)?)),
                    None => (inside, None),
                }
            }
        };
        Some(Path {
            sight,
            length: point.distance(start),
            entry: Ray {
                start: point,
                direction,
            },
            exit,
            normal,
            bend,
        })
    }

    /// The ray that leaves through the back faces.
    fn left(&self, back: &SeenSurface, inside: &Ray, ior: f64) -> Option<Ray> {
        let Reached::Seen(point, at) = back.reached(inside, &self.search)? else {
            return None;
        };
        let normal = back.normal_at(at, point)?;
        let against = if normal.dot(inside.direction) > 0.0 {
            -normal
        } else {
            normal
        };
        Some(Ray {
            start: point,
            direction: refracted(inside.direction, against, ior)?,
        })
    }

    /// The hit of a ray: visible in the scene behind, else in the surroundings; else on an unseen extension of either.
    pub fn hit(&self, ray: &Ray) -> Option<Hit> {
        let behind = self.hit_behind(ray);
        if behind.is_some_and(|hit| hit.is_seen) {
            return behind;
        }
        let around = self.hit_around(ray);
        match around.is_some_and(|hit| hit.is_seen) {
            true => around,
            false => behind.or(around),
        }
    }

    fn hit_behind(&self, ray: &Ray) -> Option<Hit> {
        let surface = self.behind.as_ref()?;
        let (point, at, is_seen) = parts(surface.reached(ray, &self.search)?);
        let shown = if is_seen {
            point
        } else {
            surface.point_at(at)?
        };
        Some(Hit {
            point,
            normal: against(surface.normal_at(at, shown)?, ray.direction),
            surface: HitSurface::Behind(at),
            is_seen,
        })
    }

    fn hit_around(&self, ray: &Ray) -> Option<Hit> {
        let (map, camera) = self.around.as_ref()?;
        let world_from_view = camera.view_from_world.inverse();
        let ray_in_world = Ray {
            start: world_from_view.transform_point3(ray.start),
            direction: world_from_view.transform_vector3(ray.direction),
        };
        let (world, shown, is_seen) = parts(map.reached(&ray_in_world, &self.search)?);
        let normal = camera
            .view_from_world
            .transform_vector3(map.normal_at(shown)?);
        Some(Hit {
            point: camera.view_from_world.transform_point3(world),
            normal: against(normal, ray.direction),
            surface: HitSurface::Surroundings(shown),
            is_seen,
        })
    }

    /// The colour at the hit, if that is visible and has one.
    pub fn color(&self, hit: &Hit) -> Option<[f32; 3]> {
        if !hit.is_seen {
            return None;
        }
        match hit.surface {
            HitSurface::Behind(at) => {
                let surface = self.behind.as_ref()?;
                let color = surface.frame().color.as_ref()?;
                surface.color_at(color, at, hit.point)
            }
            HitSurface::Surroundings(world) => {
                let (map, _) = self.around.as_ref()?;
                map.color_at(map.surroundings().color.as_ref()?, world)
            }
        }
    }
}

/// `direction` refracted at a surface with the unit normal `against` it, with the ratio `eta` of the indices before and
/// behind; a unit vector. `None` for total reflection.
#[inline]
fn refracted(direction: DVec3, against: DVec3, eta: f64) -> Option<DVec3> {
    let refracted = direction.refract(against, eta);
    (refracted != DVec3::ZERO).then_some(refracted)
}

fn parts<P>(reached: Reached<P>) -> (DVec3, P, bool) {
    match reached {
        Reached::Seen(point, shown) => (point, shown, true),
        Reached::Beyond(point, shown) => (point, shown, false),
    }
}

fn against(normal: DVec3, direction: DVec3) -> DVec3 {
    if normal.dot(direction) > 0.0 {
        -normal
    } else {
        normal
    }
}
