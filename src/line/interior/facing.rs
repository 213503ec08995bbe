//! Facing of a surface, n.v, and the direction in the picture in which it turns toward the viewer.

use crate::frame::{Frame, Mask, Plane, Projection, SightLines};
use glam::{Vec2, Vec3};

/// The view directions of the pixels of a level.
pub(super) struct Viewer {
    sight: SightLines,
    /// Upper left corner of the level in the picture, and pixels of the picture to one of the level.
    corner: Vec2,
    factor: f32,
    /// Height of a pixel over its width.
    pixel_shape: f32,
}

impl Viewer {
    pub(super) fn of(frame: &Frame, factor: usize) -> Self {
        let sight = SightLines::of(frame);
        Self {
            sight,
            corner: Vec2::new(frame.data_window.x0 as f32, frame.data_window.y0 as f32),
            factor: factor as f32,
            pixel_shape: sight.pixel_shape() as f32,
        }
    }

    /// The sight line through the centre of a pixel, with z = -1.
    fn line(&self, x: usize, y: usize) -> Vec3 {
        let at = self.corner + self.factor * Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        match self.sight.projection() {
            Projection::Orthographic { .. } => Vec3::NEG_Z,
            Projection::Perspective { .. } => self
                .sight
                .line(f64::from(at.x), f64::from(at.y))
                .1
                .as_vec3(),
        }
    }

    /// n.v, the cosine between a unit normal and the direction to the viewer.
    pub(super) fn facing(&self, x: usize, y: usize, normal: Vec3) -> f32 {
        let line = self.line(x, y);
        -normal.dot(line) / line.length()
    }

    /// The unit direction in the picture, x right and y up, of the view vector's tangential part; `None` where the
    /// surface faces the viewer fully.
    pub(super) fn uphill(&self, x: usize, y: usize, normal: Vec3) -> Option<Vec2> {
        // v - (n.v) n, whose first term is a point in the picture.
        let across = -(normal + normal.z * self.line(x, y)).truncate();
        (across * Vec2::new(1.0, self.pixel_shape)).try_normalize()
    }

    /// n.v of all of a level; 0 outside its mask.
    pub(super) fn facings(&self, normals: &Plane<Vec3>, mask: &Mask) -> Plane {
        Plane::of_covered(mask, |y| move |x| self.facing(x, y, normals.at(x, y)))
    }
}
