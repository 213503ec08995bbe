//! Strokes over the frame, row by row.

use super::tone::Densities;
use super::{Memory, Plane, TonalArtMap};
use crate::backend::cpu::passes::map_rows;
use crate::backend::cpu::simd::Simd;
use crate::fast_math::atan2;
use crate::frame::{Frame, Vector2Planes};
use crate::line::hatching::{BATCH, Hatching, Pixels};
use crate::params::StrokeParams;
use std::f32::consts::PI;

/// How much of the paper strokes cover.
pub(super) fn hatched(
    densities: &Densities,
    directions: &[Vector2Planes],
    map: &TonalArtMap,
    params: &StrokeParams,
    frame: &Frame,
    memory: &Memory,
) -> Plane {
    let families = directions.iter().enumerate();
    let families: Vec<_> = families
        .map(|(family, direction)| (Hatching::new(map, params, family), direction))
        .collect();
    let simd = Simd::widest();
    let [ink] = map_rows(&frame.mask, memory, |y, [out]| {
        let mut pixels = Pixels::default();
        for run in frame.mask.runs(y) {
            for from in run.clone().step_by(BATCH) {
                let columns = from..(from + BATCH).min(run.end);
                pixels.count = columns.len();
                densities.row(
                    &mut pixels.wanted[..columns.len()],
                    y,
                    columns.clone(),
                    simd,
                );
                pixels.white.fill(1.0);
                place(&mut pixels, frame, y, columns.start);
                for (family, (hatching, direction)) in families.iter().enumerate() {
                    pixels.share(family, families.len());
                    let direction =
                        [&direction.x, &direction.y].map(|plane| &plane.row(y)[columns.clone()]);
                    simd.hatch_batch(&mut pixels, direction, hatching);
                }
                for (out, white) in out[columns].iter_mut().zip(&pixels.white) {
                    *out = 1.0 - white;
                }
            }
        }
    });
    ink
}

/// Puts the texture still in the picture, whatever part of it the frame holds.
fn place(pixels: &mut Pixels, frame: &Frame, y: usize, from: usize) {
    let window = frame.data_window;
    let [xs, ys] = &mut pixels.place;
    let first = window.x0 as f32 + from as f32 + 0.5;
    for (i, x) in xs.iter_mut().enumerate() {
        *x = first + i as f32;
    }
    ys.fill(window.y0 as f32 + y as f32 + 0.5);
}

/// Draws a batch along its directions.
#[inline(always)]
pub(in crate::backend::cpu) fn hatch_batch(
    pixels: &mut Pixels,
    [x, y]: [&[f32]; 2],
    hatching: &Hatching,
) {
    for i in 0..pixels.count {
        let angle = atan2(y[i], x[i]);
        pixels.angle[i] = if angle < 0.0 { angle + PI } else { angle };
    }
    hatching.draw(pixels);
}
