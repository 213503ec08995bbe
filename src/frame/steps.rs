//! Steps between the samples of neighbouring pixels.

use glam::DVec3;

/// A step to one side this many times longer than the step to the other side leads to another surface.
pub(crate) const SURFACE_JUMP: f64 = 3.0;

/// How a point of a surface changes per pixel, from its neighbours on both sides: half the difference between them if
/// the surface continues on both, else the step to the side where it continues. `None` without neighbours.
#[inline]
pub(crate) fn step_between(
    before: Option<DVec3>,
    here: DVec3,
    after: Option<DVec3>,
) -> Option<DVec3> {
    let (Some(before), Some(after)) = (before, after) else {
        return before.map(|p| here - p).or(after.map(|p| p - here));
    };
    let (behind, ahead) = (here - before, after - here);
    let (short, long) = (behind.length(), ahead.length());
    Some(if long > SURFACE_JUMP * short {
        behind
    } else if short > SURFACE_JUMP * long {
        ahead
    } else {
        0.5 * (after - before)
    })
}
