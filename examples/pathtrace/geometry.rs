//! Rays and the shapes they meet.

use glam::Vec3;
use obvhs::Boundable;
use obvhs::aabb::Aabb;

/// A half line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Unit vector.
    pub(crate) direction: Vec3,
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
}

/// A form that belongs to an object of the scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape {
    pub(crate) form: Form,
    pub(crate) object: usize,
}

impl Form {
    /// Distance along the ray; on a triangle the weights of its second and third corner, too.
    #[inline]
    pub(crate) fn met(&self, ray: &Ray) -> Option<(f32, [f32; 2])> {
        let met = match *self {
            Self::Triangle { corner, sides, .. } => triangle_met(ray, corner, sides),
            Self::Sphere { center, radius } => Some((sphere_met(ray, center, radius)?, [0.0; 2])),
        };
        met.filter(|(distance, _)| *distance > 0.0)
    }
}

/// T. Moeller, B. Trumbore: Fast, Minimum Storage Ray/Triangle Intersection, 1997.
#[inline]
fn triangle_met(ray: &Ray, corner: Vec3, [a, b]: [Vec3; 2]) -> Option<(f32, [f32; 2])> {
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
    (v >= 0.0 && u + v <= 1.0).then(|| (b.dot(around) * inverse, [u, v]))
}

/// The first distance ahead at which the ray meets the sphere.
#[inline]
fn sphere_met(ray: &Ray, center: Vec3, radius: f32) -> Option<f32> {
    let to_center = center - ray.origin;
    let along = to_center.dot(ray.direction);
    // The distance between ray and centre, without the cancellation of |c|^2 - along^2.
    let beside = (to_center - along * ray.direction).length_squared();
    let half = radius * radius - beside;
    let half = (half >= 0.0).then(|| half.sqrt())?;
    let [first, second] = [along - half, along + half];
    Some(if first > 0.0 { first } else { second })
}

impl Boundable for Shape {
    fn aabb(&self) -> Aabb {
        let corners = match self.form {
            Form::Triangle { corner, sides, .. } => {
                vec![corner, corner + sides[0], corner + sides[1]]
            }
            Form::Sphere { center, radius } => vec![center - radius, center + radius],
        };
        Aabb::from_points(&corners.into_iter().map(Into::into).collect::<Vec<_>>())
    }
}
