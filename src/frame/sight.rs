//! Sight lines: from pixels to points of view space, and from tangents back to the picture.

use crate::frame::{DepthKind, Frame, Projection, Window};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::ops::Range;

/// The sight lines of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightLines {
    projection: Projection,
}

/// Minimum share of a unit tangent across the sight line: with less the tangent points at the eye.
pub(crate) const MIN_SEEN: f64 = 1e-4;

impl SightLines {
    /// The sight lines of a projection.
    pub fn new(projection: Projection) -> Self {
        Self { projection }
    }

    /// The sight lines of a frame: parallel if it has no camera.
    pub fn of(frame: &Frame) -> Self {
        match frame.camera {
            Some(camera) => Self::new(camera.projection),
            None => Self::parallel(frame.pixel_aspect),
        }
    }

    /// Parallel sight lines, for a picture without a camera: lengths are in pixel heights, and pixels are
    /// `pixel_aspect` wide.
    pub fn parallel(pixel_aspect: f32) -> Self {
        let (sy, cx, cy) = (1.0, 0.0, 0.0);
        let sx = 1.0 / f64::from(pixel_aspect);
        Self::new(Projection::Orthographic { sx, sy, cx, cy })
    }

    /// The sight line through picture position (`x`, `y`): its origin, and its direction scaled to z = -1, along which
    /// depth is measured.
    #[inline]
    pub fn line(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let [across, up] = self.across_and_up(x, y);
        line_of(self.is_perspective(), across, up)
    }

    /// The view-space point at picture position (`x`, `y`) and depth `depth`.
    #[inline]
    pub fn point(&self, x: f64, y: f64, depth: f64, kind: DepthKind) -> DVec3 {
        point_on(self.line(x, y), depth, kind)
    }

    /// The step from the surface seen at `from` with normal `here` to that seen at `to` with normal `there`, when only
    /// normals are known; in perspective in units of the first one's depth.
    ///
    /// The step is perpendicular to the sum of both normals: `(n + n') . (p' - p) = 0`. [LA]'s tangent step,
    /// perpendicular to n alone, is first order; this is second order, and exact on balls and cylinders. `None` if the
    /// surface is seen from behind.
    #[inline]
    pub fn step(&self, from: DVec2, here: DVec3, to: DVec2, there: DVec3) -> Option<DVec3> {
        let lines = [from, to].map(|at| self.line(at.x, at.y));
        let (is_seen, step) = step_by_normals(self.is_perspective(), lines, here + there);
        (is_seen && step.is_finite()).then_some(step)
    }

    /// The unit tangent of a surface with the normal `normal`, at any point of the sight line through (`x`, `y`), that
    /// appears along `direction` in the picture, x right and y up: the inverse of
    /// [`picture_direction`](Self::picture_direction). `None` if the surface is seen edge-on.
    #[inline]
    pub fn tangent(&self, x: f64, y: f64, direction: DVec2, normal: DVec3) -> Option<DVec3> {
        let (_, line) = self.line(x, y);
        let (sx, sy) = self.pixels_per_unit();
        let across = DVec3::new(direction.x / sx, direction.y / sy, 0.0);
        let tangent = across - normal.dot(across) / normal.dot(line) * line;
        tangent.try_normalize()
    }

    /// Pixels per unit of length along x and y, at a depth of 1 in perspective.
    fn pixels_per_unit(&self) -> (f64, f64) {
        let (Projection::Perspective { fx: x, fy: y, .. }
        | Projection::Orthographic { sx: x, sy: y, .. }) = self.projection;
        (x, y)
    }

    /// Height of a pixel over its width, signed by the directions of both axes.
    pub(crate) fn pixel_shape(&self) -> f64 {
        let (sx, sy) = self.pixels_per_unit();
        sy / sx
    }

    /// The projection.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// The unit direction in the picture, per pixel, x right and y up, of a unit tangent at the surface
    /// seen at (`x`, `y`): the derivative of the projection along it. `None` where it points at the eye.
    #[inline]
    pub fn picture_direction(&self, x: f64, y: f64, tangent: DVec3) -> Option<DVec2> {
        let (_, line) = self.line(x, y);
        let (is_seen, direction) = direction_seen(line, self.pixel_shape(), tangent);
        is_seen.then_some(direction)
    }

