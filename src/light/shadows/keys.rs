//! The lights of an environment that are so bright that their shadows have edges, as that of the sun: they have sweeps of
//! their own.

use super::cast::Shadowed;
use crate::frame::{Plane, luminance};
use crate::light::lights::DirectionalLight;
use glam::Vec3;

/// The least share of all light that a key has, and how many there are at most.
const KEY_SHARE: f32 = 0.04;
pub(crate) const MOST_KEYS: usize = 4;

/// Cosine of the angle around a key within which lights belong to it, 2 degrees: what is brighter than one light may be is
/// several, side by side.
const WITHIN: f32 = 0.9994;

/// The keys among these lights, the brightest first: each is the brightest of the lights that belong to it.
pub(super) fn keys(lights: &[DirectionalLight], weights: [f32; 3]) -> Vec<DirectionalLight> {
    let of = |light: &DirectionalLight| luminance(light.intensity, weights);
    let all: f32 = lights.iter().map(of).sum();
    let mut rest: Vec<_> = lights.iter().filter(|light| of(light) > 0.0).collect();
    rest.sort_by(|a, b| of(b).total_cmp(&of(a)));
    let mut keys = Vec::new();
    while let (Some(first), true) = (rest.first().copied(), keys.len() < MOST_KEYS) {
        let own: Vec<_>;
        (own, rest) =
            (rest.into_iter()).partition(|light| light.to_light.dot(first.to_light) >= WITHIN);
        let has_share = own.iter().copied().map(of).sum::<f32>() >= KEY_SHARE * all;
        // What shines from behind the picture plane hardly reaches it.
        if has_share && first.to_light.z > 0.0 {
            keys.push(*first);
        }
    }
    keys
}

/// What arrives of light from this direction, if a key's does.
#[inline(always)]
pub(crate) fn share_of(keys: &[Shadowed], direction: [f32; 3]) -> Option<&Plane<u16>> {
    let direction = Vec3::from(direction);
    let key = keys
        .iter()
        .find(|key| key.light.to_light.dot(direction) >= WITHIN);
    key.map(|key| &key.share)
}
