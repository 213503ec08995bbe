//! Rays and the shapes they meet.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use glam::Vec3;

/// A half line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Unit vector.
    pub(crate) direction: Vec3,
}

impl Ray {
    pub(crate) fn at(&self, distance: f32) -> Vec3 {
        self.origin + distance * self.direction
    }
}

/// Intersection of a ray with a shape.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hit {
    pub(crate) distance: f32,
    /// For a triangle, the weights of its second and third corner; for a rectangle, the position along its sides.
    pub(crate) uv: [f32; 2],
    /// Which shape of the tree.
    pub(crate) shape: u32,
}

/// Geometry of a shape.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Form {
    Triangle {
        corner: Vec3,
        /// Vectors from the corner to the other two.
        sides: [Vec3; 2],
        /// Which triangle of its mesh.
        face: u32,
    },
    Sphere {
        center: Vec3,
        radius: f32,
    },
    /// A parallelogram.
    Rectangle {
        corner: Vec3,
        sides: [Vec3; 2],
    },
}

/// A form that belongs to an object of the scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape {
    pub(crate) form: Form,
    pub(crate) object: u32,
    /// Index in the tree, while it is built.
    node: u32,
}

impl Shape {
    pub(crate) fn new(form: Form, object: usize) -> Self {
        Self {
            form,
            object: object as u32,
            node: 0,
        }
    }
}

impl Form {
    /// Distance along the ray, within the given limits, and position on the form.
    #[inline]
    pub(crate) fn met(&self, ray: &Ray, nearest: f32, farthest: f32) -> Option<(f32, [f32; 2])> {
        let (distance, uv) = match *self {
            Self::Triangle { corner, sides, .. } => {
                let (t, [u, v]) = plane_met(ray, corner, sides)?;
                (u + v <= 1.0).then_some((t, [u, v]))?
            }
            Self::Rectangle { corner, sides } => {
                let (t, [u, v]) = plane_met(ray, corner, sides)?;
                (u <= 1.0 && v <= 1.0).then_some((t, [u, v]))?
            }
            Self::Sphere { center, radius } => {
                (sphere_met(ray, center, radius, nearest)?, [0.0; 2])
            }
        };
        (distance > nearest && distance < farthest).then_some((distance, uv))
    }

    fn bounds(&self) -> [Vec3; 2] {
        match *self {
            Self::Triangle { corner, sides, .. } => {
                let [b, c] = sides.map(|side| corner + side);
                [corner.min(b).min(c), corner.max(b).max(c)]
            }
            Self::Sphere { center, radius } => [center - radius, center + radius],
            Self::Rectangle {
                corner,
                sides: [a, b],
            } => {
                let corners = [corner, corner + a, corner + b, corner + a + b];
                [
                    corners.into_iter().fold(corner, Vec3::min),
                    corners.into_iter().fold(corner, Vec3::max),
                ]
            }
        }
    }
}

/// Distance of the intersection of a ray with the quadrant spanned by `sides`, and its position in sides (T. Moeller,
/// B. Trumbore: Fast, Minimum Storage Ray/Triangle Intersection, 1997).
#[inline]
fn plane_met(ray: &Ray, corner: Vec3, [a, b]: [Vec3; 2]) -> Option<(f32, [f32; 2])> {
    let across = ray.direction.cross(b);
    let inverse = 1.0 / a.dot(across);
    let from_corner = ray.origin - corner;
    let u = from_corner.dot(across) * inverse;
    // Written so that NaN, from a ray in the plane, is no hit.
    let beside = !(0.0..=1.0).contains(&u);
    if beside {
        return None;
    }
    let around = from_corner.cross(a);
    let v = ray.direction.dot(around) * inverse;
    (v >= 0.0).then(|| (b.dot(around) * inverse, [u, v]))
}

/// The first distance past `nearest` at which the ray meets the sphere.
#[inline]
fn sphere_met(ray: &Ray, center: Vec3, radius: f32, nearest: f32) -> Option<f32> {
    let to_center = center - ray.origin;
    let along = to_center.dot(ray.direction);
    // The distance between ray and centre, without the cancellation of |c|^2 - along^2.
    let beside = (to_center - along * ray.direction).length_squared();
    let half = radius * radius - beside;
    let half = (half >= 0.0).then(|| half.sqrt())?;
    let [first, second] = [along - half, along + half];
    Some(if first > nearest { first } else { second })
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [low, high] = self.form.bounds().map(|corner| corner.to_array());
        Aabb::with_bounds(low.into(), high.into())
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index as u32;
    }

    fn bh_node_index(&self) -> usize {
        self.node as usize
    }
}
