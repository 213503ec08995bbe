//! The scene seen in mirrors and lenses: everything that traced rays can hit beyond the visible surface.

use super::{Frame, Mask, Plane, Surroundings, Vector3Planes};
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
        Some(Mask::new(Plane::from_fn(
            own.width(),
            own.height(),
            |x, y| own.at(x, y) && frame.mask.at(x, y),
        )))
    }

    /// Whether the pixel at column `x` of row `y` of `frame` is specular.
    #[inline]
    pub fn is_specular(&self, frame: &Frame, x: usize, y: usize) -> bool {
        frame.mask.at(x, y) && self.mask.as_ref().is_none_or(|mask| mask.at(x, y))
    }
}

impl SpecularScene {
    /// Fills pixels of `frame` without a surface from [`behind`](SpecularScene::behind), so that both are drawn as one
    /// picture. A colour with alpha is composited over the one behind; without alpha it is assumed to include both. The
    /// filled pixels are not specular.
    pub fn fill_from_behind(&mut self, frame: &mut Frame) {
        let Some(behind) = &self.behind else {
            return;
        };
        let own = self.mask.take().unwrap_or_else(|| frame.mask.clone());
        let covered = frame.mask.clone();
        self.mask = Some(Mask::new(Plane::from_fn(
            own.width(),
            own.height(),
            |x, y| own.at(x, y) && covered.at(x, y),
        )));
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
    let is_inside = at[0] >= 0
        && at[1] >= 0
        && (at[0] as usize) < other.width()
        && (at[1] as usize) < other.height();
    is_inside.then(|| at.map(|i| i as usize))
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
