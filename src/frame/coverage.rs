//! Where a surface was seen: backgrounds and missing samples become the mask, and nothing else.

use super::depth::{HALF_INFINITY, is_distance};
use super::normals::MIN_LENGTH;
use super::{Mask, Plane, Vector3Planes};

/// The planes that coverage is read from.
pub(crate) struct Evidence<'a> {
    /// Decoded normals, not yet renormalised.
    pub(crate) normal: &'a Vector3Planes,
    pub(crate) depth: Option<&'a Plane>,
    /// Whether depth tells where nothing was seen.
    pub(crate) depth_tells: bool,
    pub(crate) alpha: Option<&'a Plane>,
    pub(crate) mask: Option<&'a Plane>,
}

/// Covered: the normal has a direction, depth is a distance, and the mask is above one half. Alpha
/// decides only where there is neither depth that tells nor a mask.
pub(crate) fn coverage(evidence: &Evidence) -> Mask {
    let normal = evidence.normal;
    let half = |plane: Option<&Plane>, x, y| plane.is_none_or(|p| p.at(x, y) > 0.5);
    let telling = evidence.depth.filter(|_| evidence.depth_tells);
    let deciding_alpha = match (telling, evidence.mask) {
        (None, None) => evidence.alpha,
        _ => None,
    };
    Mask::new(Plane::from_fn(
        normal.x.width(),
        normal.x.height(),
        |x, y| {
            let n = glam::Vec3::new(normal.x.at(x, y), normal.y.at(x, y), normal.z.at(x, y));
            n.is_finite()
                && n.length_squared() > MIN_LENGTH * MIN_LENGTH
                && n.length_squared().is_finite()
                && evidence.depth.is_none_or(|d| is_distance(d.at(x, y)))
                && half(evidence.mask, x, y)
                && half(deciding_alpha, x, y)
        },
    ))
}

/// The part of the mask where depth is a distance.
pub(crate) fn within(mask: &Mask, depth: &Plane) -> Mask {
    Mask::new(Plane::from_fn(mask.width(), mask.height(), |x, y| {
        mask.at(x, y) && is_distance(depth.at(x, y))
    }))
}

/// Gives every sample outside the mask the value 0, so that no NaN or sentinel travels on.
pub(crate) fn blank_outside(plane: &mut Plane, mask: &Mask) {
    for (sample, &covered) in plane.samples_mut().iter_mut().zip(mask.plane().samples()) {
        if !covered {
            *sample = 0.0;
        }
    }
}

/// Replaces what no picture can show: NaN by 0, infinities by the largest half float. Returns how
/// many samples there were.
pub(crate) fn sanitise(plane: &mut Plane) -> usize {
    let mut replaced = 0;
    for sample in plane.samples_mut().iter_mut().filter(|s| !s.is_finite()) {
        *sample = if sample.is_nan() {
            0.0
        } else {
            HALF_INFINITY.copysign(*sample)
        };
        replaced += 1;
    }
    replaced
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_without_direction_are_not_covered() {
        let x = vec![0.0, f32::NAN, f32::INFINITY, 1e30, 1.0, 0.01];
        let zero = Plane::filled(6, 1, 0.0);
        let normal = Vector3Planes {
            x: Plane::from_samples(6, 1, x),
            y: zero.clone(),
            z: zero,
        };
        let evidence = Evidence {
            normal: &normal,
            depth: None,
            depth_tells: true,
            alpha: None,
            mask: None,
        };
        assert_eq!(
            coverage(&evidence).row(0),
            [false, false, false, false, true, false]
        );
    }

    #[test]
    fn what_cannot_be_shown_is_replaced() {
        let mut plane =
            Plane::from_samples(4, 1, vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -2.0]);
        assert_eq!(sanitise(&mut plane), 3);
        assert_eq!(plane.row(0), [0.0, 65504.0, -65504.0, -2.0]);
    }
}
