//! Reduction of a frame for a quick preview.

use super::{Camera, Frame, Mask, Plane, Projection, Window};

impl Frame {
    /// The frame made of every `step`th pixel of every `step`th row, seen by the same camera. Nothing is filtered:
    /// remaining samples keep their values, and slopes are preserved.
    ///
    /// # Panics
    /// If `step` is 0.
    pub fn reduced(&self, step: usize) -> Frame {
        assert!(step > 0, "a step leads somewhere");
        let place = |window: Window| {
            let first = |from: i32| from.div_euclid(step as i32);
            let [width, height] = [window.width(), window.height()].map(|n| n.div_ceil(step));
            Window::at(first(window.x0), first(window.y0), width, height)
        };
        let mask = Mask::new(of_every(self.mask.plane(), step));
        Frame {
            data_window: place(self.data_window),
            display_window: place(self.display_window),
            camera: self.camera.map(|camera| Camera {
                projection: camera.projection.of_pixels(step as f64),
                ..camera
            }),
            ..self.with_planes(mask, |plane| of_every(plane, step))
        }
    }
}

fn of_every<T: Copy>(plane: &Plane<T>, step: usize) -> Plane<T> {
    let (width, height) = (plane.width().div_ceil(step), plane.height().div_ceil(step));
    Plane::from_fn(width, height, |x, y| plane.at(x * step, y * step))
}

impl Projection {
    /// The projection for pixels `step` times as large.
    pub(super) fn of_pixels(self, step: f64) -> Self {
        match self {
            Self::Perspective { fx, fy, cx, cy } => Self::Perspective {
                fx: fx / step,
                fy: fy / step,
                cx: cx / step,
                cy: cy / step,
            },
            Self::Orthographic { sx, sy, cx, cy } => Self::Orthographic {
                sx: sx / step,
                sy: sy / step,
                cx: cx / step,
                cy: cy / step,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Vector3Planes;

    #[test]
    fn every_third_pixel_is_left() {
        let normal = Vector3Planes::from_fn(7, 4, |x, y| glam::DVec3::new(x as f64, y as f64, 1.0));
        let mask = Mask::new(Plane::from_fn(7, 4, |x, _| x != 3));
        let mut frame = Frame::of_normals(normal, mask);
        frame.data_window = Window::at(-3, 6, 7, 4);
        let reduced = frame.reduced(3);
        assert_eq!(reduced.data_window, Window::at(-1, 2, 3, 2));
        assert_eq!(reduced.normal.x.samples(), [0.0, 3.0, 6.0, 0.0, 3.0, 6.0]);
        assert_eq!(reduced.normal.y.row(1), [3.0; 3]);
        assert_eq!(reduced.mask.row(0), [true, false, true]);
        assert_eq!(frame.reduced(1).normal, frame.normal);
    }
}
