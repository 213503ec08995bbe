//! A picture as textures, in tiles within the device's size limit.

use super::look::ViewPixels;
use eframe::egui::{
    Color32, ColorImage, Context, Painter, Pos2, Rect, TextureFilter, TextureHandle,
    TextureOptions, pos2, vec2,
};

/// Larger tiles bring no gain.
const MOST: usize = 4096;

/// Nearest-neighbour magnification, so that single pixels are visible.
const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    ..TextureOptions::LINEAR
};

struct TextureTile {
    /// First column and row of the tile.
    at: [usize; 2],
    size: [usize; 2],
    handle: TextureHandle,
}

/// A picture ready for painting.
pub(super) struct ViewTexture {
    pub(super) size: [usize; 2],
    tiles: Vec<TextureTile>,
}

impl ViewTexture {
    /// Uploads `pixels`, reusing the textures of `last` where sizes match.
    pub(super) fn of(context: &Context, pixels: &ViewPixels, last: Option<Self>) -> Self {
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
            TextureTile {
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
        for TextureTile { at, size, handle } in &self.tiles {
            let end = [at[0] + size[0], at[1] + size[1]];
            let to = Rect::from_min_max(place(*at), place(end));
            painter.image(handle.id(), to, whole, Color32::WHITE);
        }
    }
}

/// A tile of the picture.
fn image(pixels: &ViewPixels, at: [usize; 2], size: [usize; 2]) -> ColorImage {
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
