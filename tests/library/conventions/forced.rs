//! Conventions found for one frame, forced on it: the same frame, bit for bit.

use super::*;

/// All samples of a frame that conventions affect.
fn samples(frame: &Frame) -> Vec<Vec<u32>> {
    let n = &frame.normal;
    let planes = [&n.x, &n.y, &n.z].into_iter().chain(&frame.depth);
    planes.map(bits).collect()
}

/// The conventions of a file, which must give the same frame when forced.
fn forced(part: &Part, projection: bool) -> Conventions {
    let parts = [part.clone()];
    let first = read(&parts, |_, needs| needs.projection = projection);
    let second = read(&parts, |inputs, needs| {
        first.conventions.force(inputs);
        needs.projection = projection;
    });
    assert_eq!(first.conventions, second.conventions);
    let (a, b) = (&first.frame, &second.frame);
    assert!(a.mask == b.mask && a.camera == b.camera);
    assert_eq!(a.source.depth_kind, b.source.depth_kind);
    assert!(samples(a) == samples(b));
    first.conventions
}

#[test]
fn what_was_concluded_can_be_forced() {
    let truth = truth();
    let layer =
        |part, name, planes: &[Plane; 3]| with_layer(part, (name, XYZ, Stored::Float), planes);
    let depth = truth.depth(1e10, |z, _| z);
    let deep = Part::new(display()).channel("Z", Stored::Float, &depth);
    // Camera space with z away from the viewer, written as 0..1.
    let encoded = |n: DVec3| 0.5 * DVec3::new(n.x, n.y, -n.z) + 0.5;
    let view = layer(deep.clone(), "N", &normals(DVec3::ZERO, encoded));
    let expected = Conventions {
        normal_space: NormalSpace::View,
        normal_encoding: NormalEncoding::Unsigned,
        normal_flip: Flip {
            z: true,
            ..Flip::NONE
        },
        depth_kind: Some(StoredDepth::Planar),
    };
    for projection in [false, true] {
        assert_eq!(forced(&view, projection), expected);
    }
    // World space, with positions to find the camera by.
    let to_world = truth.camera.inverse();
    let world = normals(DVec3::ZERO, |n| to_world.transform_vector3(n));
    let place = [0, 1, 2].map(|axis| truth.point(axis, 0.0, |p| to_world.transform_point3(p)));
    let found = forced(&layer(layer(deep, "N", &world), "P", &place), true);
    assert_eq!(found.normal_space, NormalSpace::World);
    assert_eq!(found.normal_flip, Flip::NONE);
}
