//! From a frame with its height to the sky it sees.

use super::{NOTHING, Sky, sky};
use crate::frame::{Frame, Mask, Plane, Projection, SightLines};
use crate::plan::Plan;
use crate::plan::execution::Execution;

/// How far whole pixels may hide the sky.
pub(super) fn radius_px(plan: &Plan) -> usize {
    plan.shape.occlusion_radius.ceil() as usize
}

/// The sky seen from each pixel.
pub(super) fn find_sky(run: &mut Execution) {
    let (plan, frame) = (run.plan, run.frame);
    let height = run.made.outcome.shape.height.take();
    let known = height.as_ref().expect("occlusion takes the height");
    let Sky { seen, bent } = run.timed("occlusion", || {
        let pixels = in_pixels(known, frame);
        let shape = &plan.shape;
        let (radius, slices) = (shape.occlusion_radius, shape.occlusion_slices);
        match plan.tile {
            None => sky(&pixels, &frame.normal, &frame.mask, radius, slices),
            Some(tile) => {
                let (whole, around) = (frame.data_window, tile.grown(radius_px(plan)));
                let repeated = |plane: &Plane| {
                    let own = plane.crop(whole, tile.window);
                    own.repeated(tile.window, around)
                };
                let covered = frame.mask.plane().crop(whole, tile.window);
                let mask = Mask::new(covered.moved(tile.window, around, false));
                let normal = frame.normal.mapped(repeated);
                let found = sky(&repeated(&pixels), &normal, &mask, radius, slices);
                found.mapped(|plane| plane.crop(around, tile.window).repeated(tile.window, whole))
            }
        }
    });
    let shape = &mut run.made.outcome.shape;
    (shape.height, shape.sky, shape.bent) = (height, Some(seen), Some(bent));
}

/// The height in pixels, whatever its unit; in perspective at the distance of each pixel.
pub(crate) fn in_pixels(height: &Plane, frame: &Frame) -> Plane {
    let has_depth = frame.depth.is_some() && frame.camera.is_some();
    let projection = SightLines::of(frame).projection();
    let mut pixels = height.clone();
    pixels.each_with(frame.mask.plane(), |height, covered| {
        *height = match projection {
            _ if !covered => NOTHING,
            Projection::Orthographic { sx, sy, .. } => *height * (sx * sy).sqrt() as f32,
            Projection::Perspective { fx, fy, .. } => {
                let focal_px = (fx * fy).sqrt() as f32;
                match has_depth && *height < 0.0 {
                    true => -focal_px * (-*height).ln(),
                    false => -focal_px * (-*height / focal_px).ln_1p(),
                }
            }
        };
    });
    pixels
}
