//! Conventions found for one frame, forced on it: the same frame, bit for bit.

use super::truth::{display, truth};
use crate::common::exr::{Part, Stored, write};
use glam::DVec3;
use relievo::frame::{Frame, NormalSpace, Plane};
use relievo::io::inputs::{Conventions, Flip, Inputs, NormalEncoding, StoredDepth};
use relievo::io::{self, Needs};
use std::path::Path;

/// All samples of a frame that conventions affect.
fn bits(frame: &Frame) -> Vec<u32> {
    let n = &frame.normal;
    let planes = [Some(&n.x), Some(&n.y), Some(&n.z), frame.depth.as_ref()];
    let samples = |plane: &Plane| plane.samples().to_vec();
    planes
        .into_iter()
        .flatten()
        .flat_map(samples)
        .map(f32::to_bits)
        .collect()
}

/// The conventions of a file, which must give the same frame when forced.
fn forced(path: &Path, needs: Needs) -> Conventions {
    let mut inputs = Inputs {
        picture: path.to_path_buf(),
        ..Inputs::default()
    };
    let first = io::load(&inputs, needs).unwrap();
    first.conventions.force(&mut inputs);
    let second = io::load(&inputs, needs).unwrap();
    assert_eq!(first.conventions, second.conventions);
    assert!(first.frame.mask == second.frame.mask);
    assert_eq!(first.frame.camera, second.frame.camera);
    assert_eq!(
        first.frame.source.depth_kind,
        second.frame.source.depth_kind
    );
    assert!(bits(&first.frame) == bits(&second.frame));
    first.conventions
}

#[test]
fn what_was_concluded_can_be_forced() {
    let (truth, desk) = (truth(), tempfile::tempdir().unwrap());
    let path = desk.path().join("a.exr");
    let depth = truth.depth(1e10, |z, _| z);
    // Camera space with z away from the viewer, written as 0..1.
    let encoded = |n: DVec3| 0.5 * DVec3::new(n.x, n.y, -n.z) + 0.5;
    let view = [0, 1, 2].map(|axis| truth.normal(axis, 0.0, encoded));
    // World space, with positions to find the camera by.
    let to_world = truth.camera.inverse();
    let world = [0, 1, 2].map(|axis| truth.normal(axis, 0.0, |n| to_world.transform_vector3(n)));
    let place = [0, 1, 2].map(|axis| truth.point(axis, 0.0, |p| to_world.transform_point3(p)));
    let file = |normal: &[Plane; 3], position: Option<&[Plane; 3]>| {
        let mut part = Part::new(display()).channel("Z", Stored::Float, &depth);
        for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            part = part.channel(&format!("N.{name}"), Stored::Float, &normal[axis]);
            if let Some(position) = position {
                part = part.channel(&format!("P.{name}"), Stored::Float, &position[axis]);
            }
        }
        write(&path, display(), &[part]);
    };
    let placed = Needs {
        projection: true,
        ..Needs::default()
    };
    file(&view, None);
    for needs in [Needs::default(), placed] {
        let found = forced(&path, needs);
        let expected = Conventions {
            normal_space: NormalSpace::View,
            normal_encoding: NormalEncoding::Unsigned,
            normal_flip: Flip {
                z: true,
                ..Flip::NONE
            },
            depth_kind: Some(StoredDepth::Planar),
        };
        assert_eq!(found, expected);
    }
    file(&world, Some(&place));
    let found = forced(&path, placed);
    assert_eq!(found.normal_space, NormalSpace::World);
    assert_eq!(found.normal_flip, Flip::NONE);
}
