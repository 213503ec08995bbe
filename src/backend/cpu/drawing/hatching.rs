//! Strokes over the frame, row by row.

use super::tone::Densities;
use super::{Memory, Plane, TonalArtMap};
use crate::backend::cpu::passes::map_rows;
use crate::fast_math::atan2;
use crate::frame::{Frame, Vector2Planes};
use crate::line::hatching::Hatching;
use crate::params::StrokeParams;
use glam::Vec2;
use std::f32::consts::PI;

/// How much of the paper strokes cover.
pub(super) fn hatched(
    densities: &Densities,
    direction: &Vector2Planes,
    map: &TonalArtMap,
    params: &StrokeParams,
    frame: &Frame,
    memory: &Memory,
) -> Plane {
    let hatching = Hatching::new(map, params, 0);
    let window = frame.data_window;
    let [ink] = map_rows(&frame.mask, memory, |y, [out]| {
        for run in frame.mask.runs(y) {
            let out = &mut out[run.clone()];
            densities.row(out, y, run.clone());
            let [tx, ty] = [&direction.x, &direction.y].map(|plane| &plane.row(y)[run.clone()]);
            let row = (window.y0 as f32) + y as f32 + 0.5;
            for (i, out) in out.iter_mut().enumerate() {
                let angle = atan2(ty[i], tx[i]);
                let angle = if angle < 0.0 { angle + PI } else { angle };
                let p = Vec2::new(window.x0 as f32 + (run.start + i) as f32 + 0.5, row);
                *out = 1.0 - hatching.white(p, angle, *out);
            }
        }
    });
    ink
}
