//! The scene seen in mirrors and lenses: everything that traced rays can hit beyond the visible surface.

use super::enlarged::Enlarger;
use super::{Frame, Mask, Plane, Surroundings, Vector3Planes};
use glam::DVec3;
use std::sync::Arc;

/// The scene around the specular surfaces of a frame, as far as it is known. Everything except the surroundings is seen
/// by the frame's own camera.
#[derive(Debug, Clone, Default)]
pub struct SpecularScene {
    /// The specular pixels of the frame; `None` for all covered ones.
    pub mask: Option<Mask>,
    /// Back faces of transparent objects; their normals may point either way.
    pub back: Option<Frame>,
    /// The scene without its specular objects.
    pub behind: Option<Frame>,
    /// The surroundings of the specular object.
    pub surroundings: Option<Arc<Surroundings>>,
    /// End of the bent sight line of each pixel, in view space; not finite where unknown.
    pub hit_position: Option<Vector3Planes>,
}

impl SpecularScene {
    /// The specular pixels of `frame`; `None` for all covered ones.
    pub fn mask_in(&self, frame: &Frame) -> Option<Mask> {
        let own = self.mask.as_ref()?;
        let is_in = |x, y| self.is_specular(frame, x, y);
        Some(Mask::new(Plane::from_fn(own.width(), own.height(), is_in)))
    }

    /// The scene for `frame` [enlarged](Frame::enlarged) `factor` times. Points that sight lines end at are interpolated
    /// within the surfaces that they lie on.
    ///
    /// # Panics
    /// If `factor` is less than 1.
    pub fn enlarged(&self, frame: &Frame, factor: f64) -> Self {
        let layer = |layer: &Option<Frame>| layer.as_ref().map(|layer| layer.enlarged(factor));
        let mask = self.mask.as_ref().map(|mask| {
            let share = mask.plane().map(|is_in| f32::from(u8::from(is_in)));
            let share = Enlarger::new(frame, factor).plane(&share, 0.0);
            Mask::new(share.map(|share| share > 0.5))
        });
        let hit_position = self.hit_position.as_ref().map(|points| {
            let (width, height) = (points.x.width(), points.x.height());
            let is_known = |x, y| self.is_specular(frame, x, y) && points.at(x, y).is_finite();
            let known = Mask::new(Plane::from_fn(width, height, is_known));
            let away = |x, y| points.at(x, y).length() as f32;
            let seen = Frame {
                data_window: frame.data_window,
                display_window: frame.display_window,
                depth: Some(Plane::from_fn(width, height, away)),
                // Which way surfaces turn there is not known.
                ..Frame::of_normals(
                    Vector3Planes::from_fn(width, height, |_, _| DVec3::NAN),
                    known,
                )
            };
            let enlarger = Enlarger::new(&seen, factor);
            points.mapped(|plane| {
                let finite = plane.map(|at| if at.is_finite() { at } else { 0.0 });
                enlarger.plane(&finite, f32::NAN)
            })
        });
        Self {
            mask,
            back: layer(&self.back),
            behind: layer(&self.behind),
            surroundings: self.surroundings.clone(),
            hit_position,
        }
    }

    /// Whether the pixel at column `x` of row `y` of `frame` is specular.
    #[inline]
    pub fn is_specular(&self, frame: &Frame, x: usize, y: usize) -> bool {
        frame.mask.at(x, y) && self.mask.as_ref().is_none_or(|mask| mask.at(x, y))
    }

    /// Fills pixels of `frame` without a surface from [`behind`](SpecularScene::behind), so that both are drawn as one
    /// picture. A colour with alpha is composited over the one behind; without alpha it is assumed to include both. The
    /// filled pixels are not specular.
    pub fn fill_from_behind(&mut self, frame: &mut Frame) {
        let Some(behind) = &self.behind else {
            return;
        };
        let covered = frame.mask.clone();
        self.mask = self.mask_in(frame).or_else(|| Some(covered.clone()));
        let mut filled = covered.plane().clone();
        for y in 0..covered.height() {
            for x in 0..covered.width() {
                let Some(at) = pixel_of(behind, frame, x, y) else {
                    continue;
                };
                lay_over(frame, behind, [x, y], at);
                if !covered.at(x, y) && behind.mask.at(at[0], at[1]) {
                    copy_shape(frame, behind, [x, y], at);
                    filled.row_mut(y)[x] = true;
                }
            }
        }
        frame.mask = Mask::new(filled);
    }
}

/// The pixel of `behind` at the position of pixel (`x`, `y`) of `frame`.
fn pixel_of(behind: &Frame, frame: &Frame, x: usize, y: usize) -> Option<[usize; 2]> {
    let (own, other) = (frame.data_window, behind.data_window);
    let at = [own.x0 - other.x0 + x as i32, own.y0 - other.y0 + y as i32];
    let [x, y] = at.map(|at| usize::try_from(at).ok());
    let is_inside = |at: &[usize; 2]| at[0] < other.width() && at[1] < other.height();
    Some([x?, y?]).filter(is_inside)
}

