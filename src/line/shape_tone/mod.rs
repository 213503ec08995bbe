//! Tone that shows shape: light and dark are distributed from paper to ink so that forms stand out, whatever the light of
//! the picture.
//!
//! Theory: three things stand between a picture and a drawing of it. The eye averages ink in linear light, so a tone as it
//! is to be *seen* has to be made linear before it becomes coverage. A picture's light may be flat, or fall from the wrong
//! side; a key light of the draughtsman's own shows the form in any case. And the tones of a subject fill a narrow range,
//! in which the contrast of small forms is lost among strokes: it is spread by rank, and raised within surfaces.
//!
//! Practice: everything is found on a grid of cells no finer than the forms that strokes can carry, so its cost does not
//! grow with the picture. Whatever spreads does so by the diffusion of the gradient, stopped by the same edges.

mod background;
pub(crate) mod cpu;
mod grain;
mod halo;
mod levels;
pub(crate) mod stage;

use crate::light::lights::direction_of;
use crate::line::smooth_step::smooth_step;
use glam::Vec3;

/// Where the key light stands if none is given: azimuth and elevation in degrees. Upper left, as draughtsmen have it.
pub(crate) const KEY_DEG: [f32; 2] = [135.0, 38.0];

/// Luminances below and above the median that count, in stops.
const STOPS: [f32; 2] = [-6.0, 4.0];

/// Anything darker than this in the key light is equally dark.
const DARKEST_KEY: f32 = 0.03;

/// Turns of the normal beyond this, in radians over the picture's size, are as telling as this.
const CLEAR_TURN: f32 = 30.0;

/// Between these tones strokes thin out, and leave the paper bare.
const BARE: [f32; 2] = [0.88, 0.97];

/// The key light's direction if none is given.
pub(crate) fn key_light() -> Vec3 {
    direction_of(KEY_DEG[0], KEY_DEG[1])
}

/// Luminance in stops about the median of the picture.
#[inline(always)]
pub(crate) fn stops(luminance: f32, median: f32) -> f32 {
    let ratio = luminance / median;
    // A NaN is black.
    if ratio > 0.0 {
        ratio.log2().clamp(STOPS[0], STOPS[1])
    } else {
        STOPS[0]
    }
}

/// Brightness in the key light, in stops: it wraps around the form, so that the shadow side keeps its shape. `toward` is
/// the cosine between normal and light, `kappa` the mapped curvature, convex positive.
#[inline(always)]
pub(crate) fn key_stops(toward: f32, kappa: f32) -> f32 {
    let lit = if toward > 0.0 {
        (toward + 0.25) / 1.25
    } else {
        0.2 * (1.5 * toward).exp()
    };
    lit.max(DARKEST_KEY).log2() + 0.57 * kappa
}

/// How much a place tells of shape, 0..1: `turn` is the mean turn of the normal around it, in radians over the picture's
/// size, at most 30, divided by 30.
#[inline(always)]
pub(crate) fn activity(turn: f32) -> f32 {
    smooth_step([0.02, 0.08], turn)
}

/// By how much local contrast is raised, where it is this large: to a quarter of the spread, at most threefold.
#[inline(always)]
pub(crate) fn raised(contrast: f32, activity: f32) -> f32 {
    1.0 + activity * (0.25 / contrast.max(0.06) - 0.4).clamp(0.0, 2.0)
}

/// The tone, as it is seen, of what has this rank among all, 0..1, and this place between the darkest and the lightest.
#[inline(always)]
pub(crate) fn seen_tone(rank: f32, place: f32) -> f32 {
    let by_rank = (0.045 + 0.955 * (rank / 0.745).powf(0.9)).min(1.0);
    let tone = 0.65 * by_rank + 0.35 * place.clamp(0.0, 1.0);
    lightened(tone, smooth_step(BARE, tone))
}

/// A tone with this share of its ink left out.
#[inline(always)]
pub(crate) fn lightened(tone: f32, share: f32) -> f32 {
    tone + share * (1.0 - tone)
}
