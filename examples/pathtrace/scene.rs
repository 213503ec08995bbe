//! Objects, their materials, and the light on them.

use super::geometry::{Form, Hit, Ray, Shape};
use super::light::{AreaLight, Lights};
use super::material::Material;
use super::mesh::Mesh;
use super::mesh_curvature::outer;
use super::tree::Tree;
use glam::{Mat3, Vec3};

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
    tree: Tree,
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
    pub(crate) fn mesh(mut self, mesh: Mesh, material: Material) -> Self {
        let object = self.objects.len();
        let shapes = mesh.forms().map(|form| Shape::new(form, object));
        self.shapes.extend(shapes);
        self.object(material, Vec3::ZERO, Some(mesh), None)
    }

    pub(crate) fn sphere(self, center: Vec3, radius: f32, material: Material) -> Self {
        self.shining_sphere(center, radius, material, Vec3::ZERO)
    }

    pub(crate) fn shining_sphere(
        mut self,
        center: Vec3,
        radius: f32,
        material: Material,
        emission: Vec3,
    ) -> Self {
        let form = Form::Sphere { center, radius };
        self.shapes.push(Shape::new(form, self.objects.len()));
        self.object(material, emission, None, None)
    }

    #[cfg(test)]
    pub(crate) fn rectangle(
        mut self,
        corner: Vec3,
        sides: [Vec3; 2],
        material: Material,
        emission: Vec3,
    ) -> Self {
        let form = Form::Rectangle { corner, sides };
        self.shapes.push(Shape::new(form, self.objects.len()));
        self.object(material, emission, None, None)
    }

    pub(crate) fn area_light(mut self, light: AreaLight) -> Self {
        let form = Form::Rectangle {
            corner: light.corner,
            sides: light.sides,
        };
        self.shapes.push(Shape::new(form, self.objects.len()));
        self.lights.areas.push(light);
        let which = self.lights.areas.len() - 1;
        self.object(Material::Matte(Vec3::ZERO), Vec3::ZERO, None, Some(which))
    }

    pub(crate) fn surroundings(mut self, light: relievo::light::environment::Environment) -> Self {
        self.lights.surroundings = super::light::Surroundings::new(light);
        self
    }

    fn object(
        mut self,
        material: Material,
        emission: Vec3,
        mesh: Option<Mesh>,
        area_light: Option<usize>,
    ) -> Self {
        self.objects.push(Object {
            material,
            emission,
            mesh,
            area_light,
        });
        self
    }

    pub(crate) fn build(self) -> Scene {
        Scene {
            objects: self.objects,
            lights: self.lights,
            tree: Tree::new(self.shapes),
        }
    }
}

impl Scene {
    /// The first surface that a ray meets.
    #[inline]
    pub(crate) fn met(&self, ray: &Ray) -> Option<(Point<'_>, f32)> {
        let hit = self.tree.nearest(ray)?;
        Some((self.point(ray, &hit), hit.distance))
    }

    /// Whether the ray is unobstructed up to `distance`.
    #[inline]
    pub(crate) fn is_open(&self, ray: &Ray, distance: f32) -> bool {
        !self.tree.is_blocked(ray, distance * (1.0 - CLEARANCE))
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> Point<'_> {
        let shape = self.tree.shape(hit);
        let object = &self.objects[shape.object as usize];
        let mut position = ray.at(hit.distance);
        let (face_normal, normal, turn) = match shape.form {
            Form::Sphere { center, radius } => {
                let normal = (position - center).normalize();
                // Back onto the sphere, off which rounding along a long ray brings it.
                position = center + radius * normal;
                let tangents = Mat3::IDENTITY - outer(normal, normal);
                (normal, normal, tangents * (1.0 / radius))
            }
            Form::Triangle { sides, face, .. } => {
                let face_normal = sides[0].cross(sides[1]).normalize();
                match &object.mesh {
                    Some(mesh) => {
                        let (normal, turn) = mesh.at(face, hit.uv);
                        (face_normal, normal, turn)
                    }
                    None => (face_normal, face_normal, Mat3::ZERO),
                }
            }
            Form::Rectangle { sides, .. } => {
                let normal = sides[0].cross(sides[1]).normalize();
                (normal, normal, Mat3::ZERO)
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
