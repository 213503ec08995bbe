//! One of the drawings that share a hatching, each by its own map of places.

use crate::frame::{Frame, Plane, Vector2Planes};
use crate::line::hatching::Pixels;
use crate::line::stroke_texture::BATCH;
use crate::line::texture_coordinates::places::{MovingSurface, jacobian_at};
use crate::line::texture_coordinates::{Jacobian, STILL, in_texture};
use std::ops::Range;

/// A map of places and its share of the drawing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedTexture<'a> {
    /// Places with their surface; `None` if fixed in the picture.
    pub(crate) place: Option<(&'a Vector2Planes, MovingSurface<'a>)>,
    /// Offset of the fixed texture.
    pub(crate) origin: [f32; 2],
    /// Share of the optical density, 0..1; `None` is all.
    pub(crate) share: Option<&'a Plane>,
}

/// Placement of the texture at the pixels of a batch.
pub(crate) struct TexturePlacement {
    by: [Jacobian; BATCH],
    direction: [[f32; BATCH]; 2],
}

impl Default for TexturePlacement {
    fn default() -> Self {
        Self {
            by: [STILL; BATCH],
            direction: [[0.0; BATCH]; 2],
        }
    }
}

impl PlacedTexture<'_> {
    /// A whole drawing with its texture fixed in the picture.
    pub(crate) const STILL: Self = Self {
        place: None,
        origin: [0.0; 2],
        share: None,
    };

    /// Whether it has a share in these pixels.
    pub(crate) fn is_used(&self, y: usize, columns: Range<usize>) -> bool {
        self.share
            .is_none_or(|share| share.row(y)[columns].iter().any(|&share| share > 0.0))
    }

    /// Lays the texture under these pixels.
    pub(crate) fn lay(
        &self,
        pixels: &mut Pixels,
        lie: &mut TexturePlacement,
        frame: &Frame,
        y: usize,
        columns: Range<usize>,
    ) {
        let [xs, ys] = &mut pixels.place;
        let Some((place, surface)) = self.place else {
            let window = frame.data_window;
            let first = window.x0 as f32 + columns.start as f32 + 0.5 + self.origin[0];
            for (i, x) in xs.iter_mut().enumerate() {
                *x = first + i as f32;
            }
            ys.fill(window.y0 as f32 + y as f32 + 0.5 + self.origin[1]);
            return;
        };
        xs[..columns.len()].copy_from_slice(&place.x.row(y)[columns.clone()]);
        ys[..columns.len()].copy_from_slice(&place.y.row(y)[columns.clone()]);
        for (by, x) in lie.by.iter_mut().zip(columns) {
            *by = jacobian_at(place, &surface, x, y);
        }
    }

    /// Reduces the density of strokes to this sheet's share.
    pub(crate) fn take_share(&self, pixels: &mut Pixels, y: usize, columns: Range<usize>) {
        if let Some(share) = self.share {
            let density = pixels.density.iter_mut();
            for (density, share) in density.zip(&share.row(y)[columns]) {
                *density *= share;
            }
        }
    }

    /// The directions in the texture of `direction` in the picture.
    pub(crate) fn in_texture<'b>(
        &self,
        direction: [&'b [f32]; 2],
        lie: &'b mut TexturePlacement,
    ) -> [&'b [f32]; 2] {
        if self.place.is_none() {
            return direction;
        }
        let count = direction[0].len();
        let [u, v] = &mut lie.direction;
        for i in 0..count {
            [u[i], v[i]] = in_texture(&lie.by[i], [direction[0][i], direction[1][i]]);
        }
        [&u[..count], &v[..count]]
    }
}
