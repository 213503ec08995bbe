//! From stored components to unit normals in view space: encoding, flipped axes, length, rotation.

use super::plane::each_row_of;
use super::{Camera, Flip, NormalEncoding, NormalSpace, Plane, Vector3Planes, Window};
use glam::{DQuat, DVec2, DVec3, Mat3, Vec3};

/// Shorter normals, before normalisation, have no direction.
pub(crate) const MIN_LENGTH: f32 = 0.05;

/// Decodes components and flips axes, in place.
pub(crate) fn decode(stored: &mut Vector3Planes, encoding: NormalEncoding, flip: Flip) {
    if encoding == NormalEncoding::Unsigned {
        for components in stored.components_mut() {
            let is_written = is_written(components.each_ref().map(|code| **code));
            for code in components {
                *code = if is_written { 2.0 * *code - 1.0 } else { *code };
            }
        }
    }
    match encoding {
        NormalEncoding::Xy | NormalEncoding::Ag => with_rebuilt_z(stored),
        NormalEncoding::Oct => stored.components_mut().for_each(unfold),
        NormalEncoding::Signed | NormalEncoding::Unsigned => {}
    }
    flip_axes(stored, flip);
}

/// Whether stored codes were written: black marks a pixel that was not, not the direction (-1, -1, -1).
pub(crate) fn is_written(codes: [f32; 3]) -> bool {
    codes != [0.0; 3]
}

/// Sets z to what x and y leave of unit length, toward the viewer; 0 where they are longer.
pub(crate) fn with_rebuilt_z(normal: &mut Vector3Planes) {
    for [x, y, z] in normal.components_mut() {
        *z = (1.0 - *x * *x - *y * *y).max(0.0).sqrt();
    }
}

/// The direction whose octahedral coordinates are x and y: on |x| + |y| + |z| = 1, whose lower half is folded outward.
fn unfold([x, y, z]: [&mut f32; 3]) {
    *z = 1.0 - x.abs() - y.abs();
    let fold = (-*z).max(0.0);
    *x -= fold.copysign(*x);
    *y -= fold.copysign(*y);
}

/// Negates axes, in place.
pub(crate) fn flip_axes(normal: &mut Vector3Planes, flip: Flip) {
    let axes = [
        (&mut normal.x, flip.x),
        (&mut normal.y, flip.y),
        (&mut normal.z, flip.z),
    ];
    for (plane, _) in axes.into_iter().filter(|(_, flipped)| *flipped) {
        // Subtraction keeps 0 from becoming -0.
        plane.samples_mut().iter_mut().for_each(|v| *v = 0.0 - *v);
    }
}

/// Normalises every covered normal and zeroes all others. Returns the original lengths of the covered ones.
pub(crate) fn normalise(normal: &mut Vector3Planes, covered: &Plane<bool>) -> Plane {
    let mut lengths = Plane::filled(covered.width(), covered.height(), 0.0);
    let Vector3Planes { x, y, z } = normal;
    each_row_of([x, y, z, &mut lengths], |row, [x, y, z, lengths]| {
        normalise_row([x, y, z], covered.row(row), lengths);
    });
    lengths
}

/// The same in a row.
pub(crate) fn normalise_row([x, y, z]: [&mut [f32]; 3], covered: &[bool], lengths: &mut [f32]) {
    let vectors = x.iter_mut().zip(y).zip(z);
    let pixels = lengths.iter_mut().zip(covered);
    for (((x, y), z), (length, &covered)) in vectors.zip(pixels) {
        // Without branches, the compiler takes several at a time.
        let stored = Vec3::new(*x, *y, *z).length();
        let (has_direction, factor) = (covered & (stored > 0.0), stored.recip());
        for component in [x, y, z] {
            *component = if has_direction {
                *component * factor
            } else {
                0.0
            };
        }
        *length = if covered { stored } else { 0.0 };
    }
}

/// Rotates normals over `window` from their space to view space, in place.
pub(crate) fn turn_to_view(
    normal: &mut Vector3Planes,
    space: NormalSpace,
    camera: &Camera,
    window: Window,
) {
    let axes = camera.view_from_world.matrix3.to_cols_array();
    let from_world = Mat3::from_cols_array(&axes.map(|v| v as f32));
    let width = normal.x.width();
    for (i, components) in normal.components_mut().enumerate() {
        let stored = Vec3::from(components.each_ref().map(|v| **v));
        let turned = match space {
            NormalSpace::View => return,
            NormalSpace::World => from_world * stored,
            NormalSpace::Sight => {
                let place = window.middle(i % width, i / width);
                let lean = camera.projection.to_eye(place.x, place.y);
                from_sight_line(stored.as_dvec3(), lean).as_vec3()
            }
        };
        for (component, value) in components.into_iter().zip(turned.to_array()) {
            *component = value;
        }
    }
}

/// A normal in view space, of one that was turned with the direction to the eye to z; `lean` is that direction, scaled to
/// z = 1. One that points away is turned round.
pub(crate) fn from_sight_line(stored: DVec3, lean: DVec2) -> DVec3 {
    let eye = lean.extend(1.0).normalize();
    let facing = if stored.z < 0.0 { -stored } else { stored };
    DQuat::from_rotation_arc(DVec3::Z, eye) * facing
}

/// Unit vectors of `change` of each normal; 0 stays, where there is none.
#[cfg(feature = "cli")]
pub(super) fn changed(
    normal: &Vector3Planes,
    change: impl Fn(usize, usize, DVec3) -> DVec3,
) -> Vector3Planes {
    let (width, height) = (normal.x.width(), normal.x.height());
    Vector3Planes::from_fn(width, height, |x, y| match normal.at(x, y) {
        DVec3::ZERO => DVec3::ZERO,
        n => change(x, y, n).try_normalize().unwrap_or(n),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(normals: &[Vec3]) -> Vector3Planes {
        Vector3Planes::from_fn(normals.len(), 1, |x, _| normals[x].as_dvec3())
    }

    #[test]
    fn decoding_flips_and_normalises() {
        let mut stored = planes(&[Vec3::new(0.5, 0.75, 0.9), Vec3::ZERO, Vec3::splat(f32::NAN)]);
        decode(
            &mut stored,
            NormalEncoding::Unsigned,
            Flip {
                y: true,
                ..Flip::default()
            },
        );
        let covered = Plane::from_samples(3, 1, vec![true, false, false]);
        let length = normalise(&mut stored, &covered);
        // (0, 0.5, 0.8) with y flipped, of length 0.9434.
        assert!((length.at(0, 0) - 0.943_4).abs() < 1e-4);
        assert!((stored.y.at(0, 0) + 0.53).abs() < 1e-3 && stored.x.at(0, 0).abs() < 1e-6);
        for x in 1..3 {
            assert_eq!((stored.x.at(x, 0), length.at(x, 0)), (0.0, 0.0));
        }
    }
}
