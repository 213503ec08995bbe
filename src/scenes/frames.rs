//! Frames defined sample by sample.

use crate::frame::{ColorPlanes, Frame, Mask, Plane, Vector3Planes};
use glam::Vec3;

/// Deterministic pseudo-random numbers, 0..1.
pub fn noise(x: usize, y: usize, channel: u32) -> f32 {
    let seed = (x as u32).wrapping_mul(0x9e37_79b9)
        ^ (y as u32).wrapping_mul(0x85eb_ca6b)
        ^ channel.wrapping_mul(0xc2b2_ae35);
    let mixed = (seed ^ (seed >> 15)).wrapping_mul(0x2c1b_3c6d);
    let mixed = (mixed ^ (mixed >> 12)).wrapping_mul(0x297a_2d39);
    (mixed ^ (mixed >> 15)) as f32 / u32::MAX as f32
}

/// Planes of the normals `at`.
pub fn normals(width: usize, height: usize, at: impl Fn(usize, usize) -> Vec3) -> Vector3Planes {
    let plane = |axis: usize| Plane::from_fn(width, height, |x, y| at(x, y)[axis]);
    Vector3Planes {
        x: plane(0),
        y: plane(1),
        z: plane(2),
    }
}

/// The frame covered only where `covered` is true.
pub fn masked(frame: Frame, covered: impl FnMut(usize, usize) -> bool) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    Frame {
        mask: Mask::new(Plane::from_fn(width, height, covered)),
        ..frame
    }
}

/// The frame with a uniform grey picture.
pub fn grey(frame: Frame, tone: f32) -> Frame {
    let even = Plane::filled(frame.mask.width(), frame.mask.height(), tone);
    Frame {
        color: Some(ColorPlanes::grey(even)),
        ..frame
    }
}