    /// What distinguishes the sight line through a position, as [`line_of`] takes it.
    #[inline]
    pub(crate) fn across_and_up(&self, x: f64, y: f64) -> [f64; 2] {
        let (Projection::Perspective { cx, cy, .. } | Projection::Orthographic { cx, cy, .. }) =
            self.projection;
        let (sx, sy) = self.pixels_per_unit();
        [(x - cx) / sx, (cy - y) / sy]
    }

    pub(crate) fn is_perspective(&self) -> bool {
        matches!(self.projection, Projection::Perspective { .. })
    }
}

/// The direction to the eye, scaled to z = 1, of the pixels of a window: its x depends only on the column, its y only on
/// the row. Both are 0 for a projection in parallel lines, or an unknown one.
pub(crate) struct ToEye {
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
}

impl ToEye {
    pub(crate) fn of(window: Window, projection: Option<Projection>) -> Self {
        let at = |x, y| {
            let place = window.middle(x, y);
            projection.map_or(DVec2::ZERO, |projection| {
                projection.to_eye(place.x, place.y)
            })
        };
        Self {
            x: (0..window.width()).map(|x| at(x, 0).x as f32).collect(),
            y: (0..window.height()).map(|y| at(0, y).y as f32).collect(),
        }
    }
}

/// `n . v` of a normal and the direction v to the eye, (`to_eye`, 1).
#[inline(always)]
pub(crate) fn facing(n: Vec3, to_eye: Vec2) -> f32 {
    n.z + n.truncate().dot(to_eye)
}

/// The point at this depth on a sight line with its origin.
#[inline(always)]
pub(crate) fn point_on((start, line): (DVec3, DVec3), depth: f64, kind: DepthKind) -> DVec3 {
    let depth = match kind {
        DepthKind::Ray => depth / line.length(),
        DepthKind::Planar | DepthKind::Relative => depth,
    };
    start + depth * line
}

/// [`SightLines::step`] between two sight lines with their origins, given the sum of both normals, and whether the
/// surface is seen from the front. It may not be finite.
#[inline(always)]
pub(crate) fn step_by_normals(
    is_perspective: bool,
    [(start, line), (start_to, line_to)]: [(DVec3, DVec3); 2],
    normals: DVec3,
) -> (bool, DVec3) {
    let (facing, facing_to) = (normals.dot(line), normals.dot(line_to));
    let step = if is_perspective {
        // Depths 1 and d: normals . (d line_to - line) = 0.
        facing / facing_to * line_to - line
    } else {
        let across = start_to - start;
        across - normals.dot(across) / facing * line
    };
    ((facing < 0.0) & (facing_to < 0.0), step)
}

/// [`SightLines::picture_direction`] on a sight line, and whether it is seen; else it means nothing.
#[inline(always)]
pub(crate) fn direction_seen(line: DVec3, pixel_shape: f64, tangent: DVec3) -> (bool, DVec2) {
    // Moving along the sight line does not change the position: cancel z.
    let across = (tangent + tangent.z * line).truncate();
    let least = MIN_SEEN * MIN_SEEN * line.length_squared();
    let scaled = across * DVec2::new(1.0, pixel_shape);
    let over_length = scaled.length_recip();
    let has_length = (over_length > 0.0) & (over_length < f64::INFINITY);
    let is_seen = (across.length_squared() > least) & has_length;
    (is_seen, scaled * over_length)
}

/// The sight lines through the middles of a frame's pixels. What belongs to a column or to a row is found once.
pub(crate) struct PixelLines {
    /// x of the direction by column, and y by row; for parallel lines, of the origin.
    x: Vec<f64>,
    y: Vec<f64>,
}

impl PixelLines {
    /// The sight lines of a frame.
    pub(crate) fn new(sight: &SightLines, frame: &Frame) -> Self {
        let varying = |x: usize, y: usize| {
            let at = frame.data_window.middle(x, y);
            sight.across_and_up(at.x, at.y)
        };
        Self {
            x: (0..frame.mask.width()).map(|x| varying(x, 0)[0]).collect(),
            y: (0..frame.mask.height()).map(|y| varying(0, y)[1]).collect(),
        }
    }

    /// What distinguishes the sight lines of columns.
    #[inline]
    pub(crate) fn across(&self, columns: Range<usize>) -> &[f64] {
        &self.x[columns]
    }

