//! Every background of depth with every kind of depth.

use super::*;

/// A file with normals in view space, `background` where there is nothing, and this depth.
fn loaded(
    background: DVec3,
    stored: Stored,
    depth: &Plane,
    alpha: bool,
    given: Option<StoredDepth>,
) -> Loaded {
    let part = Part::new(display()).channel("depth.Z", stored, depth);
    let normals = normals(background, |n| n);
    let mut part = with_layer(part, ("N", XYZ, Stored::Float), &normals);
    if alpha {
        for name in ["R", "G", "B", "A"] {
            part = part.channel(name, Stored::Half, &truth().alpha());
        }
    }
    read(&[part], |inputs, needs| {
        (inputs.depth_kind, needs.projection) = (given, true)
    })
}

/// Something of planar depth and distance along the sight line.
type Value = fn(f64, f64) -> f64;

const NOWHERE: [f64; 7] = [0.0, 1e10, 1e30, 1e38, f64::INFINITY, f64::NAN, -1.0];

#[rustfmt::skip]
const KINDS: [(StoredDepth, Value, &[f64]); 5] = [
    (StoredDepth::Planar, |z, _| z, &NOWHERE),
    (StoredDepth::Ray, |_, distance| distance, &NOWHERE),
    (StoredDepth::Inverse, |z, _| 1.0 / z, &[0.0, f64::NAN]),
    // The scene reaches from 3.3 to 8.7.
    (StoredDepth::WhiteFar, |z, _| ((z - 3.8) / 4.0).clamp(0.0, 1.0), &[0.0, 1.0]),
    (StoredDepth::NormalizedNearIsOne, |z, _| ((7.8 - z) / 4.0).clamp(0.0, 1.0), &[0.0, 1.0]),
];

#[test]
fn each_background_with_each_kind() {
    let truth = truth();
    for (kind, value, backgrounds) in KINDS {
        for &background in backgrounds {
            for given in [None, Some(kind)] {
                let case = format!("{kind:?} on {background}, given {given:?}");
                let depth = truth.depth(background, value);
                let frame = loaded(DVec3::ZERO, Stored::Float, &depth, false, given);
                assert_eq!(frame.conventions.depth_kind, Some(kind), "{case}");
                assert_eq!(frame.frame.source.depth_kind, kind.kind(), "{case}");
                assert_eq!(truth.mask_errors(&frame.frame), 0, "{case}");
                if kind.kind() != DepthKind::Relative {
                    let off = truth.worst_depth(&frame.frame, kind == StoredDepth::Ray, 1.0);
                    assert!(off < 1e-6, "{case}: {off}");
                }
            }
            // In half floats every infinity is 65504 or inf; such depth gives no positions.
            let depth = truth.depth(background.min(65504.0), value);
            let frame = loaded(DVec3::ZERO, Stored::Half, &depth, false, None);
            assert_eq!(truth.mask_errors(&frame.frame), 0, "{kind:?}, half");
            assert_eq!(frame.frame.source.depth_kind, DepthKind::Relative);
        }
    }
}

#[test]
fn depth_or_alpha_tells_coverage_where_normals_do_not() {
    let (truth, filler) = (truth(), DVec3::Z);
    for (i, (kind, value, backgrounds)) in KINDS.iter().enumerate() {
        // Shades of grey are depth everywhere.
        let alpha = i >= 3;
        for &background in *backgrounds {
            let depth = truth.depth(background, value);
            let frame = loaded(filler, Stored::Float, &depth, alpha, Some(*kind)).frame;
            assert_eq!(truth.mask_errors(&frame), 0, "{kind:?} on {background}");
        }
    }
}
