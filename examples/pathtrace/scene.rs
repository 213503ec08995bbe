//! Objects, their materials, and the light on them.

use super::geometry::{Form, Ray, Shape};
use super::light::{AreaLight, Lights, Surroundings};
use super::material::Material;
use super::mesh::{Mesh, outer};
use glam::{Mat3, Vec3};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{BvhBuildParams, ray};
use relievo::light::environment::Environment;
use std::time::Duration;

/// Offset from the surface of rays that leave it, as a share of the point's coordinates.
const CLEARANCE: f32 = 1e-4;

/// Something in the scene.
pub(crate) struct Object {
    pub(crate) material: Material,
    /// Radiance emitted in all directions.
    pub(crate) emission: Vec3,
    mesh: Option<Mesh>,
    /// Index of its light; area lights are both hit by chance and sampled.
    area_light: Option<usize>,
}

/// A scene, ready to be rendered.
pub(crate) struct Scene {
    objects: Vec<Object>,
    pub(crate) lights: Lights,
    tree: Bvh2,
    /// In the order of the tree.
    shapes: Vec<Shape>,
}

/// A point on a surface, seen from outside it or from inside.
#[derive(Clone, Copy)]
pub(crate) struct Point<'a> {
    pub(crate) position: Vec3,
    /// Unit normal, smooth over the triangles, on the side that is seen.
    pub(crate) normal: Vec3,
    /// Unit normal of the triangle itself, on the side that is seen.
    pub(crate) face_normal: Vec3,
    /// Turn of the normal for a step along the surface, positive if convex.
    pub(crate) turn: Mat3,
    /// Whether it is seen from inside.
    pub(crate) inside: bool,
    pub(crate) object: &'a Object,
}

/// Builder of a scene, object by object.
#[derive(Default)]
pub(crate) struct SceneBuilder {
    objects: Vec<Object>,
    shapes: Vec<Shape>,
    lights: Lights,
}

impl SceneBuilder {
    pub(crate) fn mesh(self, mesh: Mesh, material: Material) -> Self {
        let forms: Vec<Form> = mesh.forms().collect();
        self.object(&forms, material, Some(mesh))
    }

    pub(crate) fn sphere(self, center: Vec3, radius: f32, material: Material) -> Self {
        self.object(&[Form::Sphere { center, radius }], material, None)
    }

    pub(crate) fn area_light(mut self, light: AreaLight) -> Self {
        self.lights.areas.push(light);
        let mesh = Mesh::rectangle(light.corner, light.sides);
        let mut builder = self.mesh(mesh, Material::Matte(Vec3::ZERO));
        let which = builder.lights.areas.len() - 1;
        builder.objects.last_mut().expect("its own").area_light = Some(which);
        builder
    }

    pub(crate) fn surroundings(mut self, light: Environment) -> Self {
        self.lights.surroundings = Surroundings::new(light);
        self
    }

    fn object(mut self, forms: &[Form], material: Material, mesh: Option<Mesh>) -> Self {
        let object = self.objects.len();
        let shapes = forms.iter().map(|&form| Shape { form, object });
        self.shapes.extend(shapes);
        self.objects.push(Object {
            material,
            emission: Vec3::ZERO,
            mesh,
            area_light: None,
        });
        self
    }

    /// Lets the last object emit light.
    #[cfg(test)]
    pub(crate) fn shining(mut self, emission: Vec3) -> Self {
        self.objects.last_mut().expect("an object").emission = emission;
        self
    }

    pub(crate) fn build(self) -> Scene {
        let mut took = Duration::ZERO;
        let tree = build_bvh2(&self.shapes, BvhBuildParams::fast_build(), &mut took);
        let in_order = tree.primitive_indices.iter();
        Scene {
            shapes: in_order.map(|&i| self.shapes[i as usize]).collect(),
            objects: self.objects,
            lights: self.lights,
            tree,
        }
    }
}

/// The ray as the tree takes it, up to `distance`.
fn bounded(ray: &Ray, distance: f32) -> ray::Ray {
    ray::Ray::new(ray.origin.into(), ray.direction.into(), 0.0, distance)
}

