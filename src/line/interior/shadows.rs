//! Edges of cast shadows: where light changes by more than the turn of the surface accounts for.

use crate::frame::memory::Memory;
use crate::frame::percentile::percentile;
use crate::frame::rows::map_covered;
use crate::frame::{ColorPlanes, Frame, Mask, Plane, luminance};
use crate::line::grid::Grid;
use crate::line::interior::crests::{Crest, FormRims, crest, each_pixel};
use crate::line::interior::level::FormLevel;
use crate::line::interior::sizes::Sizes;
use crate::params::RunOptions;
use glam::Vec2;

/// Albedo below which the light is hardly known.
const LEAST_ALBEDO: f32 = 0.02;

/// Light on a matt surface, as a part of the full light, changes at most by the turn of its normal; on a shiny one it
/// changes by more.
const ACCOUNTED: f32 = 2.0;

/// Percentile of a surface's light taken as the full light.
const FULL: u32 = 95;

/// The crests of the rate at which light changes, beyond the change explained by the turn of normals, `curvature` in
/// radians per pixel. Their strength is that change in parts of the full light, over the picture.
pub(super) fn shadows(
    frame: &Frame,
    level: &FormLevel,
    curvature: &Plane,
    rims: &FormRims,
    sizes: &Sizes,
    options: &RunOptions,
    memory: &Memory,
) -> Vec<Crest> {
    let (mask, memory) = (&level.frame.mask, memory.at_other_size());
    let Some(light) = light(frame, sizes.factor, &memory) else {
        return Vec::new();
    };
    let full = percentile(mask, FULL, |x, y| Some(light.at(x, y))).unwrap_or(0.0);
    if full <= 0.0 {
        return Vec::new();
    }
    let light = level.spread_scalar(light, sizes.sigma, options, &memory);
    let slope = |x: usize, y: usize| slope(&light, mask, x, y) / full;
    let [steep] = map_covered(mask, &memory, |y| {
        let curvature = curvature.row(y);
        move |x| [(slope(x, y).length() - ACCOUNTED * curvature[x]).max(0.0)]
    });
    each_pixel(mask, |x, y| {
        let strength = steep.at(x, y) * sizes.picture;
        if strength < sizes.thresholds[0] || rims.is_near(x, y) {
            return None;
        }
        crest(&steep, x, y, slope(x, y).try_normalize()?, || strength)
    })
}

/// The incident light on blocks of a frame, or the reflected light if their albedo is unknown; `None` without a
/// picture.
fn light(frame: &Frame, factor: usize, memory: &Memory) -> Option<Plane> {
    let color = frame.color.as_ref()?;
    let weights = frame.luminance_weights();
    let [light] = Grid::new(&frame.mask, factor).means(&frame.mask, memory, |y| {
        let (color, albedo) = (
            rows(color, y),
            frame.albedo.as_ref().map(|albedo| rows(albedo, y)),
        );
        let at = move |rows: [&[f32]; 3], x: usize| luminance(rows.map(|row| row[x]), weights);
        move |x| {
            let albedo = albedo.map_or(1.0, |albedo| at(albedo, x));
            let light = at(color, x) / albedo.max(LEAST_ALBEDO);
            [if light.is_finite() { light } else { 0.0 }]
        }
    });
    Some(light)
}

fn rows(planes: &ColorPlanes, y: usize) -> [&[f32]; 3] {
    [&planes.r, &planes.g, &planes.b].map(|plane| plane.row(y))
}

/// The slope of a plane at a pixel, x right and y up; beyond the mask it is level.
fn slope(plane: &Plane, mask: &Mask, x: usize, y: usize) -> Vec2 {
    let at = |dx: isize, dy: isize| {
        let (bx, by) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
        if mask.has(bx, by) {
            plane.at(bx, by)
        } else {
            plane.at(x, y)
        }
    };
    0.5 * Vec2::new(at(1, 0) - at(-1, 0), at(0, -1) - at(0, 1))
}
