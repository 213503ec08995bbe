//! The lights of an environment that are so bright that their shadows have edges, as that of the sun: they have sweeps of
//! their own.

use crate::frame::luminance;
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
    // What shines from behind the picture plane hardly reaches it.
    let shines = |light: &&DirectionalLight| of(light) > 0.0 && light.to_light.z > 0.0;
    let mut rest: Vec<_> = lights.iter().filter(shines).collect();
    rest.sort_by(|a, b| of(b).total_cmp(&of(a)));
    let mut keys = Vec::new();
    while let (Some(first), true) = (rest.first().copied(), keys.len() < MOST_KEYS) {
        let own: Vec<_>;
        let is_own = |light: &&DirectionalLight| belongs(first, light.to_light);
        (own, rest) = rest.into_iter().partition(is_own);
        if own.into_iter().map(of).sum::<f32>() >= KEY_SHARE * all {
            keys.push(*first);
        }
    }
    keys
}

/// Whether light from this direction belongs to a key.
pub(super) fn belongs(key: &DirectionalLight, direction: impl Into<Vec3>) -> bool {
    key.to_light.dot(direction.into()) >= WITHIN
}