impl Scene {
    /// The first surface that a ray meets, and how far away it is.
    #[inline]
    pub(crate) fn met(&self, ray: &Ray) -> Option<(Point<'_>, f32)> {
        let mut hit = ray::RayHit::none();
        let whole = bounded(ray, f32::INFINITY);
        let along = |_: &ray::Ray, shape| self.distance(ray, shape);
        self.tree.ray_traverse(whole, &mut hit, along);
        let shape = self.shapes.get(hit.primitive_id as usize)?;
        let (distance, uv) = shape.form.met(ray)?;
        Some((self.point(ray, shape, distance, uv), distance))
    }

    /// Whether the ray is unobstructed up to `distance`.
    #[inline]
    pub(crate) fn is_open(&self, ray: &Ray, distance: f32) -> bool {
        let part = bounded(ray, distance * (1.0 - CLEARANCE));
        let along = |_: &ray::Ray, shape| self.distance(ray, shape);
        self.tree.ray_traverse_miss(part, along)
    }

    fn distance(&self, ray: &Ray, shape: usize) -> f32 {
        let met = self.shapes[shape].form.met(ray);
        met.map_or(f32::INFINITY, |(distance, _)| distance)
    }

    fn point(&self, ray: &Ray, shape: &Shape, distance: f32, uv: [f32; 2]) -> Point<'_> {
        let object = &self.objects[shape.object];
        let mut position = ray.origin + distance * ray.direction;
        let (face_normal, normal, turn) = match shape.form {
            Form::Sphere { center, radius } => {
                let normal = (position - center).normalize();
                // Back onto the sphere, off which rounding along a long ray brings it.
                position = center + radius * normal;
                let tangents = Mat3::IDENTITY - outer(normal, normal);
                (normal, normal, tangents * (1.0 / radius))
            }
            Form::Triangle { sides, face, .. } => {
                let mesh = object.mesh.as_ref().expect("triangles are of a mesh");
                let (normal, turn) = mesh.at(face, uv);
                (sides[0].cross(sides[1]).normalize(), normal, turn)
            }
        };
        let inside = face_normal.dot(ray.direction) > 0.0;
        let side = if inside { -1.0 } else { 1.0 };
        Point {
            position,
            normal: facing(side * normal, -ray.direction),
            face_normal: side * face_normal,
            turn: turn * side,
            inside,
            object,
        }
    }

    /// Radiance emitted by the object itself at `point`; area lights emit on their outer side only.
    pub(crate) fn emitted(&self, point: &Point) -> Vec3 {
        match point.object.area_light {
            Some(_) if point.inside => Vec3::ZERO,
            Some(which) => self.lights.areas[which].radiance,
            None => point.object.emission,
        }
    }

    /// Density with which [`Lights::sample`] would have found the light hit there; `None` if it never would.
    pub(crate) fn light_density(&self, met: Option<(&Point, f32)>, direction: Vec3) -> Option<f32> {
        let density = match met {
            Some((point, distance)) => {
                let light = &self.lights.areas[point.object.area_light?];
                light.density(direction, distance)
            }
            None => self.lights.surroundings.as_ref()?.density(direction),
        };
        Some(density * self.lights.share())
    }
}

/// Least cosine with the line of sight of a smooth normal: triangles at the rim of a shape may face the eye
/// though the smooth surface does not.
const LEAST_FACING: f32 = 1e-3;

/// The unit normal, tilted just enough to face `to_eye`.
fn facing(normal: Vec3, to_eye: Vec3) -> Vec3 {
    let cosine = normal.dot(to_eye);
    if cosine >= LEAST_FACING {
        normal
    } else {
        (normal + (LEAST_FACING - cosine) * to_eye).normalize_or(to_eye)
    }
}

impl Point<'_> {
    /// A ray that leaves the surface on the side of `direction`.
    #[inline]
    pub(crate) fn leaving(&self, direction: Vec3) -> Ray {
        let clearance = CLEARANCE * self.position.abs().max_element().max(1.0);
        let side = if self.face_normal.dot(direction) < 0.0 {
            -clearance
        } else {
            clearance
        };
        Ray {
            origin: self.position + side * self.face_normal,
            direction,
        }
    }
}
