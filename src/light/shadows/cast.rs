//! From a frame in new light to the shadows in it.

use super::casting::Caster;
use super::{Lamp, longest_px, shares};
use crate::engine::cpu::execution::Execution;
use crate::frame::{Frame, Plane, SightLines};
use crate::kernel::memory::Memory;
use crate::light::lights::{DirectionalLight, Illumination};
use crate::params::RelightParams;
use crate::plan::Plan;
use crate::plan::planned::Tile;
use crate::shape::occlusion::cpu::in_pixels;

/// A lamp and what arrives of its light.
pub(crate) struct Shadowed {
    pub(crate) light: DirectionalLight,
    /// The share of its light at each pixel, of [`WHOLE`].
    pub(crate) share: Plane<u16>,
}

/// A share of 1.
pub(crate) const WHOLE: f32 = 65_535.0;

/// What arrives of the light of each lamp far away, if shadows are cast.
pub(crate) fn cast(run: &mut Execution) -> Option<Vec<Shadowed>> {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let relighting = plan.relighting.as_ref()?;
    let caster = relighting.casting.by?;
    let illumination = run.inputs.illumination?;
    let own = run.outcome.shape.height.take();
    let shadowed = run.timed("shadows", || {
        let height = match (caster, &own) {
            (Caster::Normals, Some(height)) => in_pixels(height, frame),
            _ => heights_of_depth(frame),
        };
        lamps(illumination, &relighting.params)
            .map(|(light, lamp)| {
                let seen = over_frame(&height, &lamp, (plan, frame), memory);
                let fill = relighting.params.shadow_fill;
                let arrives = |seen: f32| (WHOLE * (fill + (1.0 - fill) * seen)).round() as u16;
                Shadowed {
                    light,
                    share: seen.map(arrives),
                }
            })
            .collect()
    });
    run.outcome.shape.height = own;
    Some(shadowed)
}

/// The lamps far away.
fn lamps<'i>(
    illumination: &'i Illumination,
    params: &'i RelightParams,
) -> impl Iterator<Item = (DirectionalLight, Lamp)> + 'i {
    let widths = illumination.widths_deg.iter().copied();
    let widths = widths.chain(std::iter::repeat(None));
    let lights = illumination.directional.iter().zip(widths);
    lights.map(|(light, width)| (*light, Lamp::of(light, width.unwrap_or(params.light_size))))
}

/// The share of a lamp seen from each pixel of a frame. One that repeats a tile is swept as the tile, with as much of its
/// repetition as shadows are long, but no more than once to every side.
fn over_frame(
    height: &Plane,
    lamp: &Lamp,
    (plan, frame): (&Plan, &Frame),
    memory: &Memory,
) -> Plane {
    let shape = SightLines::of(frame).pixel_shape().abs() as f32;
    let Some(Tile { window, .. }) = plan.tile else {
        return shares(height, lamp, shape, memory);
    };
    let tile = height.crop(frame.data_window, window);
    let most = window.width().max(window.height());
    let reach = longest_px(&tile, lamp).min(most as f32).ceil() as usize;
    let around = plan.tile.map_or(window, |tile| tile.grown(reach));
    let seen = shares(&tile.repeated(window, around), lamp, shape, memory);
    seen.crop(around, window)
        .repeated(window, frame.data_window)
}

/// Heights in pixels as depth tells them; in perspective at the distance of each pixel.
fn heights_of_depth(frame: &Frame) -> Plane {
    let (sight, depth) = (SightLines::of(frame), frame.depth.as_ref());
    let depth = depth.expect("the plan found it in the frame");
    let kind = frame.source.depth_kind;
    let window = frame.data_window;
    let mut heights = depth.clone();
    heights.each_row(|y, row| {
        for x in frame.mask.runs(y).flatten() {
            let at = window.middle(x, y);
            let point = sight.point(at.x, at.y, f64::from(row[x]), kind);
            row[x] = point.z as f32;
        }
    });
    in_pixels(&heights, frame)
}
