//! View space in the shown picture: where its points are seen, and where new lights go.

use super::lights::NearLight;
use crate::frame::{Frame, Projection, SightLines};
use eframe::egui::{Vec2, vec2};
use glam::{DVec2, DVec3, Vec3};

/// A new light hovers this far before the surface, as a share of the way to the eye.
const BEFORE: f64 = 0.25;

/// The sight lines of a picture, whose corner lies at a pixel of theirs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Space {
    sight: SightLines,
    corner: DVec2,
    /// What the height of the picture is at a depth of 1, or everywhere for parallel lines.
    height: f64,
}

impl Space {
    pub(super) fn of(frame: &Frame) -> Self {
        let sight = SightLines::of(frame);
        let window = frame.data_window;
        let pixels = match sight.projection() {
            Projection::Perspective { fy, .. } => fy,
            Projection::Orthographic { sy, .. } => sy,
        };
        Self {
            sight,
            corner: DVec2::new(f64::from(window.x0), f64::from(window.y0)),
            height: frame.mask.height() as f64 / pixels.abs(),
        }
    }

    /// Pixels from the corner of the picture to a point; `None` at or behind the eye.
    pub(super) fn pixel_of(&self, position: [f32; 3]) -> Option<Vec2> {
        let point = Vec3::from_array(position).as_dvec3();
        let pixel = self.sight.projection().pixel_of(point)? - self.corner;
        Some(vec2(pixel.x as f32, pixel.y as f32))
    }

    /// The point as deep as `position` that is seen at `pixel`.
    pub(super) fn moved(&self, position: [f32; 3], pixel: Vec2) -> [f32; 3] {
        self.at(pixel, -f64::from(position[2]))
    }

    /// The point moved away from the eye along its sight line, by a share of its depth; for parallel lines, of the
    /// height of the picture.
    pub(super) fn deeper(&self, position: [f32; 3], share: f32) -> [f32; 3] {
        let depth = -f64::from(position[2]);
        let unit = match self.sight.projection() {
            Projection::Perspective { .. } => depth,
            Projection::Orthographic { .. } => self.height,
        };
        match self.pixel_of(position) {
            Some(pixel) => self.at(pixel, depth + f64::from(share) * unit),
            None => position,
        }
    }

    fn at(&self, pixel: Vec2, depth: f64) -> [f32; 3] {
        let pixel = DVec2::new(pixel.x.into(), pixel.y.into()) + self.corner;
        let (start, line) = self.sight.line(pixel.x, pixel.y);
        self.rounded(start + depth * line)
    }

    /// To less than a pixel, so that recipes stay readable.
    fn rounded(&self, point: DVec3) -> [f32; 3] {
        let seen = match self.sight.projection() {
            Projection::Perspective { .. } => -point.z * self.height,
            Projection::Orthographic { .. } => self.height,
        };
        // Of 10,000 to 100,000 steps over the height of the picture.
        let unit = 10_f64.powf((seen.abs().max(1e-30) / 1e4).log10().floor());
        let decimals = (-unit.log10()).round().clamp(0.0, 30.0) as usize;
        point.to_array().map(|v| {
            let text = format!("{v:.decimals$}");
            // Adding 0 makes no negative zero of it.
            text.parse::<f32>().expect("a number was written") + 0.0
        })
    }
}

/// A light before the middle of the surface that shows there as white as light from afar; `None` without depth.
pub(super) fn before_the_middle(frame: &Frame) -> Option<NearLight> {
    let depth = frame.depth.as_ref()?;
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let from_middle =
        |x: usize, y: usize| (2 * x).abs_diff(width).pow(2) + (2 * y).abs_diff(height).pow(2);
    let covered = (0..height).flat_map(|y| {
        let row = frame.mask.row(y);
        frame
            .mask
            .span(y)
            .filter(move |&x| row[x])
            .map(move |x| (x, y))
    });
    let (x, y) = covered.min_by_key(|&(x, y)| from_middle(x, y))?;
    let space = Space::of(frame);
    let at = frame.data_window.middle(x, y);
    let seen = f64::from(depth.at(x, y));
    let surface = space.sight.point(at.x, at.y, seen, frame.source.depth_kind);
    let before = match space.sight.projection() {
        Projection::Perspective { .. } => (1.0 - BEFORE) * surface,
        Projection::Orthographic { .. } => surface + BEFORE * space.height * DVec3::Z,
    };
    let position = space.rounded(before);
    let away = Vec3::from_array(position).as_dvec3().distance(surface);
    // Its colour is that at a distance of 1.
    let strength = format!("{:.3e}", away * away).parse().ok()?;
    Some(NearLight {
        position,
        color: Some([strength; 3]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Camera, Mask, Plane, Vector3Planes};
    use glam::DAffine3;

    fn frame(projection: Projection) -> Frame {
        let normal = Vector3Planes::from_fn(40, 30, |_, _| DVec3::Z);
        let mut frame = Frame::of_normals(normal, Mask::full(40, 30));
        frame.depth = Some(Plane::filled(40, 30, 8.0));
        frame.camera = Some(Camera {
            view_from_world: DAffine3::IDENTITY,
            projection,
        });
        frame
    }

    #[test]
    fn lights_are_moved_across_and_into_the_picture() {
        // 30 rows at 60 pixels per unit of slope: 4 high at a depth of 8.
        let lens = Projection::Perspective {
            fx: 60.0,
            fy: 60.0,
            cx: 20.0,
            cy: 15.0,
        };
        let parallel = Projection::Orthographic {
            sx: 7.5,
            sy: 7.5,
            cx: 20.0,
            cy: 15.0,
        };
        // A quarter of the way to the eye, or of the 4 units of the picture's height.
        for (projection, z, strength) in [(lens, -6.0, 4.0), (parallel, -7.0, 1.0)] {
            let frame = frame(projection);
            let light = before_the_middle(&frame).unwrap();
            assert!((light.position[2] - z).abs() < 1e-3, "{light:?}");
            let [red, ..] = light.color.unwrap();
            assert!((red - strength).abs() < 0.02 * strength, "{light:?}");
            let space = Space::of(&frame);
            let moved = space.moved(light.position, vec2(33.0, 6.5));
            assert_eq!(moved[2], light.position[2]);
            let seen = space.pixel_of(moved).unwrap();
            assert!((seen - vec2(33.0, 6.5)).length() < 0.01, "{seen}");
            // Deeper by an eighth: of 6, or of a height of 4.
            let deeper = space.deeper(moved, 0.125);
            let by = if z == -6.0 { 0.75 } else { 0.5 };
            assert!((moved[2] - deeper[2] - by).abs() < 1e-3, "{deeper:?}");
            let seen = space.pixel_of(deeper).unwrap();
            assert!((seen - vec2(33.0, 6.5)).length() < 0.01, "{seen}");
        }
    }
}