    /// What distinguishes the sight lines of a row.
    #[inline]
    pub(crate) fn up(&self, y: usize) -> f64 {
        self.y[y]
    }
}

/// The sight line of a column and a row, as [`SightLines::line`] has it, from what distinguishes these.
#[inline(always)]
pub(crate) fn line_of(is_perspective: bool, across: f64, up: f64) -> (DVec3, DVec3) {
    if is_perspective {
        (DVec3::ZERO, DVec3::new(across, up, -1.0))
    } else {
        (DVec3::new(across, up, 0.0), DVec3::NEG_Z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes, Window};

    const LENS: Projection = Projection::Perspective {
        fx: 800.0,
        fy: 600.0,
        cx: 320.0,
        cy: 240.0,
    };

    #[test]
    fn points_lie_on_their_pixels() {
        let parallel = Projection::Orthographic {
            sx: 20.0,
            sy: 30.0,
            cx: 320.0,
            cy: 240.0,
        };
        for projection in [LENS, parallel] {
            let sight = SightLines::new(projection);
            let planar = sight.point(17.5, 400.5, 7.0, DepthKind::Planar);
            assert!((planar.z + 7.0).abs() < 1e-12);
            let seen = projection.pixel_of(planar).unwrap();
            assert!(seen.distance(DVec2::new(17.5, 400.5)) < 1e-9);
        }
        let along = SightLines::new(LENS).point(17.5, 400.5, 7.0, DepthKind::Ray);
        assert!((along.length() - 7.0).abs() < 1e-12);
    }

    #[test]
    fn lines_of_pixels_are_those_of_their_middles() {
        let parallel = SightLines::parallel(0.5).projection();
        for projection in [LENS, parallel] {
            let sight = SightLines::new(projection);
            let mut frame = Frame::of_normals(
                Vector3Planes::from_fn(5, 4, |_, _| DVec3::Z),
                Mask::full(5, 4),
            );
            frame.data_window = Window::at(-2, 300, 5, 4);
            let lines = PixelLines::new(&sight, &frame);
            let line = line_of(sight.is_perspective(), lines.across(3..4)[0], lines.up(1));
            assert_eq!(line, sight.line(1.5, 301.5), "{projection:?}");
        }
    }

    #[test]
    fn a_step_over_a_ball_is_exact() {
        for projection in [
            LENS,
            Projection::Orthographic {
                sx: 90.0,
                sy: 60.0,
                cx: 320.0,
                cy: 240.0,
            },
        ] {
            let sight = SightLines::new(projection);
            let center = DVec3::new(0.2, -0.1, -9.0);
            let points = [DVec3::new(0.3, 0.5, 1.0), DVec3::new(-0.4, 0.1, 0.9)];
            let [here, there] = points.map(|n| n.normalize());
            let [p, q] = [here, there].map(|n| center + 2.0 * n);
            let [from, to] = [p, q].map(|p| projection.pixel_of(p).unwrap());
            let unit = match projection {
                Projection::Perspective { .. } => -p.z,
                Projection::Orthographic { .. } => 1.0,
            };
            let step = sight.step(from, here, to, there).unwrap();
            assert!((step * unit).distance(q - p) < 1e-12, "{step}");
            assert_eq!(sight.step(from, -here, to, -there), None);
        }
    }

    #[test]
    fn a_tangent_is_seen_as_the_projection_moves_it() {
        let sight = SightLines::new(LENS);
        let (point, tangent) = (DVec3::new(0.7, -0.4, -3.0), DVec3::new(0.5, 0.2, -0.8));
        let at = LENS.pixel_of(point).unwrap();
        let moved = LENS.pixel_of(point + 1e-6 * tangent).unwrap() - at;
        let expected = DVec2::new(moved.x, -moved.y).normalize();
        let seen = sight
            .picture_direction(at.x, at.y, tangent.normalize())
            .unwrap();
        assert!(seen.distance(expected) < 1e-6);
        assert_eq!(sight.picture_direction(at.x, at.y, point.normalize()), None);
        // And back: the tangent perpendicular to a normal, with this appearance.
        let normal = tangent.any_orthogonal_vector().normalize();
        let back = sight.tangent(at.x, at.y, seen, normal).unwrap();
        assert!(back.distance(tangent.normalize()) < 1e-9);
    }
}