fn copy_shape(frame: &mut Frame, behind: &Frame, [x, y]: [usize; 2], [bx, by]: [usize; 2]) {
    let to = &mut frame.normal;
    let from = &behind.normal;
    to.x.row_mut(y)[x] = from.x.at(bx, by);
    to.y.row_mut(y)[x] = from.y.at(bx, by);
    to.z.row_mut(y)[x] = from.z.at(bx, by);
    if let (Some(to), Some(from)) = (&mut frame.depth, &behind.depth) {
        to.row_mut(y)[x] = from.at(bx, by);
    }
    if let Some(lengths) = &mut frame.normal_length {
        lengths.row_mut(y)[x] = 1.0;
    }
}

/// Composites colour over that of the scene behind.
fn lay_over(frame: &mut Frame, behind: &Frame, [x, y]: [usize; 2], [bx, by]: [usize; 2]) {
    let (Some(color), Some(alpha), Some(other)) =
        (&mut frame.color, &mut frame.alpha, &behind.color)
    else {
        return;
    };
    let own = alpha.at(x, y);
    let share = 1.0 - own;
    for (to, from) in [
        (&mut color.r, &other.r),
        (&mut color.g, &other.g),
        (&mut color.b, &other.b),
    ] {
        to.row_mut(y)[x] += share * from.at(bx, by);
    }
    let beyond = behind.alpha.as_ref().map_or(1.0, |alpha| alpha.at(bx, by));
    alpha.row_mut(y)[x] = own + share * beyond;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{ColorPlanes, Window};

    #[test]
    fn what_lies_behind_fills_what_is_empty_and_shows_through() {
        let grey = |values: [f32; 2]| {
            let [r, g, b] = [(); 3].map(|()| Plane::from_fn(2, 1, |x, _| values[x]));
            ColorPlanes { r, g, b }
        };
        let of = |normal: DVec3, seen: [bool; 2], depth: f32| Frame {
            depth: Some(Plane::filled(2, 1, depth)),
            ..Frame::of_normals(
                Vector3Planes::from_fn(2, 1, |_, _| normal),
                Mask::new(Plane::from_fn(2, 1, |x, _| seen[x])),
            )
        };
        // A quarter of the first pixel is covered; the second is empty.
        let mut frame = Frame {
            color: Some(grey([0.2, 0.0])),
            alpha: Some(Plane::from_fn(2, 1, |x, _| [0.25, 0.0][x])),
            ..of(DVec3::Z, [true, false], 5.0)
        };
        // Its window begins one pixel to the left: the frame is over its second pixel, and right of it.
        let mut behind = Frame {
            color: Some(grey([9.0, 0.4])),
            ..of(DVec3::X, [true, true], 8.0)
        };
        behind.data_window = Window::at(-1, 0, 2, 1);
        let mut scene = SpecularScene {
            behind: Some(behind),
            ..SpecularScene::default()
        };
        let mut over = frame.clone();
        scene.fill_from_behind(&mut over);
        // .2 + (1 - .25) .4 = .5; beyond the picture behind, all stays.
        assert_eq!(over.color.unwrap().g.samples(), [0.5, 0.0]);
        assert_eq!(over.alpha.unwrap().samples(), [1.0, 0.0]);
        assert_eq!(over.mask.plane().samples(), [true, false]);
        // In one window with it the second pixel is filled, and no mirror by that. The first: .2 + .75 * 9.
        scene.mask = None;
        frame.data_window = Window::at(-1, 0, 2, 1);
        scene.fill_from_behind(&mut frame);
        assert_eq!(frame.mask.plane().samples(), [true, true]);
        assert_eq!(scene.mask.unwrap().plane().samples(), [true, false]);
        let normals = [frame.normal.at(0, 0), frame.normal.at(1, 0)];
        assert_eq!(normals, [DVec3::Z, DVec3::X]);
        assert_eq!(frame.depth.unwrap().samples(), [5.0, 8.0]);
        let color = frame.color.unwrap();
        assert!((color.g.at(0, 0) - 6.95).abs() < 1e-6 && color.g.at(1, 0) == 0.4);
    }

    #[test]
    fn what_is_seen_in_an_enlarged_mirror_keeps_its_surfaces() {
        // Columns 2 and 3 show a wall at 10, columns 4 and 5 one at 20.
        let seen = |x: usize| match x {
            0..2 => DVec3::NAN,
            2..4 => DVec3::new(x as f64, 0.0, -10.0),
            _ => DVec3::new(x as f64, 0.0, -20.0),
        };
        let frame = Frame {
            depth: Some(Plane::filled(6, 2, 1.0)),
            ..Frame::of_normals(
                Vector3Planes::from_fn(6, 2, |_, _| DVec3::Z),
                Mask::full(6, 2),
            )
        };
        let scene = SpecularScene {
            mask: Some(Mask::new(Plane::from_fn(6, 2, |x, _| x >= 2))),
            hit_position: Some(Vector3Planes::from_fn(6, 2, |x, _| seen(x))),
            ..SpecularScene::default()
        };
        let large = scene.enlarged(&frame, 2.0);
        // Pixel x lies at (x + 1/2)/2 - 1/2 of the original: 3 at 1.25, 4 at 1.75.
        assert_eq!(large.mask.unwrap().span(1), 4..12);
        let points = large.hit_position.unwrap();
        assert!(points.at(3, 1).is_nan());
        let expected = [
            (4, [2.0, -10.0]),
            (5, [2.25, -10.0]),
            (7, [3.0, -10.0]),
            (8, [4.0, -20.0]),
        ];
        for (x, at) in expected {
            let found = points.at(x, 1);
            assert_eq!([found.x, found.z], at, "{x}");
        }
    }
}
