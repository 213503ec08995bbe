//! From stored depth, or positions, to distances from the viewer.

use super::{Camera, Plane, StoredDepth, Vector3Planes};

/// Infinity clamped to a half float.
pub(crate) const HALF_INFINITY: f32 = 65504.0;

/// Renderers write distances from here up (1e10, 1e30, 1e38) where nothing was seen.
const BACKGROUND_DEPTH: f32 = 1e9;

/// Whether a depth sample is a distance rather than a background value: 0, negative, not finite, 65504 (infinity
/// clamped to half float) or 1e9 and above.
#[inline(always)]
pub(crate) fn is_distance(depth: f32) -> bool {
    depth > 0.0 && depth < BACKGROUND_DEPTH && depth != HALF_INFINITY
}

/// [`Source::depth_rounding`](super::Source::depth_rounding) of half floats, or of samples whose codes are this far apart
/// half of the way from -1 to 1.
pub(crate) fn depth_rounding(is_half: bool, of_signed: f32) -> [f32; 2] {
    match is_half {
        true => [f32::from(half::f16::EPSILON) / 2.0, 0.0],
        false => [0.0, of_signed / 2.0],
    }
}

/// Distances along the view axis of world-space positions; 0 without one.
pub(crate) fn depth_of_positions(positions: &Vector3Planes, camera: &Camera) -> Plane {
    let (width, height) = (positions.x.width(), positions.x.height());
    Plane::from_fn(width, height, |x, y| {
        let position = camera.view_from_world.transform_point3(positions.at(x, y));
        let depth = -position.z as f32;
        if depth.is_finite() { depth } else { 0.0 }
    })
}

/// Converts stored depth to values that increase with distance, in place: positive, 0 where the layer marks that
/// nothing was seen.
pub(crate) fn to_distances(depth: &mut Plane, stored: StoredDepth) {
    // Mapped between 1 and 2, so that a jump by the same share of the range counts about equally near and far.
    let normalized = |d: f32, from: f32, toward: f32| match d.is_nan() {
        true => 0.0,
        false => from + toward * d.clamp(0.0, 1.0),
    };
    let most = depth
        .samples()
        .iter()
        .copied()
        .filter(|d| d.is_finite())
        .fold(0.0, f32::max);
    for d in depth.samples_mut() {
        *d = match stored {
            StoredDepth::Planar | StoredDepth::Ray | StoredDepth::Relative => return,
            StoredDepth::Inverse if *d > 0.0 => 1.0 / *d,
            StoredDepth::Inverse => 0.0,
            StoredDepth::WhiteFar => normalized(*d, 1.0, 1.0),
            StoredDepth::NormalizedNearIsOne => normalized(*d, 2.0, -1.0),
            // The highest a pixel away.
            StoredDepth::Height if d.is_finite() => 1.0 + (most - *d),
            StoredDepth::Height => 0.0,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_known_background_is_no_distance() {
        let sentinels = [
            0.0,
            -1.0,
            1e10,
            1e30,
            1e38,
            65504.0,
            f32::INFINITY,
            f32::NAN,
            -0.0,
        ];
        assert!(sentinels.iter().all(|&depth| !is_distance(depth)));
        assert!(
            [1e-6, 1.0, 65503.0, 1e6]
                .iter()
                .all(|&depth| is_distance(depth))
        );
    }
}
