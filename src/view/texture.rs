//! A picture on the graphics device, in tiles no larger than it takes.

use crate::command::look::Pixels;
use eframe::egui::{
    Color32, ColorImage, Context, Painter, Pos2, Rect, TextureFilter, TextureHandle,
    TextureOptions, pos2, vec2,
};

/// Larger tiles gain nothing.
const MOST: usize = 4096;

/// Nearest when enlarged, so that pixels are seen as they are.
const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    ..TextureOptions::LINEAR
};

struct Tile {
    /// Its first column and row.
    at: [usize; 2],
    size: [usize; 2],
    handle: TextureHandle,
}

/// A picture that can be painted.
pub(super) struct Texture {
    pub(super) size: [usize; 2],
    tiles: Vec<Tile>,
}

impl Texture {
    /// Uploads `pixels`, into the memory of `last` where that fits.
    pub(super) fn of(context: &Context, pixels: &Pixels, last: Option<Self>) -> Self {
        let size = [pixels.width, pixels.height];
        let limit = context.input(|input| input.max_texture_side.clamp(1, MOST));
        let mut spare = last
            .filter(|last| last.size == size)
            .map(|last| last.tiles.into_iter());
        let corners = (0..size[1])
            .step_by(limit)
            .flat_map(|y| (0..size[0]).step_by(limit).map(move |x| [x, y]));
        let tiles = corners.map(|at| {
            let part = [0, 1].map(|i| (size[i] - at[i]).min(limit));
            let image = image(pixels, at, part);
            let kept = spare.as_mut().and_then(Iterator::next);
            let handle = match kept {
                Some(mut tile) => {
                    tile.handle.set(image, OPTIONS);
                    tile.handle
                }
                None => context.load_texture("picture", image, OPTIONS),
            };
            Tile {
                at,
                size: part,
                handle,
            }
        });
        Self {
            size,
            tiles: tiles.collect(),
        }
    }

    /// Paints it over `rect`.
    pub(super) fn paint(&self, painter: &Painter, rect: Rect) {
        let scale = vec2(
            rect.width() / self.size[0].max(1) as f32,
            rect.height() / self.size[1].max(1) as f32,
        );
        let place = |[x, y]: [usize; 2]| -> Pos2 {
            rect.min + vec2(x as f32 * scale.x, y as f32 * scale.y)
        };
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        for Tile { at, size, handle } in &self.tiles {
            let end = [at[0] + size[0], at[1] + size[1]];
            let to = Rect::from_min_max(place(*at), place(end));
            painter.image(handle.id(), to, whole, Color32::WHITE);
        }
    }
}

/// A part of the picture.
fn image(pixels: &Pixels, at: [usize; 2], size: [usize; 2]) -> ColorImage {
    let rows = (at[1]..at[1] + size[1]).flat_map(|y| {
        let first = y * pixels.width + at[0];
        &pixels.rgba[first..first + size[0]]
    });
    let color = |&[r, g, b, a]: &[u8; 4]| match a {
        255 => Color32::from_rgb(r, g, b),
        _ => Color32::from_rgba_unmultiplied(r, g, b, a),
    };
    ColorImage::new(size, rows.map(color).collect())
}
