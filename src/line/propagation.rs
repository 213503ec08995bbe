//! Directions of surfaces seen in a mirror or lens, brought back to the picture ([LA] sections 5.3 and 5.4).
//!
//! Theory: the rays that leave at neighbouring pixels are a general linear camera whose plane lies in the back faces,
//! the external one; those inside are another, the internal one, whose plane lies in the front. The paper projects a
//! tangent at the hit point through the external camera onto the back faces, the result through the internal one onto
//! the front, and that onto the picture. Changes: the axes of both planes are the steps of their rays from pixel to
//! pixel, so an offset on either is directly an offset in pixels; the internal camera then adds nothing but errors of
//! its own order (measured on a ball of glass), and is left out. Steps are central differences where both neighbours exist, which is of
//! second order. Practice: [`external_camera`], and [`LocalCamera::seen`] for a tangent.

use super::linear_camera::LocalCamera;
use crate::frame::{Ray, SURFACE_JUMP};
use crate::trace::Path;

/// The paths of the adjacent pixels, where they exist.
#[derive(Debug, Clone, Copy, Default)]
pub struct Beside<'a> {
    /// Left and right.
    pub across: [Option<&'a Path>; 2],
    /// Below and above: y points up.
    pub up: [Option<&'a Path>; 2],
}

/// The camera of the rays that leave a mirror or lens: external refractions, or reflections. `None` if an axis has no
/// neighbour, or the surface is seen edge-on.
#[inline]
pub fn external_camera(here: &Path, beside: &Beside) -> Option<LocalCamera> {
    let own = here.leaving();
    let steps = [step(&own, beside.across)?, step(&own, beside.up)?];
    LocalCamera::new(own, steps)
}

/// Change of a ray from pixel to pixel, from the paths on both sides or on one.
fn step(own: &Ray, [before, after]: [Option<&Path>; 2]) -> Option<Ray> {
    let behind = before.map(|before| own.minus(&before.leaving()));
    let ahead = after.map(|after| after.leaving().minus(own));
    let (Some(behind), Some(ahead)) = (behind, ahead) else {
        return behind.or(ahead);
    };
    let (short, long) = (behind.start.length(), ahead.start.length());
    Some(if long > SURFACE_JUMP * short {
        behind
    } else if short > SURFACE_JUMP * long {
        ahead
    } else {
        Ray {
            start: 0.5 * (behind.start + ahead.start),
            direction: 0.5 * (behind.direction + ahead.direction),
        }
    })
}
