//! Strokes over the frame, row by row.

use crate::frame::memory::Memory;
use crate::frame::rows::map_rows;
use crate::frame::{Frame, Plane};
use crate::kernel::fast_math::atan2;
use crate::kernel::simd::wide;
use crate::line::canvas::Canvas;
use crate::line::hatching::{BATCH, Hatching, Pixels};
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::line::texture_coordinates::sheet::{PlacedTexture, TexturePlacement};
use crate::line::tonal_art_map::TonalArtMap;
use crate::line::tone::Densities;
use crate::params::StrokeParams;
use std::f32::consts::PI;

/// Coverage of the paper by strokes; without coordinates the texture is fixed in the picture.
pub(crate) fn hatched(
    densities: &Densities,
    canvas: &Canvas,
    map: &TonalArtMap,
    params: &StrokeParams,
    frame: &Frame,
    memory: &Memory,
) -> Plane {
    let families = canvas.directions.iter().enumerate();
    let families: Vec<_> = families
        .map(|(family, direction)| (Hatching::new(map, params, family), direction))
        .collect();
    let sheets = canvas.coordinates.as_ref();
    let sheets = sheets.map_or(vec![PlacedTexture::STILL], TextureCoordinates::sheets);
    let [ink] = map_rows(&frame.mask, memory, |y, [out]| {
        let mut pixels = Pixels::default();
        let mut lie = TexturePlacement::default();
        for run in frame.mask.runs(y) {
            for from in run.clone().step_by(BATCH) {
                let columns = from..(from + BATCH).min(run.end);
                pixels.count = columns.len();
                densities.row(&mut pixels.wanted[..columns.len()], y, columns.clone());
                if pixels.wanted[..columns.len()]
                    .iter()
                    .all(|&wanted| wanted <= 0.0)
                {
                    out[columns].fill(0.0);
                    continue;
                }
                pixels.white.fill(1.0);
                for sheet in &sheets {
                    if !sheet.is_used(y, columns.clone()) {
                        continue;
                    }
                    sheet.lay(&mut pixels, &mut lie, frame, y, columns.clone());
                    for (family, (hatching, direction)) in families.iter().enumerate() {
                        pixels.share(family, families.len());
                        sheet.take_share(&mut pixels, y, columns.clone());
                        let direction = [&direction.x, &direction.y]
                            .map(|plane| &plane.row(y)[columns.clone()]);
                        let direction = sheet.in_texture(direction, &mut lie);
                        wide!(hatch_batch(&mut pixels, direction, hatching));
                    }
                }
                for (out, white) in out[columns].iter_mut().zip(&pixels.white) {
                    *out = 1.0 - white;
                }
            }
        }
    });
    ink
}

/// Draws a batch along its directions.
#[inline(always)]
pub(crate) fn hatch_batch(pixels: &mut Pixels, [x, y]: [&[f32]; 2], hatching: &Hatching) {
    for i in 0..pixels.count {
        let angle = atan2(y[i], x[i]);
        pixels.angle[i] = if angle < 0.0 { angle + PI } else { angle };
    }
    hatching.draw(pixels);
}
